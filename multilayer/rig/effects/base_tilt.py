"""A base plate that tilts."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size, above_zero, resonance
from multilayer.units import DIMENSIONLESS, Unit


class BaseTilt(Effect):
    """The base plate tilts about its own resonance, and its accelerometer, off the axis, reads the tilt too.

    T / (1 + s f^2 / (f0^2 - f^2 + i eta f0 f)). Perturbed: s (f / f0)^p.
    """

    effect: Literal["base_tilt"] = "base_tilt"
    share: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.02
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 900.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    known = False
    drawn = Size("share", 2e-3, 0.1)

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        share = self.share * (above_zero(frequency) / self.frequency) ** self.perturbation
        return np.asarray(ratio / (1 + share * resonance(frequency, self.frequency, self.loss_factor)))
