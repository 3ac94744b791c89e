"""Every registered place keeps the laws of `multilayer.testing`."""

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.places import PLACES, Place
from multilayer.testing import check_place


@pytest.mark.parametrize("name", PLACES.names())
def test_a_place_keeps_the_laws(name):
    check_place(PLACES[name])
    assert PLACES[name].name == name


def test_effects_of_the_rig_name_a_place():
    places = {name: EFFECTS[name].place for name in EFFECTS.names() if hasattr(EFFECTS[name], "place")}
    assert {place for place in places.values() if place} <= set(PLACES.names())
    assert places["sensor_mass"] == "top_plate"
    assert places["skin"] == "faces"


class Nowhere(Place):
    name = "nowhere"
    title = "nowhere"
    quantity = "nothing"


class NotAnalytic(Nowhere):
    def motion(self, setting, motion, values):
        return motion * (1 + values.real)


class Constant(Nowhere):
    def motion(self, setting, motion, values):
        return motion * (1.01 + values)


@pytest.mark.parametrize(
    ("place", "law"),
    [(Nowhere, "acts"), (NotAnalytic, "is analytic"), (Constant, "nothing without a law")],
)
def test_a_place_that_breaks_a_law_is_told(place, law):
    with pytest.raises(AssertionError, match=law):
        check_place(place)


def test_a_place_without_a_name():
    class Silent(Nowhere):
        title = ""

        def motion(self, setting, motion, values):
            return np.asarray(motion * (1 + values))

    with pytest.raises(AssertionError, match="says what it is: the class needs a 'title'"):
        check_place(Silent)
