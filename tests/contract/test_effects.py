"""Every registered effect, those of plugins included, keeps the laws of `multilayer.testing`."""

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS, Effect
from multilayer.diagnosis.effects.base import positive
from multilayer.testing import check_effect

# the effects of the two-plate rig in ../shared/GAP.md
NAMES = {
    "finite_size", "sensor_mass", "adhesive", "channel_gain", "channel_delay", "high_pass", "crosstalk", "preload",
    "saturating_air", "dispersion", "plate_flexure", "sensor_mount", "rocking", "delamination", "skin",
    "amplitude_softening", "temperature_drift", "flanking",
}  # fmt: skip


def test_all_effects_of_the_rig_are_there():
    assert set(EFFECTS.names()) >= NAMES


@pytest.mark.parametrize("name", EFFECTS.names())
def test_an_effect_keeps_the_laws(name):
    check_effect(EFFECTS[name])
    assert EFFECTS[name].name == name


class Silent(Effect):
    name = "silent"
    law = "nothing"
    separated_by = "nothing"
    source = "nowhere"
    parameters = (positive("size", 1.0, 1.0),)


class Jump(Silent):
    def motion(self, setting, motion, values):
        return motion * 2


class Inplace(Silent):
    def motion(self, setting, motion, values):
        motion *= 1 + values["size"]
        return motion


class Mixed(Silent):
    def motion(self, setting, motion, values):
        return motion * (1 + np.mean(values["size"]) * 1e-3)


class Nameless(Silent):
    law = ""


@pytest.mark.parametrize(
    ("effect", "word"),
    [
        (Silent, "changes nothing"),
        (Jump, "still changes"),
        (Inplace, "changed in place"),
        (Mixed, "other motions than one by one"),
        (Nameless, "needs a 'law'"),
    ],
)
def test_a_broken_effect_is_told(effect, word):
    with pytest.raises(AssertionError, match=word):
        check_effect(effect)
