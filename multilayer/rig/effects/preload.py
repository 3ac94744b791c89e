"""A sample that its load stiffens."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import GRAVITY, Effect, Geometry, Moment, Size
from multilayer.units import Unit

_USUAL_STRESS = 100.0  # Pa, below a steel plate of 1.3 mm


class Preload(Effect):
    """What lies on the sample stiffens it: E (1 + b s), s the weight of plate and accelerometer over the area, Pa.

    The loss factor is kept. Perturbed: b s (s / 100 Pa)^p.
    """

    effect: Literal["preload"] = "preload"
    stiffening: Annotated[float, Field(ge=-1e-3, le=0.05), Unit("1/Pa")] = 5e-4

    drawn = Size("stiffening", 3e-5, 3e-3, parameter="stiffening")

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        stress = static_stress(moment.geometry)
        return np.asarray(modulus * (1 + self.stiffening * stress * (stress / _USUAL_STRESS) ** self.perturbation))


def static_stress(geometry: Geometry) -> float:
    """Return the weight of top plate and accelerometer over the area of the sample, Pa."""
    plate = geometry["plate_density"] * geometry["plate_thickness"]
    return float(GRAVITY * (plate + geometry.get("sensor_mass", 0.0) / (np.pi * geometry["radius"] ** 2)))
