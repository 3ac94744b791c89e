"""Layers of glue between sample and plates."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, between, positive


class Adhesive(Effect):
    """Compliant, lossy layers at both faces, the same for all thicknesses."""

    name = "adhesive"
    law = "compliance per area c (1 - i eta) at each face; the upper layer's mass on the plate"
    separated_by = "another thickness of the sample"
    source = "glue of 0.05 to 0.5 mm, 0.05 to 100 MPa and 1000 kg/m3; double-sided tape is at the soft end"
    moves_resonances = True
    parameters = (
        positive("compliance", 3e-10, 2.0, "m/Pa"), between("loss_factor", 0.0, 1.0),
        positive("surface_density", 0.05, 1.5, "kg/m2"),
    )  # fmt: skip

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """A spring per area at each face; the upper layer moves with the plate."""
        mass = chain.plate_mass + values["surface_density"] * setting.area
        return chain.with_(glue=(1 + 1j * values["loss_factor"]) / values["compliance"], plate_mass=mass)
