"""Every hypothesis with its evidence, and what is decided from them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Literal

import numpy as np
from scipy.special import logsumexp

from multilayer.diagnosis.discrepancy import discrepancy_evidence, tolerant_p_value
from multilayer.diagnosis.effects.base import Effect
from multilayer.diagnosis.fitting import Fitted, fit
from multilayer.diagnosis.held_out import Shrinkage
from multilayer.diagnosis.thresholds import (
    CANDIDATES,
    CERTAIN_P,
    FIT_P,
    GLOBAL_P,
    LEAST_EVIDENCE,
    LEAST_SHRINKAGE,
    SECOND_EVIDENCE,
    TEMPERATURE,
    TIED,
    TOLERANCE,
)

Verdict = Literal["effect", "unknown", "no_gap"]
UNKNOWN: tuple[str, ...] = ("unknown",)
_SMALL = (1e-6, 0.5 * TOLERANCE, TOLERANCE)
_LARGE = (0.01, 0.02, 0.04, 0.08)


@dataclass(frozen=True)
class Hypotheses:
    """All that was tried.

    Attributes
    ----------
    nominal : Fitted
    fitted : dict
        By the names of their effects; without the nominal one.
    evidence : dict
        Log evidence by names, the tolerance being allowed in each; the nominal model under ``()``, none of the known
        effects under ``("unknown",)``.
    """

    nominal: Fitted
    fitted: dict[tuple[str, ...], Fitted]
    evidence: dict[tuple[str, ...], float]

    @property
    def ranked(self) -> list[tuple[str, ...]]:
        """Names of the causes, the most probable first; without the nominal model."""
        return sorted((names for names in self.evidence if names), key=lambda names: -self.evidence[names])

    def probabilities(self) -> dict[tuple[str, ...], float]:
        """Return probabilities by names: evidence over the temperature that development runs called for."""
        names = list(self.evidence)
        scaled = np.array([self.evidence[n] for n in names]) / TEMPERATURE
        shares = np.exp(scaled - logsumexp(scaled))
        return dict(zip(names, (float(p) for p in shares), strict=True))


def tolerant_evidence(fitted: Fitted) -> float:
    """Return the log evidence of a hypothesis that may be off by as much as solvers are."""
    return discrepancy_evidence(fitted.hypothesis, fitted.minimum, _SMALL)[0]


def compare(nominal: Fitted, singles: Mapping[tuple[str, ...], Fitted], effects: Mapping[str, Effect]) -> Hypotheses:
    """Return the evidence of nominal model, single effects, pairs of the best, and of something unknown."""
    fitted = dict(singles)
    evidence = {names: tolerant_evidence(one) for names, one in {(): nominal, **fitted}.items()}
    best = sorted(singles, key=lambda names: -evidence[names])[:CANDIDATES]
    if best and evidence[best[0]] - evidence[()] > LEAST_EVIDENCE:
        for first, second in combinations(best, 2):
            pair = _pair(singles[first], effects[second[0]])
            score = tolerant_evidence(pair)
            if score > max(evidence[first], evidence[second]) + SECOND_EVIDENCE:
                fitted[pair.names], evidence[pair.names] = pair, score
    evidence[UNKNOWN] = discrepancy_evidence(nominal.hypothesis, nominal.minimum, _LARGE)[0]
    return Hypotheses(nominal, fitted, evidence)


def _pair(one: Fitted, other: Effect) -> Fitted:
    hypothesis = replace(one.hypothesis, effects=(*one.hypothesis.effects, other))
    return fit(hypothesis, one.minimum.z)


@dataclass(frozen=True)
class Decision:
    """What is said.

    Attributes
    ----------
    verdict : {'effect', 'unknown', 'no_gap'}
    best : tuple of str
        The cause; empty without a gap.
    group : list of tuple of str
        Hypotheses that the data cannot tell from it.
    reason : str
    """

    verdict: Verdict
    best: tuple[str, ...]
    group: list[tuple[str, ...]]
    reason: str


def global_p_value(nominal: Fitted) -> float:
    """Return the probability of a misfit as large as the nominal model's, if nothing acts."""
    return tolerant_p_value(nominal.hypothesis, nominal.minimum, 1e-6)


def is_gap(found: Hypotheses) -> bool:
    """Tell whether there is a gap at all."""
    p = global_p_value(found.nominal)
    return p <= CERTAIN_P or (p <= GLOBAL_P and _is_supported(found))


def _is_supported(found: Hypotheses) -> bool:
    """Tell whether some cause has more evidence than the nominal model."""
    return max(found.evidence[names] for names in found.ranked) - found.evidence[()] >= LEAST_EVIDENCE


def decide(found: Hypotheses, shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> Decision:
    """Return the verdict; see the thresholds."""
    p = global_p_value(found.nominal)
    if not is_gap(found):
        return Decision("no_gap", (), [], f"a misfit as large has the probability {p:.2g} without any effect")
    if not _is_supported(found):
        text = f"a misfit as large has the probability {p:.1g}, and no known effect makes it more probable"
        return Decision("unknown", UNKNOWN, [UNKNOWN], text)
    best = _carried_over(found.ranked[0], shrinkage)
    group = _group(found, best)
    if best == UNKNOWN:
        return Decision("unknown", best, group, "a smooth discrepancy explains the gap better than any known effect")
    fitted, held = found.fitted[best], shrinkage.get(best)
    own = tolerant_p_value(fitted.hypothesis, fitted.minimum, TOLERANCE)
    label = " and ".join(best)
    if own < FIT_P:
        return Decision("unknown", best, group, f"{label} explains most, but leaves a misfit of probability {own:.1g}")
    if held is not None and np.isfinite(held.share) and held.share < LEAST_SHRINKAGE:
        text = f"with {label} the gap on held-out data shrinks by {100 * held.share:.0f} % only"
        return Decision("unknown", best, group, text)
    return Decision("effect", best, group, f"{label} explains the gap")


def _carried_over(best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> tuple[str, ...]:
    """Return one effect in place of two where the second is of no use on held-out data: physics carries over."""
    if len(best) < 2 or best not in shrinkage:
        return best
    parts = [names for names in shrinkage if len(names) < len(best) and set(names) <= set(best)]
    better = [names for names in parts if shrinkage[names].share >= shrinkage[best].share]
    return max(better, key=lambda names: shrinkage[names].share, default=best)


def _group(found: Hypotheses, best: tuple[str, ...]) -> list[tuple[str, ...]]:
    top = found.evidence[best]
    tied = [names for names in found.ranked if abs(top - found.evidence[names]) < TIED and names != best]
    return [best, *tied]


def in_words(names: Sequence[str]) -> str:
    """Return names of effects for people."""
    return " and ".join(name.replace("_", " ") for name in names)
