"""An accelerometer that resonates on its mount."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size
from multilayer.units import DIMENSIONLESS, Unit


class SensorMount(Effect):
    """The top accelerometer resonates on its mount: T / (1 - (f/fm)^2 + i eta f/fm).

    Perturbed: the exponent 2 becomes 2 (1 + p), an accelerometer on more than one spring.
    """

    effect: Literal["sensor_mount"] = "sensor_mount"
    frequency: Annotated[float, Field(ge=500, le=100e3), Unit("Hz")] = 6000.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    drawn = Size("frequency", 1.2e4, 2e3, parameter="frequency")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        x = frequency / self.frequency
        return np.asarray(ratio / (1 - x ** (2 * (1 + self.perturbation)) + 1j * self.loss_factor * x))
