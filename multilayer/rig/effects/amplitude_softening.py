"""A modulus that falls with strain."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from multilayer.rig.effect_base import Effect, Size
from multilayer.units import DIMENSIONLESS, Unit


class AmplitudeSoftening(Effect):
    """The modulus falls with the dynamic strain: the stress is that of a linear sample of strain e / (1 + b abs(e)).

    So E1 and E2 fall alike, by about 0.85 b times the strain's amplitude, and odd harmonics appear. Made by integrating
    the equations of motion in time, see `multilayer.rig.softening`. Perturbed: b abs(e) (abs(e) / 1e-3)^p in place of b
    abs(e), with n = 1 + p there.
    """

    effect: Literal["amplitude_softening"] = "amplitude_softening"
    softening: Annotated[float, Field(ge=0, le=1e4), Unit(DIMENSIONLESS)] = 50.0

    drawn = Size("softening", 5.0, 300.0, parameter="softening")
