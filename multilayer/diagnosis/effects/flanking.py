"""A parallel path around the sample."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, between, positive


class Flanking(Effect):
    """A spring k (1 + i eta) beside the sample, from the base to the top plate."""

    name = "flanking"
    place = "beside"
    law = "spring k (1 + i eta) from base to top plate"
    separated_by = "another thickness; a force cell"
    source = "cables, guides and tape: 10 to 1e4 N/m"
    moves_resonances = True
    # 19 right names of seeds 1012 to 1017: off by 0.9 % in the median, rms 3.2 %, noise included; another solver: 0.5 %
    size_errors: ClassVar[Mapping[str, float]] = {"stiffness": 0.03}
    parameters = (positive("stiffness", 500.0, 1.5, "N/m"), between("loss_factor", 0.0, 0.5))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with a spring in parallel to the sample."""
        return chain.with_(spring=values["stiffness"] * (1 + 1j * values["loss_factor"]))
