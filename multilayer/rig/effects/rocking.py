"""A rocking mode in the reading."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size, above_zero, resonance
from multilayer.units import DIMENSIONLESS, Unit


class Rocking(Effect):
    """A share of a rocking mode that the base drives is in the reading: T + s f^2 / (fr^2 - f^2 + i eta fr f).

    Perturbed: s (f / fr)^p, a mode that the base drives the more the faster it moves.
    """

    effect: Literal["rocking"] = "rocking"
    share: Annotated[float, Field(ge=-1, le=1), Unit(DIMENSIONLESS)] = 0.02
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 700.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    drawn = Size("share", 2e-3, 0.1, parameter="share")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        share = self.share * (above_zero(frequency) / self.frequency) ** self.perturbation
        return np.asarray(ratio + share * resonance(frequency, self.frequency, self.loss_factor))
