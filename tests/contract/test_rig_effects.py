"""Every effect of the virtual rig, those of plugins included, keeps the laws of `multilayer.testing`."""

from pathlib import Path
from typing import Annotated, Literal

import numpy as np
import pytest
from pydantic import Field

from multilayer.rig import effects
from multilayer.rig.effect_base import Effect, Size
from multilayer.rig.effects import EFFECTS
from multilayer.testing import check_rig_effect
from multilayer.units import DIMENSIONLESS, Unit

BUILT_IN = {name for name in EFFECTS if [owner.package for owner in EFFECTS.owners(name)] == ["multilayer"]}


def test_every_file_holds_an_effect_of_its_name_and_is_registered():
    files = {path.stem for path in Path(effects.__file__).parent.glob("*.py")} - {"__init__"}
    assert files == BUILT_IN
    for name in BUILT_IN:
        assert EFFECTS[name].__module__ == f"{effects.__name__}.{name}"


@pytest.mark.parametrize("name", EFFECTS.names())
def test_an_effect_keeps_the_laws(name):
    check_rig_effect(EFFECTS[name])


class Echo(Effect):
    """The reading is followed by an echo: T (1 + s).

    Perturbed: s (1 + p).
    """

    effect: Literal["echo"] = "echo"
    share: Annotated[float, Field(ge=-1, le=1), Unit(DIMENSIONLESS)] = 0.02

    known = False

    def apply_to_response(self, frequency, ratio, mounting):
        return ratio * (1 + self.share * (1 + self.perturbation))


class Mute(Echo):
    pass


class Bare(Echo):
    __doc__ = Echo.__doc__
    share: float
    delay: float = 0.0


class Known(Echo):
    __doc__ = Echo.__doc__
    known = True


class Square(Echo):
    __doc__ = Echo.__doc__

    def apply_to_response(self, frequency, ratio, mounting):
        return ratio**2


class InPlace(Echo):
    __doc__ = Echo.__doc__

    def apply_to_response(self, frequency, ratio, mounting):
        ratio *= 2
        return ratio


class Active(Echo):
    __doc__ = Echo.__doc__

    def apply_to_modulus(self, frequency, modulus, moment):
        return modulus.conj()


class NoRig(Echo):
    __doc__ = Echo.__doc__

    def apply_to_geometry(self, geometry, mounting, specimen):
        return {**geometry, "wings": 2}


class Huge(Echo):
    __doc__ = Echo.__doc__
    drawn = Size("share", 0.1, 10.0)


class Talkative(Echo):
    __doc__ = Echo.__doc__

    def parameters(self, specimen):
        return {"colour": "red"}


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (Mute, "the docstring must say the law"),
        (Bare, "field 'share' needs a default\n.*field 'delay' needs a unit"),
        (Known, "no effect 'echo' is known to a diagnosis; say 'known = False'"),
        (Square, "what it shows of 2 T is not"),
        (InPlace, "something it was given is changed in place"),
        (Active, "must be passive"),
        (NoRig, "makes a rig: TypeError: .*wings"),
        (Huge, "twin: ValidationError: .*"),
        (Talkative, "parameters for the truth file that are no fields: colour"),
    ],
)
def test_a_broken_effect_is_told(kind, words):
    EFFECTS.register("echo", kind)
    try:
        with pytest.raises(AssertionError, match=words):
            check_rig_effect(kind)
    finally:
        EFFECTS.unregister("echo")


def test_a_sound_one_passes_and_must_be_registered():
    with pytest.raises(AssertionError, match=r"no entry point 'multilayer.rig_effects' is called 'echo'"):
        check_rig_effect(Echo)
    EFFECTS.register("echo", Echo)
    try:
        check_rig_effect(Echo)
        assert np.allclose(Echo().apply_to_response(np.ones(1), np.ones(1), None), 1.02)
    finally:
        EFFECTS.unregister("echo")
