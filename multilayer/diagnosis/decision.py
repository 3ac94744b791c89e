"""What is decided from the evidence of all hypotheses: a cause, none that is known, or no gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.evidence import UNKNOWN, Hypotheses
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.strain import probability_text, strain
from multilayer.diagnosis.thresholds import (
    FULL_FIT,
    FULL_SHRINKAGE,
    LEAST_SHRINKAGE,
    LEAST_SHRINKAGE_ONE,
    MOST_UNDONE,
    RIGHT_GUARDED,
    RIGHT_NO_GAP,
    SEEN_HELD_OUT,
    TIED,
)

Verdict = Literal["effect", "unknown", "no_gap"]


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
    guarded : bool
        Whether the verdict is "unknown" against the evidence.
    """

    verdict: Verdict
    best: tuple[str, ...]
    group: list[tuple[str, ...]]
    reason: str
    guarded: bool = False

    def probability(self, found: Hypotheses) -> float:
        """Return the probability that the verdict is right.

        Where a guard overrules the evidence (a misfit that remains, or no shrinkage on held-out data), and where there
        is no gap, no less than what such verdicts reached on development runs.
        """
        probabilities = found.probabilities()
        if self.verdict == "no_gap":
            return max(probabilities[()], RIGHT_NO_GAP)
        if self.verdict == "unknown":
            return max(probabilities[UNKNOWN], RIGHT_GUARDED if self.guarded else 0.0)
        return found.probability_with([self.best])


def decide(found: Hypotheses, shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> Decision:
    """Return the verdict; see the thresholds."""
    if not found.is_gap:
        text = f"a misfit as large has the probability {found.p_value:.2g} without any effect"
        if found.is_supported and found.best_fitted:
            change = f"{100 * found.gap_size:.2f} %"
            text += (
                f", and {in_words(found.best_fitted)} would change the data by {change}, less than solvers differ by"
            )
        return Decision("no_gap", (), [], text)
    if not found.is_supported:
        probability = probability_text(found.p_value)
        text = f"a misfit as large has the probability {probability}, and no known effect makes it more probable"
        return Decision("unknown", UNKNOWN, [UNKNOWN], text, guarded=True)
    best = _carried_over(found, found.ranked[0], shrinkage)
    if best == UNKNOWN:
        text = "a smooth discrepancy explains the gap better than any known effect"
        return Decision("unknown", best, _group(found, best), text)
    group = _group(found, best)
    if reason := _mistrust(found, best, shrinkage):
        return Decision("unknown", best, group, reason, guarded=True)
    if found.probability_with(group) < found.probabilities()[UNKNOWN]:
        text = f"{in_words(best)} explains most, but that it is something else is more probable"
        return Decision("unknown", best, group, text)
    return Decision("effect", best, group, f"{in_words(best)} explains the gap")


def _mistrust(found: Hypotheses, best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> str:
    """Return why the best cause is not named; empty where it is."""
    share = _seen_share(best, shrinkage)
    if left := strain(found.fitted[best], forgiven=len(best) == 1 and _explains_enough(found, best, share)):
        return f"{in_words(best)} explains most, but {left}"
    if doubt := _not_foretold(found, best, shrinkage):
        return f"with {in_words(best)} {doubt}"
    return _mistrust_of_two(found, best, shrinkage) if len(best) > 1 else ""


def _not_foretold(found: Hypotheses, best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> str:
    """Return what speaks against a cause on held-out data."""
    share = _seen_share(best, shrinkage)
    if share is None:
        worse = best in shrinkage and shrinkage[best].after > SEEN_HELD_OUT
        return "held-out data are foretold worse than without" if worse else ""
    least = LEAST_SHRINKAGE if found.several else LEAST_SHRINKAGE_ONE
    return f"the gap on held-out data shrinks by {100 * share:.0f} % only" if share < least else ""


def _mistrust_of_two(found: Hypotheses, best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> str:
    """Return why two effects that fit are not named."""
    label, share = in_words(best), _seen_share(best, shrinkage)
    if not found.several:
        return f"only two effects at once, such as {label}, explain it, and one configuration cannot tell such apart"
    if (times := undone(found.fitted[best])) > MOST_UNDONE:
        return f"{label} would nearly undo each other, each by itself {times:.1f} times as large as both together"
    alone = max((held.share, names) for names, held in shrinkage.items() if len(names) == 1)
    if share is not None and alone[0] >= share:
        return f"{label} explains most, but {in_words(alone[1])} alone does as well on held-out data"
    return ""


def _seen_share(best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]) -> float | None:
    """Return the shrinkage on held-out data; None where there is next to no gap on these."""
    held = shrinkage.get(best)
    return held.share if held is not None and held.before > SEEN_HELD_OUT else None


def undone(fitted: Fitted) -> float:
    """Return how many times what two effects change together the lesser of them changes, the other being there.

    Two laws that are far off and nearly undo each other leave a difference that fits much; what two effects of a rig
    change has little to do with each other.
    """
    hypothesis, z = fitted.hypothesis, fitted.minimum.z
    whole = hypothesis.residual(z)
    nothing = hypothesis.with_effects().residual(z[: len(z) - len(hypothesis.effect_parameters)])
    parts = []
    for index in range(len(hypothesis.effects)):
        others, rest = hypothesis.without(index, z)
        parts.append(float(np.linalg.norm(whole - others.residual(rest))))
    return min(parts) / max(float(np.linalg.norm(whole - nothing)), 1e-12)


def _explains_enough(found: Hypotheses, best: tuple[str, ...], share: float | None) -> bool:
    """Tell whether an effect may be right although it leaves a misfit, because it explains so much of a huge gap."""
    if share is None:
        return False
    before, after = (one.minimum.cost_per_datum - 1 for one in (found.nominal, found.fitted[best]))
    return share > FULL_SHRINKAGE or (share > LEAST_SHRINKAGE and after < (1 - FULL_FIT) * before)


def _carried_over(
    found: Hypotheses, best: tuple[str, ...], shrinkage: Mapping[tuple[str, ...], Shrinkage]
) -> tuple[str, ...]:
    """Return one effect in place of two where it explains the gap by itself.

    A plate bends under an accelerometer: that is no second cause.
    """
    parts = [names for names in shrinkage if len(names) < len(best) and set(names) <= set(best)]
    seen = {names: _seen_share(names, shrinkage) for names in parts}
    parts = [names for names, share in seen.items() if share is None or share >= LEAST_SHRINKAGE]
    enough = [names for names in parts if not strain(found.fitted[names])]
    if parts and not enough and strain(found.fitted[best]):  # two are not better than one
        enough = [
            names
            for names in parts
            if _explains_enough(found, names, seen[names]) and not strain(found.fitted[names], forgiven=True)
        ]
    return max(enough, key=found.score, default=best)


def _group(found: Hypotheses, best: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return the causes that the data cannot tell from the best; with a second effect beside it, it is the same one."""
    top = found.score(best)
    tied = [names for names in found.ranked if names != UNKNOWN and top - found.score(names) < TIED]
    return [best, *(names for names in tied if not set(best) <= set(names))]


def in_words(names: Sequence[str]) -> str:
    """Return names of effects for people."""
    return " and ".join(name.replace("_", " ") for name in names)
