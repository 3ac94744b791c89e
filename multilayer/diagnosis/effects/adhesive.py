"""Layers of glue between sample and plates."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, between, positive


class Adhesive(Effect):
    """Compliant, lossy layers at both faces, the same for all thicknesses."""

    name = "adhesive"
    law = "compliance per area c (1 - i eta) at each face"
    separated_by = "another thickness of the sample"
    source = "glue of 0.05 to 0.5 mm and 0.05 to 100 MPa: 1e-12 to 1e-8 m/Pa"
    moves_resonances = True
    parameters = (positive("compliance", 3e-10, 2.0, "m/Pa"), between("loss_factor", 0.0, 1.0))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """A spring per area at each face."""
        return chain.with_(glue=(1 + 1j * values["loss_factor"]) / values["compliance"])
