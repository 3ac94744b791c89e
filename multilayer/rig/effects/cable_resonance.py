"""A cable that swings."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size
from multilayer.units import DIMENSIONLESS, Unit


class CableResonance(Effect):
    """The accelerometer's cable swings and takes the motion away about its own frequency, a notch of a certain depth.

    T (f0^2 - f^2 + i (1 - d) eta f0 f) / (f0^2 - f^2 + i eta f0 f): T (1 - d) at f0. Perturbed: f0 is (1 + p k) times
    as high in configuration k, k from 0 to 1: the cable hangs otherwise after each mounting.
    """

    effect: Literal["cable_resonance"] = "cable_resonance"
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 350.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.3
    depth: Annotated[float, Field(ge=0, le=1), Unit(DIMENSIONLESS)] = 0.1

    known = False
    drawn = Size("depth", 0.01, 0.5)

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        natural = self.frequency * (1 + self.perturbation * mounting.index / max(mounting.count - 1, 1))
        undamped, loss = natural**2 - frequency**2, 1j * self.loss_factor * natural * frequency
        return np.asarray(ratio * (undamped + (1 - self.depth) * loss) / (undamped + loss))
