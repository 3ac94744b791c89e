"""What a hypothesis asks of chance, of the laboratory's statements, of its effects' sizes and of their laws."""

from __future__ import annotations

from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.thresholds import FIT_P, TOLERANCE
from multilayer.diagnosis.unknown_cause import law_p_value, size_p_value, tolerant_p_value
from multilayer.inference.pulls import nuisance_p_value


def strain(fitted: Fitted, *, forgiven: bool = False) -> str:
    """Return what a hypothesis asks too much of; empty where it fits.

    Of chance and solvers, of what the laboratory states, of the effects' sizes and of their laws each: together they
    forgive more than any right hypothesis asks of one of them. A misfit may be `forgiven`, the others never.
    """
    asked = {
        "takes what is stated of the laboratory for wrong, which has the probability": nuisance_p_value(
            fitted.hypothesis.parameters, fitted.minimum.z
        ),
        "asks for sizes so far from the usual ones that these have the probability": size_p_value(fitted),
        "asks for a law so far from the known one that this has the probability": law_p_value(fitted),
    }
    if not forgiven:
        asked["leaves a misfit of probability"] = tolerant_p_value(fitted, TOLERANCE)
    text = min(asked, key=lambda one: asked[one])
    return f"{text} {probability_text(asked[text])}" if asked[text] < FIT_P else ""


def probability_text(p: float) -> str:
    """Return a probability for people."""
    return f"{p:.1g}" if p > 1e-300 else "below 1e-300"
