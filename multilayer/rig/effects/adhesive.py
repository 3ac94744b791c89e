"""Glue at the faces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ArrayLike, ComplexArray
from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Size, Surroundings, power_law
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit

_USUAL_THICKNESS = 0.2e-3  # m, of each layer


@dataclass(frozen=True)
class GlueModulus:
    """E (1 + i eta) (i f / 500 Hz)^exponent, Pa, at `frequency`, Hz; a class, so that it can go to another process."""

    young_modulus: float
    loss_factor: float
    exponent: float

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return the modulus."""
        growth = power_law(np.asarray(frequency, dtype=float), self.exponent)
        return np.asarray(self.young_modulus * (1 + 1j * self.loss_factor) * growth)


class Adhesive(Effect):
    """A layer of glue of `thickness`, m, at each face of the sample, of modulus E (1 + i eta), Pa.

    Perturbed: E (1 + i eta) (i f / 500 Hz)^abs(p), a glue that stiffens with frequency.
    """

    effect: Literal["adhesive"] = "adhesive"
    thickness: Annotated[float, Field(gt=0, le=0.01), Unit("m")] = _USUAL_THICKNESS
    young_modulus: Annotated[float, Field(ge=1e3, le=1e11), Unit("Pa")] = 2e5
    loss_factor: Annotated[float, Field(ge=0, le=2), Unit(DIMENSIONLESS)] = 0.3
    density: Annotated[float, Field(ge=1, le=1e4), Unit("kg/m^3")] = 1000.0
    poisson_ratio: Annotated[float, Field(ge=0, lt=0.5), Unit(DIMENSIONLESS)] = 0.0

    drawn = Size("young_modulus", 2e6, 2e4, parameter="compliance", of=lambda modulus: _USUAL_THICKNESS / modulus)

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if 2 * self.thickness >= around.thinnest:
            text = (
                f"{1e3 * self.thickness:g} mm of glue at both faces are not thinner than the thinnest sample, "
                f"{1e3 * around.thinnest:g} mm; give the thickness of one layer, below {500 * around.thinnest:g} mm"
            )
            yield ("thickness",), text, self.thickness

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        glue = GlueModulus(self.young_modulus, self.loss_factor, abs(self.perturbation))
        return {
            **geometry,
            "adhesive_thickness": self.thickness,
            "adhesive_modulus": glue,
            "adhesive_density": self.density,
            "adhesive_poisson_ratio": self.poisson_ratio,
        }
