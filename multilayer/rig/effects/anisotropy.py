"""A sample of another modulus across than along its axis."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any, Literal

from pydantic import Field

from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Surroundings
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit


class Anisotropy(Effect):
    """The sample is stiffer or softer across than along its axis, by E_r/E_z; it shows through Poisson's ratio only.

    Left out, the ratio is that of the specimen, or else 0.6. Perturbed: the shear modulus too is (1 + p) times as high.
    """

    effect: Literal["anisotropy"] = "anisotropy"
    transverse_ratio: Annotated[float, Field(gt=0, le=100), Unit(DIMENSIONLESS)] | None = None

    known = False
    takes = ("transverse_ratio",)
    needs = ("finite_size",)

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if "finite_size" not in around.effects:
            text = "anisotropy shows through Poisson's ratio only; list {effect: finite_size} too"
            yield ("effect",), text, None

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return {"transverse_ratio": self.transverse_ratio or specimen.transverse_ratio or 0.6}

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        ratio = self.parameters(specimen)["transverse_ratio"] * geometry.get("transverse_ratio", 1.0)
        return {**geometry, "transverse_ratio": ratio, "shear_ratio": 1 + self.perturbation}
