"""The sample's free rim: finite elements in place of plane waves."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Effect
from multilayer.measurements.description import Campaign


class FiniteSize(Effect):
    """Poisson's ratio of the campaign acts with the free rim: a disc is softer than a layer held sideways."""

    name = "finite_size"
    law = "free rim: E -> E g(nu, S) in slow compression, S = R/2h; finite elements"
    separated_by = "another thickness or radius"
    source = "campaign.yaml: Poisson's ratio and radius are known, so the effect has no free size"
    moves_resonances = True
    law_error = 0.3  # Poisson's ratio is known to some 10 %
    needs_finite_elements = True

    def applies(self, campaign: Campaign) -> bool:
        """Without lateral contraction the rim does not matter."""
        return abs(campaign.specimen.poisson_ratio) > 0.01
