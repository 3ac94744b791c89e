"""The free rim of the sample."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from multilayer.rig.effect_base import Effect, Geometry, Mistake, Mounting, Size, Surroundings
from multilayer.rig.specimen import SpecimenSettings


class FiniteSize(Effect):
    """The sample has its true Poisson's ratio, and a free rim: it bulges.

    Without this effect it has the ratio 0, in the finite elements and in ``campaign.yaml``, and is a rod. It presses
    unevenly against the top plate, which therefore has its true stiffness. Perturbed: its modulus along the radius is
    (1 + p) times that along the axis.
    """

    effect: Literal["finite_size"] = "finite_size"

    drawn = Size()

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        if around.specimen.poisson_ratio == 0:
            yield (), "finite_size needs a specimen.poisson_ratio other than 0; give it, or remove the effect", None

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        ratio = geometry.get("transverse_ratio", 1.0) * (1 + self.perturbation)
        uneven = {"poisson_ratio": specimen.poisson_ratio, "plate_modulus": geometry["real_plate_modulus"]}
        return {**geometry, **uneven, "transverse_ratio": ratio}
