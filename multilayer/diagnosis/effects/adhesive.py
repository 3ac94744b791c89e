"""Layers of glue between sample and plates."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, between, positive


class Adhesive(Effect):
    """Compliant, lossy layers at both faces, the same for all thicknesses of the sample."""

    name = "adhesive"
    place = "faces"
    law = "a layer at each face: stiffness per area (1 + i eta)/c, and mass"
    separated_by = "another thickness of the sample"
    source = "glue of 0.05 to 0.5 mm, 0.05 to 100 MPa and 1000 kg/m3; double-sided tape is at the soft end"
    moves_resonances = True
    # 17 right names of seeds 1008 to 1012: most off by 3 % beyond noise, thick glue that is as soft as the sample (220
    # of 1010, 0 and 197 of 1012) by 14 to 22 %; 0.05 would hold 14 of them
    size_errors: ClassVar[Mapping[str, float]] = {"compliance": 0.1}
    parameters = (
        positive("compliance", 3e-10, 2.0, "m/Pa"), between("loss_factor", 0.0, 1.0),
        positive("surface_density", 0.15, 0.7, "kg/m^2", bounds=(1e-9, 0.6)),
    )  # fmt: skip

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with a layer of stiffness and mass at each face."""
        return chain.glued((1 + 1j * values["loss_factor"]) / values["compliance"], values["surface_density"])
