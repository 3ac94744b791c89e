"""Every registered effect, those of plugins included, keeps the laws of `multilayer.testing`."""

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS, Effect
from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.tube import TubeEffect
from multilayer.testing import check_effect

# the effects of ../shared/GAP.md
NAMES = {
    "finite_size", "sensor_mass", "adhesive", "channel_gain", "channel_delay", "high_pass", "crosstalk", "preload",
    "saturating_air", "dispersion", "plate_flexure", "sensor_mount", "rocking", "delamination", "skin",
    "amplitude_softening", "temperature_drift", "flanking",
}  # fmt: skip


TUBE_NAMES = {
    "rear_air_gap", "lateral_air_gap", "edge_constraint", "frame_motion", "facing", "sample_position",
    "microphone_gain", "microphone_phase", "temperature", "thickness_error",
}  # fmt: skip


def test_all_effects_are_there():
    assert set(EFFECTS.names()) >= NAMES | TUBE_NAMES
    assert {name for name in EFFECTS if issubclass(EFFECTS[name], TubeEffect)} == TUBE_NAMES


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


class SilentTube(TubeEffect):
    name = "silent_tube"
    law = "nothing"
    separated_by = "nothing"
    source = "nowhere"
    parameters = (positive("size", 1.0, 1.0),)


class InplaceTube(SilentTube):
    def reading(self, setting, reflection, values):
        reflection *= 1 - 1e-3 * values["size"]
        return reflection


class JumpTube(SilentTube):
    def reading(self, setting, reflection, values):
        return reflection * 0.9


@pytest.mark.parametrize(
    ("effect", "word"),
    [
        (Silent, "changes nothing"),
        (Jump, "still changes"),
        (Inplace, "changed in place"),
        (Mixed, "other responses than one by one"),
        (Nameless, "needs a 'law'"),
        (SilentTube, "changes nothing"),
        (InplaceTube, "changed in place"),
        (JumpTube, "still changes"),
    ],
)
def test_a_broken_effect_is_told(effect, word):
    with pytest.raises(AssertionError, match=word):
        check_effect(effect)
