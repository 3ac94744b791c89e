"""A sample that settles after each mounting."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Moment, Size
from multilayer.units import DIMENSIONLESS, Unit


class Creep(Effect):
    """The sample settles after each mounting: E (1 + c ln(1 + k)), k the bursts since then.

    Perturbed: k^(1 + p).
    """

    effect: Literal["creep"] = "creep"
    rate: Annotated[float, Field(ge=-0.2, le=0.2), Unit(DIMENSIONLESS)] = 0.02

    known = False
    varies = True
    drawn = Size("rate", 2e-3, 0.05)

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        return np.asarray(modulus * (1 + self.rate * np.log1p(moment.since_mounting ** (1 + self.perturbation))))
