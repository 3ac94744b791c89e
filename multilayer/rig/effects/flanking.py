"""A path beside the sample."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import Field

from multilayer.rig.effect_base import Effect, Geometry, Mounting, Size
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit

_USUAL_THICKNESS = 25e-3  # m


class Flanking(Effect):
    """A path beside the sample, from the base to the rim of the top plate: k (1 + i eta), k in N/m.

    Perturbed: k (h / 25 mm)^(-p), a skirt that is stretched with the sample's thickness h for p = 1.
    """

    effect: Literal["flanking"] = "flanking"
    stiffness: Annotated[float, Field(ge=0, le=1e9), Unit("N/m")] = 500.0
    loss_factor: Annotated[float, Field(ge=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    drawn = Size("stiffness", 30.0, 5e3, parameter="stiffness")

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        scale = (mounting.thickness / _USUAL_THICKNESS) ** -self.perturbation
        return {**geometry, "flanking_stiffness": self.stiffness * scale * (1 + 1j * self.loss_factor)}
