"""Entries of ``diagnosis.json`` that are the same for every kind of measurement."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.decision import Decision, in_words
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE

_MOST_CAUSES = 8


def cause_entries(
    comparison: ModelComparison,
    shrinkages: Mapping[tuple[str, ...], Shrinkage],
    similarity: Similarity,
    probabilities: Mapping[tuple[str, ...], float],
    decision: Decision,
) -> list[dict[str, Any]]:
    """Return the entries of ``causes``, the most probable first.

    The nominal model and the unknown cause are among them, and so is the group of the verdict, however many pairs with
    a second effect have more evidence: of these `counted_with` names what their probability counts with. `shrinkage`
    is that on held-out data, null of causes that were not checked on these.
    """
    shares = dict(zip(similarity.names, similarity.kept, strict=True))
    entries = []
    listed = dict.fromkeys([*comparison.ranked[:_MOST_CAUSES], *decision.group, UNKNOWN, ()])
    for names in sorted(listed, key=lambda names: (-probabilities[names], -comparison.score(names))):
        entry: dict[str, Any] = {
            "effects": list(names),
            "probability": round(probabilities[names], 4),
            "log_evidence": round(comparison.evidence[names], 2),
            "score": round(comparison.score(names), 2),
            "parameters": {},
            "gap_before": gap_in_fit(comparison.nominal),
        }
        if names not in (UNKNOWN, ()):
            fitted = comparison.fitted[names]
            after = gap_in_fit(fitted)
            entry["parameters"] = _parameters(fitted)
            entry["gap_after"] = after
            entry["shrinkage"] = round(shrinkages[names].share, 4) if names in shrinkages else None
            entry["absorbed"] = any(shares[name] < ABSORBED for name in names)
            if decision.best in comparison.fitted and set(decision.best) < set(names):
                entry["counted_with"] = list(decision.best)
        entries.append(entry)
    return entries


def gap_entry(nominal: Fitted, shrinkage: Shrinkage | None, best: Fitted | None = None) -> dict[str, Any]:
    """Return the entry ``gap``: of held-out data, or of the fit where nothing was left out.

    Parameters
    ----------
    nominal : Fitted
    shrinkage : Shrinkage, optional
        None without a gap.
    best : Fitted, optional
        The best explanation, for the fit where nothing was left out.
    """
    if shrinkage is not None and not math.isfinite(shrinkage.before):
        after = gap_in_fit(best) if best else math.nan
        shrinkage = replace(shrinkage, before=gap_in_fit(nominal), after=after)
    if shrinkage is None:
        before = gap_in_fit(nominal)
        held_out = "nothing: there is no gap"
        return {"before": before, "after": before, "noise": 1.0, "shrinkage": 0.0, "held_out": held_out}
    return {
        "before": round(shrinkage.before, 4),
        "after": round(shrinkage.after, 4),
        "noise": round(shrinkage.noise, 4),
        "shrinkage": round(shrinkage.share, 4),
        "held_out": shrinkage.held_out,
    }


def stated_entries(
    nominal: Fitted, best: Fitted, wrong: Mapping[str, float] = MappingProxyType({})
) -> dict[str, dict[str, float]]:
    """Return the entry ``stated_deviations``: by how many standard deviations each stated quantity is taken to be off.

    By the nominal model, and with the best explanation; `wrong` holds what that says by another prior.
    """

    def of(fitted: Fitted) -> dict[str, float]:
        pairs = zip(fitted.hypothesis.parameters, fitted.minimum.z, strict=True)
        return {parameter.name: round(float(z), 3) for parameter, z in pairs if parameter.nuisance}

    after = of(best) | {name: round(deviations, 3) for name, deviations in wrong.items()}
    return {name: {"nominal": z, "corrected": after[name]} for name, z in of(nominal).items() if name in after}


def confounded_entries(similarity: Similarity) -> list[dict[str, Any]]:
    """Return the entries of ``confounded``: signatures that the unknowns absorb, and pairs that are alike."""
    entries: list[dict[str, Any]] = []
    names, n = similarity.names, len(similarity.names)
    for i in range(n):
        if similarity.kept[i] < ABSORBED:
            entries.append({"effects": [names[i]], "absorbed": True, "kept": round(float(similarity.kept[i]), 3)})
        entries += [
            {"effects": [names[i], names[j]], "cosine": round(float(similarity.cosines[i, j]), 3)}
            for j in range(i + 1, n)
            if abs(similarity.cosines[i, j]) > ALIKE
        ]
    return entries


def sentence(decision: Decision, probability: float) -> str:
    """Return the verdict in a sentence."""
    if decision.verdict == "no_gap":
        return f"No gap: {decision.reason}."
    if decision.verdict == "unknown":
        known = [names for names in decision.group if names != UNKNOWN]
        if not known:
            return f"There is a gap, and none of the known effects explains it: {decision.reason}."
        further = " or ".join(in_words(names) for names in known if names != decision.best)
        rivals = f"; it may be {further}" if further else ""
        return f"There is a gap, and its cause is not certain: {decision.reason}{rivals}."
    others = [names for names in decision.group if names != decision.best]
    rivals = f"; the data cannot tell it from {', or '.join(map(in_words, others))}" if others else ""
    return f"The gap is caused by {in_words(decision.best)} (probability {100 * probability:.0f} %){rivals}."


def gap_in_fit(fitted: Fitted) -> float:
    """Return chi-square per datum of a fit."""
    return round(fitted.minimum.misfit / len(fitted.minimum.residual), 4)


def _parameters(fitted: Fitted) -> dict[str, Any]:
    entries = {}
    named = fitted.hypothesis.bare(fitted.minimum.z)[0]
    for parameter in named.effect_parameters:
        value, low, high = fitted.interval(parameter.name)
        entries[parameter.name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
    return entries
