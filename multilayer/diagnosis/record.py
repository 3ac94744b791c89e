"""Entries of ``diagnosis.json`` that are the same for every kind of measurement."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.decision import Decision, in_words
from multilayer.diagnosis.evidence import UNKNOWN, Hypotheses
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.result import Similarity
from multilayer.diagnosis.thresholds import ABSORBED, ALIKE

_SHOWN_CAUSES = 8


def worth_checking(found: Hypotheses) -> list[tuple[str, ...]]:
    """Return the hypotheses to check on held-out data: the best, its single effects, its rival, the best single one."""
    ranked = [names for names in found.ranked if names in found.fitted]
    parts = [(name,) for name in ranked[0] if (name,) in found.fitted] if ranked else []
    single = next((names for names in ranked if len(names) == 1), None)
    return list(dict.fromkeys([*ranked[:2], *parts, *([single] if single else [])]))


def cause_entries(
    found: Hypotheses,
    held: Mapping[tuple[str, ...], Shrinkage],
    similarity: Similarity,
    probabilities: Mapping[tuple[str, ...], float],
    group: Sequence[tuple[str, ...]],
) -> list[dict[str, Any]]:
    """Return the entries of ``causes``, the most probable first; the nominal model stands among its rivals.

    The group of the verdict is among them, however many pairs with a second effect are more probable.
    """
    kept = dict(zip(similarity.names, similarity.kept, strict=True))
    causes = []
    shown = dict.fromkeys([*found.ranked[:_SHOWN_CAUSES], *group, UNKNOWN, ()])
    ranked = sorted(shown, key=lambda names: -found.score(names))
    for names in ranked:
        entry: dict[str, Any] = {
            "effects": list(names),
            "probability": round(probabilities[names], 4),
            "log_evidence": round(found.evidence[names], 2),
            "score": round(found.score(names), 2),
            "parameters": {},
            "gap_before": gap_in_fit(found.nominal),
        }
        if names not in (UNKNOWN, ()):
            fitted = found.fitted[names]
            after = gap_in_fit(fitted)
            entry["parameters"] = _parameters(fitted)
            entry["gap_after"] = after
            entry["shrinkage"] = round(held[names].share, 4) if names in held else _share(entry["gap_before"], after)
            entry["absorbed"] = any(kept[name] < ABSORBED for name in names)
        causes.append(entry)
    return causes


def gap_entry(nominal: Fitted, held: Shrinkage | None) -> dict[str, Any]:
    """Return the entry ``gap``: on held-out data, in the fit where nothing was left out."""
    if held is None:
        before = gap_in_fit(nominal)
        return {"before": before, "after": before, "shrinkage": 0.0, "held_out": "nothing: there is no gap"}
    return {
        "before": round(held.before, 4),
        "after": round(held.after, 4),
        "shrinkage": round(held.share, 4),
        "held_out": held.held_out,
    }


def confounded_entries(similarity: Similarity) -> list[dict[str, Any]]:
    """Return the entries of ``confounded``: signatures that the unknowns absorb, and pairs that are one."""
    found: list[dict[str, Any]] = []
    n = len(similarity.names)
    for i in range(n):
        if similarity.kept[i] < ABSORBED:
            found.append(
                {"effects": [similarity.names[i]], "absorbed": True, "kept": round(float(similarity.kept[i]), 3)}
            )
        found += [
            {"effects": [similarity.names[i], similarity.names[j]], "cosine": round(float(similarity.cosines[i, j]), 3)}
            for j in range(i + 1, n)
            if abs(similarity.cosines[i, j]) > ALIKE
        ]
    return found


def sentence(found: Hypotheses, decision: Decision, probability: float) -> str:
    """Return the verdict in a sentence."""
    if decision.verdict == "no_gap":
        return f"No gap: {decision.reason}."
    if decision.verdict == "unknown":
        return f"There is a gap, and none of the known effects explains it: {decision.reason}."
    others = [names for names in decision.group if names != decision.best]
    rivals = f"; the data cannot tell it from {', or '.join(map(in_words, others))}" if others else ""
    return f"The gap is caused by {in_words(decision.best)} (probability {100 * probability:.0f} %){rivals}."


def gap_in_fit(fitted: Fitted) -> float:
    """Return chi-square per datum of a fit."""
    return round(fitted.minimum.misfit / len(fitted.minimum.residual), 4)


def _parameters(fitted: Fitted) -> dict[str, Any]:
    found = {}
    for parameter in fitted.hypothesis.effect_parameters:
        value, low, high = fitted.interval(parameter.name)
        found[parameter.name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
    return found


def _share(before: float, after: float) -> float:
    return round(1 - max(after - 1, 0.0) / max(before - 1, 1e-9), 4) if before > 1 else 0.0
