"""Every registered place keeps the laws of `multilayer.testing`."""

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.places import LEVEL_PLACES, PLACES, TUBE_PLACES, Place
from multilayer.testing import check_place


@pytest.mark.parametrize("name", PLACES.names())
def test_a_place_keeps_the_laws(name):
    check_place(PLACES[name])
    assert {kind.name for kind in PLACES[name].variants()} == {name}


@pytest.mark.parametrize("name", TUBE_PLACES.names())
def test_a_place_of_a_tube_keeps_the_laws(name):
    check_place(TUBE_PLACES[name])
    assert TUBE_PLACES[name].name == name


@pytest.mark.parametrize("name", LEVEL_PLACES.names())
def test_a_place_of_a_construction_keeps_the_laws(name):
    check_place(LEVEL_PLACES[name])
    assert LEVEL_PLACES[name].name == name


@pytest.mark.parametrize(
    ("kind", "known"), [("two-plate rig", PLACES), ("tube", TUBE_PLACES), ("levels", LEVEL_PLACES)]
)
def test_effects_name_a_place_of_their_kind(kind, known):
    named = {EFFECTS[name].place for name in EFFECTS.names() if EFFECTS[name].kind == kind}
    assert named - {""} <= set(known.names())


def test_effects_of_the_rig_name_a_place():
    places = {name: EFFECTS[name].place for name in EFFECTS.names() if hasattr(EFFECTS[name], "place")}
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


def test_a_place_made_of_another_one_has_its_own_variants():
    class Foreign(PLACES["top_plate"]):
        name = "foreign"

    with pytest.raises(AssertionError, match="its variants have the name top_plate; override 'variants'"):
        check_place(Foreign)


def test_a_place_without_a_name():
    class Silent(Nowhere):
        title = ""

        def motion(self, setting, motion, values):
            return np.asarray(motion * (1 + values))

    with pytest.raises(AssertionError, match="says what it is: the class needs a 'title'"):
        check_place(Silent)
