"""A modulus that varies over the thickness."""

from __future__ import annotations

from typing import Any, Literal

from multilayer.rig.effect_base import Effect, Geometry, Mounting, Size
from multilayer.rig.specimen import Factors, SpecimenSettings


class Grading(Effect):
    """The modulus varies over the thickness: factors, evenly spaced from base to top, linear between.

    Left out, they are those of ``specimen.grading``, or else 0.8 at the base and 1.2 at the top. Perturbed: factors to
    the power 1 + p.
    """

    effect: Literal["grading"] = "grading"
    factors: Factors | None = None

    known = False
    takes = ("grading",)
    drawn = Size()

    def parameters(self, specimen: SpecimenSettings) -> dict[str, Any]:
        return {"factors": list(self.factors or specimen.grading or (0.8, 1.2))}

    def apply_to_geometry(self, geometry: Geometry, mounting: Mounting, specimen: SpecimenSettings) -> Geometry:
        factors = [factor ** (1 + self.perturbation) for factor in self.parameters(specimen)["factors"]]
        return {**geometry, "modulus_profile": tuple(factors)}
