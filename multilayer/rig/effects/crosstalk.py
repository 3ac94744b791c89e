"""Base signal in the top channel."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size, power_law
from multilayer.units import DIMENSIONLESS, Unit


class Crosstalk(Effect):
    """Part of the base signal shows in the top channel: T + c exp(-i w tau).

    Perturbed: c (i f / 500 Hz)^p, through a capacitance for p = 1.
    """

    effect: Literal["crosstalk"] = "crosstalk"
    share: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.01
    delay: Annotated[float, Field(ge=0, le=1e-3), Unit("s")] = 0.0

    drawn = Size("share", 1e-3, 0.08, parameter="share")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        late = np.exp(-2j * np.pi * frequency * self.delay)
        return np.asarray(ratio + self.share * power_law(frequency, self.perturbation) * late)
