"""Skins at the faces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import RealArray
from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Size, Surroundings
from multilayer.rig.specimen import SkinSettings, SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit


@dataclass(frozen=True)
class SoftEdge:
    """Factor on the modulus over z/h: `ratio` at the faces, 1 in the core, the edge as wide as `width` times `depth`.

    Lengths over the sample's thickness.
    """

    depth: float
    ratio: float
    width: float

    def __call__(self, height: RealArray) -> RealArray:
        """Return the factor at z/h."""
        inside = np.minimum(height, 1 - height) - self.depth
        return np.asarray(1 + (self.ratio - 1) * 0.5 * (1 - np.tanh(2 * inside / (self.width * self.depth))))


class Skin(Effect):
    """Layers of `thickness`, m, at both faces of the sample whose modulus is `ratio` times that of the core.

    Fields left out are those of ``specimen.skin``. Perturbed: the step of the modulus is a smooth edge, 2 abs(p) times
    as wide as the skin.
    """

    effect: Literal["skin"] = "skin"
    thickness: Annotated[float, Field(gt=0, le=0.1), Unit("m")] | None = None
    ratio: Annotated[float, Field(gt=0, le=1000), Unit(DIMENSIONLESS)] | None = None

    takes = ("skin",)
    drawn = Size("ratio", 1.2, 10.0, parameter="ratio")

    def _skin(self, specimen: SpecimenSettings) -> SkinSettings:
        usual = specimen.skin or SkinSettings(thickness=1e-3, ratio=3.0)
        return SkinSettings(thickness=self.thickness or usual.thickness, ratio=self.ratio or usual.ratio)

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return self._skin(specimen).model_dump()

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        skin = self._skin(around.specimen).thickness
        if 2 * skin >= around.thinnest:
            text = f"{1e3 * skin:g} mm of skin at both faces leave no core in {1e3 * around.thinnest:g} mm"
            yield ("thickness",), f"{text}; make it thinner", skin

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        skin = self._skin(specimen)
        if not self.perturbation:
            return {**geometry, "skin_thickness": skin.thickness, "skin_ratio": skin.ratio}
        depth = skin.thickness / geometry["thickness"]
        return {**geometry, "modulus_profile": SoftEdge(depth, skin.ratio, 2 * abs(self.perturbation))}
