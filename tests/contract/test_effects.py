"""Every registered effect, those of plugins included, keeps the laws of `multilayer.testing`."""

import math
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import numpy as np
import pytest

from multilayer.diagnosis import effects
from multilayer.diagnosis.effects import EFFECTS, Effect
from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.tube import TubeEffect
from multilayer.rig.effects import EFFECTS as RIG_EFFECTS
from multilayer.testing import check_effect
from multilayer.testing.benches import joint_bench, soft_sample

BUILT_IN = {name for name in EFFECTS if [owner.package for owner in EFFECTS.owners(name)] == ["multilayer"]}


def test_every_file_holds_an_effect_of_its_name_and_is_registered():
    files = {path.stem for path in Path(effects.__file__).parent.glob("*.py")} - {"__init__", "base", "tube", "levels"}
    assert files == BUILT_IN
    for name in BUILT_IN:
        assert EFFECTS[name].__module__ == f"{effects.__name__}.{name}"


def test_every_effect_of_the_two_plate_rig_has_a_virtual_twin():
    assert {name for name in BUILT_IN if issubclass(EFFECTS[name], Effect)} <= set(RIG_EFFECTS.names())


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


class Ends(Silent):
    def motion(self, setting, motion, values):
        return motion * (1 + 1e-3 * np.array([[math.sqrt(1e6 - s.item())] for s in np.atleast_1d(values["size"])]))


class Inplace(Silent):
    def motion(self, setting, motion, values):
        motion *= 1 + values["size"]
        return motion


class InplaceValues(Silent):
    def motion(self, setting, motion, values):
        size = values["size"]
        size *= 1e-3
        return motion * (1 + size)


class TakesItsValues(Silent):
    def chain(self, setting, chain, values):
        return chain.with_(plate_mass=chain.plate_mass * (1 + values.pop("size")))


class OfOneSize(Silent):
    def motion(self, setting, motion, values):
        return motion * (1 + 2e-6)


class Mixed(Silent):
    def motion(self, setting, motion, values):
        return motion * (1 + np.mean(values["size"]) * 1e-3)


class NeverVanishes(Silent):
    """So little is left of it that a bound alone does not see it."""

    def motion(self, setting, motion, values):
        return motion * (1.015 + values["size"])


class Narrow(Silent):
    parameters = (positive("share", 0.2, 0.3),)

    def motion(self, setting, motion, values):
        return motion * (1 + values["share"])


class NarrowAndKnown(Narrow):
    absent: ClassVar = {"share": 0.0}


class Nameless(Silent):
    law = ""


class Stranger(EFFECTS["channel_gain"]):
    size_errors: ClassVar = {"offset": 0.01}


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
        (Ends, "ValueError"),
        (Inplace, "an array it was given is changed in place"),
        (InplaceValues, "the values of its parameters are changed in place"),
        (TakesItsValues, "the values of its parameters are changed in place"),
        (NeverVanishes, r"vanishes: .* still changes by 0.017, and with smaller ones by 0.015; .* {'size': 0.0}"),
        (Narrow, r"vanishes: .* still changes by 0.033; where the prior ends before .*: absent = {'share': 0.0}"),
        (OfOneSize, "acts: at its usual size it changes nothing"),
        (Mixed, "other responses than one by one"),
        (Nameless, "needs a 'law'"),
        (Stranger, "size_errors of what is no parameter"),
        (SilentTube, "changes nothing"),
        (InplaceTube, "changed in place"),
        (JumpTube, "still changes"),
    ],
)
def test_a_broken_effect_is_told(effect, word):
    with pytest.raises(AssertionError, match=word):
        check_effect(effect)


def test_an_effect_of_a_narrow_prior_says_where_it_is_absent():
    check_effect(NarrowAndKnown)


class OfAnotherName(EFFECTS["channel_gain"]):
    """A finer law that lost its name."""

    name = "gain"


class WithAnother(EFFECTS["channel_gain"]):
    def finer(self):
        return OfAnotherName()


def test_a_finer_law_is_one_of_the_same_effect():
    with pytest.raises(AssertionError, match=r"refines: the finer law needs the name and the parameters of this one"):
        check_effect(WithAnother)


def on_the_bench():
    """Return the names of effects that plane waves of the two-plate rig have."""
    effects = [EFFECTS[name]() for name in EFFECTS.names()]
    return [e.name for e in effects if joint_bench().admits(e) and not e.needs_finite_elements]


@pytest.mark.parametrize("name", on_the_bench())
@pytest.mark.parametrize("given", ["nothing", "channel_gain"])
def test_what_a_hypothesis_hands_on_does_not_depend_on_effects(name, given):
    """Values that `with_effects` takes over are those that a hypothesis made anew computes."""
    if name != given:
        hands_on(replace(joint_bench(), given=() if given == "nothing" else (EFFECTS[given](),)), EFFECTS[name]())


def hands_on(base, effect):
    base.residual(np.zeros(len(base.parameters)))  # computes what is handed on
    derived, anew = base.with_effects(effect), replace(base, effects=(effect,))
    z = 0.2 * np.random.default_rng(0).standard_normal(len(anew.parameters))
    z[: len(anew.law_parameters)] = soft_sample(base)[: len(anew.law_parameters)]
    for found, expected in zip(derived.linearised(z), anew.linearised(z), strict=True):
        np.testing.assert_array_equal(found, expected)
    for found, expected in zip(derived.law_change(0, z), anew.law_change(0, z), strict=True):
        np.testing.assert_array_equal(found, expected)
    without, z = derived.with_effects(), z[: len(base.parameters)]
    np.testing.assert_array_equal(without.residual(z), replace(base).residual(z))
