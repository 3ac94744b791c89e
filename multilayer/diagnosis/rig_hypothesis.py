"""Hypotheses that are known to be of the two-plate rig."""

from __future__ import annotations

from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.two_plate.campaign import CampaignProblem


def rig_hypothesis(hypothesis: Hypothesis) -> CampaignProblem:
    """Return a hypothesis that is known to be one of the two-plate rig.

    Raises
    ------
    TypeError
        When it is of something else.
    """
    if not isinstance(hypothesis, CampaignProblem):
        raise TypeError(f"{type(hypothesis).__name__} is no hypothesis of the two-plate rig")
    return hypothesis
