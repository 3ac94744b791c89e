"""Faces bonded in part."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Literal

from pydantic import Field

from multilayer.errors import suggest
from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Size, Surroundings
from multilayer.rig.specimen import SpecimenSettings
from multilayer.units import DIMENSIONLESS, Unit


class Delamination(Effect):
    """Only a share of both faces, or of one, about the axis, is bonded; in the named configurations, or all.

    The top plate, which hangs over, bends as its modulus says.

    Perturbed: the open share 1 - b is (1 + p) times as large in the first of them, (1 - p) times in the last.
    """

    effect: Literal["delamination"] = "delamination"
    bonded_fraction: Annotated[float, Field(gt=0.1, le=1), Unit(DIMENSIONLESS)] = 0.85
    faces: Literal["both", "top", "base"] = "both"
    configurations: tuple[str, ...] | None = None

    drawn = Size("bonded_fraction", 0.97, 0.5)

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        names = [mounting.name for mounting in around.mountings]
        for i, name in enumerate(self.configurations or ()):
            if name not in names:
                yield ("configurations", i), f"there is no configuration '{name}'; {suggest(name, names)}", name

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        if self.configurations is not None and mounting.name not in self.configurations:
            return geometry
        place = 2 * mounting.index / max(mounting.count - 1, 1) - 1
        open_share = (1 - self.bonded_fraction) * (1 - self.perturbation * place)
        return {
            **geometry, "bonded_fraction": max(1 - open_share, 0.05), "open_faces": self.faces,
            "plate_modulus": geometry["real_plate_modulus"],
        }  # fmt: skip
