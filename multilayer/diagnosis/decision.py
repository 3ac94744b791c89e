"""The decision from the evidence of all hypotheses: a known cause, an unknown one, or no gap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Literal

import numpy as np

from multilayer.diagnosis.causality import is_causal
from multilayer.diagnosis.cross_validation import Shrinkage
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison
from multilayer.diagnosis.goodness_of_fit import is_enough, lack_of_fit, probability_text, statement_most_off
from multilayer.diagnosis.place_fits import PlaceFit, SimpleForm
from multilayer.diagnosis.places import BasePlace
from multilayer.diagnosis.thresholds import (
    CERTAIN_P,
    FORM_AHEAD,
    FULL_FIT,
    FULL_SHRINKAGE,
    LEAD_SHARE,
    LEAST_LEAD,
    LEAST_SCORE,
    LEAST_SHRINKAGE,
    LEAST_SHRINKAGE_ONE,
    RIGHT_DOUBTED,
    RIGHT_GUARDED,
    RIGHT_NO_GAP,
    SECOND_SHARE,
    SECOND_TERM,
    SEEN_HELD_OUT,
    SHRINKAGE_REACH,
    TEMPERATURE,
    TIED,
)

_MOST_TOLD = 3  # places in a sentence
Verdict = Literal["effect", "unknown", "no_gap"]


@dataclass(frozen=True)
class Decision:
    """A verdict with its reason.

    Attributes
    ----------
    verdict : {'effect', 'unknown', 'no_gap'}
    best : tuple of str
        The cause; empty without a gap.
    group : list of tuple of str
        Hypotheses that the data cannot distinguish from the verdict's, that one first: that of an unknown cause alone
        where no known one is as probable.
    reason : str
    least_probability : float
        Share of such verdicts that were right on development runs, where a guard overrules the evidence.
    """

    verdict: Verdict
    best: tuple[str, ...]
    group: list[tuple[str, ...]]
    reason: str
    least_probability: float = 0.0

    def probability(self, comparison: ModelComparison) -> float:
        """Return the probability that the verdict is right.

        Where a guard overrules the evidence (a misfit that remains, no shrinkage on held-out data, a free law that is
        nearly as probable), and where there is no gap, it is at least the share of such verdicts that were right on
        development runs.
        """
        probabilities = comparison.probabilities()
        if self.verdict == "no_gap":
            return max(probabilities[()], RIGHT_NO_GAP)
        if self.verdict == "unknown":
            return max(probabilities[UNKNOWN], self.least_probability)
        return comparison.probability_with([self.best])

    def probabilities(self, comparison: ModelComparison) -> dict[tuple[str, ...], float]:
        """Return the probabilities of all hypotheses as they agree with the verdict's; they add up to 1.

        Two effects of which the verdict considers one, as that explains the gap by itself, count with that one.
        """
        shares, stated = comparison.probabilities(), self.probability(comparison)
        if self.best in comparison.fitted:
            together = comparison.probability_with([self.best])
            shares |= {names: 0.0 for names in shares if set(self.best) < set(names)} | {self.best: together}
        if self.verdict == "effect":
            return shares
        chosen = () if self.verdict == "no_gap" else UNKNOWN
        others = sum(share for names, share in shares.items() if names != chosen)
        scale = (1 - stated) / others if others > 0 else 0.0
        return {names: stated if names == chosen else scale * share for names, share in shares.items()}


def decide(comparison: ModelComparison, shrinkages: Mapping[tuple[str, ...], Shrinkage]) -> Decision:
    """Return the verdict by the thresholds; the rules stand in ``docs/theory/diagnosis.md``."""
    if not comparison.is_gap:
        text = f"a misfit as large has the probability {comparison.p_value:.2g} without any effect"
        if comparison.is_supported and comparison.best_fitted:
            change = f"{100 * comparison.gap_size:.2f} %"
            cause = in_words(comparison.best_fitted)
            text += f", and {cause} would change the data by {change}, less than solvers differ by"
        return Decision("no_gap", (), [], text)
    if not comparison.is_supported:
        text = f"a misfit as large has the probability {probability_text(comparison.p_value)}"
        if comparison.stated_p_value <= CERTAIN_P:
            text = "what is stated of the laboratory is off, which has the probability "
            text += f"{probability_text(comparison.stated_p_value)} ({statement_most_off(comparison.nominal)})"
        text += ", and no known effect makes it more probable"
        return Decision("unknown", UNKNOWN, [UNKNOWN], text, RIGHT_GUARDED)
    best = _single_where_enough(comparison, comparison.ranked[0], shrinkages)
    best = _single_where_tied(comparison, best, shrinkages)
    unknown = partial(_unknown, comparison, shrinkages)
    if best == UNKNOWN:
        return unknown(best, f"{_free(comparison)} explains the gap better than any known effect")
    if reason := _objection(comparison, best, shrinkages):
        return unknown(best, reason, RIGHT_GUARDED)
    group = _group(comparison, best)
    if doubt := _doubt(comparison, best, group):
        return unknown(best, *doubt)
    return Decision("effect", best, group, f"{in_words(best)} {_explain(best)} the gap")


def _unknown(
    comparison: ModelComparison,
    shrinkages: Mapping[tuple[str, ...], Shrinkage],
    best: tuple[str, ...],
    reason: str,
    least_probability: float = 0.0,
) -> Decision:
    """Return the verdict of an unknown cause, with the known ones whose stated probability is as near as in a group.

    Those that a misfit or held-out data speak against are not among them, nor two effects beside one of the two.
    """
    alone = Decision("unknown", best, [UNKNOWN], reason, least_probability)
    probabilities = alone.probabilities(comparison)
    least = probabilities[UNKNOWN] * np.exp(-TIED / TEMPERATURE)
    near = [names for names in comparison.ranked if names in comparison.fitted and probabilities[names] >= least]
    group = [UNKNOWN]
    for names in near:
        is_another = not set(best) < set(names) and not any({*one} <= {*names} or {*names} <= {*one} for one in group)
        if is_another and not _refutation(comparison, names, shrinkages):
            group.append(names)
    return replace(alone, group=group)


def _doubt(
    comparison: ModelComparison, best: tuple[str, ...], group: list[tuple[str, ...]]
) -> tuple[str, float] | None:
    """Return why a cause is not named, and the least probability of an unknown one, or None.

    Where a free law, better than no effect at all, is nearly as probable.

    A law of few parameters that is right leaves a free one far behind, as that pays for each of its nodes. One that
    merely resembles the true law loses in misfit what it saves on parameters. Where the data tell little of the nodes,
    so that they cost little, the lead is small however right the law is: there it is compared with their cost. Of tubes
    and levels, whose few data leave the nodes cheap, the free law must be the more probable one.
    """
    if comparison.nominal.hypothesis.held_out_decides:
        lead = comparison.score(best) - comparison.score(UNKNOWN)
        if lead >= LEAST_LEAD or comparison.score(UNKNOWN) - comparison.score(()) <= LEAST_SCORE:
            return None
        if lead >= LEAST_SCORE and comparison.lead_at_place(best) >= LEAD_SHARE:
            return None
        if lead >= 0:
            free = _free(comparison)
            text = f"{in_words(best)} {_explain(best)} it, but hardly better than {free}, which can be anything"
            return text, RIGHT_DOUBTED
    elif comparison.probability_with(group) >= comparison.probabilities()[UNKNOWN]:
        return None
    return f"{in_words(best)} {_explain(best)} most, but {_free(comparison)} is more probable", RIGHT_DOUBTED


def objection_to_law(comparison: ModelComparison, free: PlaceFit, shrinkage: Shrinkage) -> str:
    """Return why a law drawn at a place does not explain the gap; empty where it does.

    By the measures of known causes. A free law at the right place may miss no more of a huge gap than a second cause
    adds (`SECOND_SHARE`), and no known response is without its cause.

    Parameters
    ----------
    comparison : ModelComparison
    free : PlaceFit
    shrinkage : Shrinkage
        Of the gap on held-out data, with that law.
    """
    if not comparison.is_supported:
        return "is hardly more probable than no law at all"
    if not is_enough(comparison.nominal, free.explanation):
        return lack_of_fit(free.explanation, of_law=False)
    share = _visible(shrinkage)
    if share is not None and share < _least_share(comparison, shrinkage):
        return f"shrinks the gap on held-out data by {100 * share:.0f} % only"
    return "is not that of a causal response" if is_causal(free) is False else ""


def beside_simple_term(
    decision: Decision,
    comparison: ModelComparison,
    shrinkages: Mapping[tuple[str, ...], Shrinkage],
    term: SimpleForm,
) -> Decision:
    """Return the verdict on a single effect beside a simple term at its place: unknown where that is the better law.

    Of a cause whose law has the right shape no simple term, which has no error, is ahead.

    Parameters
    ----------
    decision : Decision
        That names the effect.
    comparison : ModelComparison
    shrinkages : mapping
        By names, of causes that were checked on held-out data.
    term : SimpleForm
    """
    if term.log_evidence - comparison.evidence[decision.best] < FORM_AHEAD:
        return decision
    where = where_in_words(term.place)
    text = (
        f"{in_words(decision.best)} {_explain(decision.best)} most, but a simple law of its own {where} does so better"
    )
    return _unknown(comparison, shrinkages, UNKNOWN, text, RIGHT_GUARDED)


def _free(comparison: ModelComparison) -> str:
    """Return what explains the gap where no known effect does, in words."""
    if not comparison.places:
        return "a smooth discrepancy"
    tied = [where_in_words(fit.place) for fit in comparison.tied_places[:_MOST_TOLD]]
    return f"a law of its own {' or '.join(tied)}"


def where_in_words(place: BasePlace) -> str:
    """Return where a place is, for people."""
    return f"{place.title} ({place.configuration})" if place.configuration else place.title


def _objection(
    comparison: ModelComparison, best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> str:
    """Return why the best cause is not named; empty where it is named."""
    if reason := _refutation(comparison, best, shrinkages):
        return reason
    return _objection_to_two(comparison, best, shrinkages) if len(best) > 1 else ""


def _refutation(
    comparison: ModelComparison, names: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> str:
    """Return what speaks against a cause by itself: a misfit, or held-out data; empty where nothing does."""
    is_misfit_allowed = _explains_enough(comparison, names, _visible_share(names, shrinkages))
    if reason := lack_of_fit(comparison.fitted[names], is_misfit_allowed=is_misfit_allowed):
        return f"{in_words(names)} {_explain(names)} most, but {reason}"
    reason = _held_out_objection(comparison, names, shrinkages) or _part_made_worse(comparison, names, shrinkages)
    return f"with {in_words(names)} {reason}" if reason else ""


def _held_out_objection(
    comparison: ModelComparison, best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> str:
    """Return what speaks against a cause on held-out data; empty where nothing does."""
    share = _visible_share(best, shrinkages)
    if share is None:
        shrinkage = shrinkages.get(best)
        worse = shrinkage is not None and shrinkage.after > SEEN_HELD_OUT * shrinkage.noise
        return "held-out data are foretold worse than without" if worse else ""
    least = _least_share(comparison, shrinkages[best])
    return f"the gap on held-out data shrinks by {100 * share:.0f} % only" if share < least else ""


def _part_made_worse(
    comparison: ModelComparison, names: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> str:
    """Return what speaks against a cause that fits and foretells a part of the held-out data worse than nothing does.

    The gap on held-out data may be that of a single part, which hides the others. Worse is what noise makes of a part
    once in twenty at most. A cause that leaves a misfit of a huge gap has a law that is not right to that anyway; of
    tubes and levels errors are common to all parts.
    """
    if names not in shrinkages or not comparison.nominal.hypothesis.held_out_decides:
        return ""
    shrinkage = shrinkages[names]
    is_worse = any(
        part.after > SEEN_HELD_OUT * shrinkage.noise
        and part.after - part.before > SHRINKAGE_REACH * shrinkage.noise * np.sqrt(2 / part.n)
        for part in shrinkage.parts
    )
    fits = is_worse and not lack_of_fit(comparison.fitted[names])
    return "a part of the held-out data is foretold worse than without" if fits else ""


def _least_share(comparison: ModelComparison, shrinkage: Shrinkage) -> float:
    """Return the shrinkage below which a cause is not named.

    Few data, as of levels in bands, leave it a scatter: what noise makes of it once in twenty is no objection there.
    """
    least = LEAST_SHRINKAGE if comparison.several else LEAST_SHRINKAGE_ONE
    decides = comparison.nominal.hypothesis.held_out_decides
    return least if decides else least - SHRINKAGE_REACH * shrinkage.scatter


def _objection_to_two(
    comparison: ModelComparison, best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> str:
    """Return why two effects that fit are not named; empty where they are."""
    label, share = in_words(best), _visible_share(best, shrinkages)
    if not comparison.several:
        return f"only two effects at once, such as {label}, explain it, and one configuration cannot tell such apart"
    singles = [names for names in shrinkages if len(names) == 1 and not _part_made_worse(comparison, names, shrinkages)]
    alone = max(((shrinkages[names].share, names) for names in singles), default=(0.0, ()))
    if share is not None and alone[0] >= share:
        return f"{label} {_explain(best)} most, but {in_words(alone[1])} alone does as well on held-out data"
    return ""


def _visible_share(best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]) -> float | None:
    """Return the shrinkage on held-out data; None where these show next to no gap."""
    return _visible(shrinkages.get(best))


def _visible(shrinkage: Shrinkage | None) -> float | None:
    return shrinkage.share if shrinkage is not None and shrinkage.before > SEEN_HELD_OUT * shrinkage.noise else None


def _explains_enough(comparison: ModelComparison, best: tuple[str, ...], share: float | None) -> bool:
    """Tell whether a cause may be right although it leaves a misfit, because it explains so much of a huge gap.

    Two effects must explain more than one: all but what the law of one may miss.
    """
    if share is None:
        return False
    before, after = (fit.minimum.cost_per_datum - 1 for fit in (comparison.nominal, comparison.fitted[best]))
    if len(best) > 1:
        return share > FULL_SHRINKAGE and after < SECOND_SHARE * before
    return share > FULL_SHRINKAGE or (share > LEAST_SHRINKAGE and after < (1 - FULL_FIT) * before)


def _single_where_enough(
    comparison: ModelComparison, best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> tuple[str, ...]:
    """Return a single effect in place of two where it explains the gap by itself and the second adds little.

    For instance, a plate bends under an accelerometer: this is no second cause.
    """
    parts = [names for names in shrinkages if len(names) < len(best) and set(names) <= set(best)]
    if not parts:
        return best
    shares = {names: _visible_share(names, shrinkages) for names in parts}
    parts = [names for names, share in shares.items() if share is None or share >= LEAST_SHRINKAGE]
    parts = [names for names in parts if not _part_made_worse(comparison, names, shrinkages)]
    # by the fitted data alone: both foretell held-out data, where a little that a law misses costs as much again
    near = [names for names in parts if comparison.fitted_score(best) - comparison.fitted_score(names) < SECOND_TERM]
    # what a law misses of a huge gap must not be taken for a second effect
    remains = [names for names in parts if _second_share(comparison, names, best) < SECOND_SHARE]
    enough = [names for names in {*near, *remains} if not lack_of_fit(comparison.fitted[names])]
    if not enough:  # nor two effects be taken for better than one where they leave a misfit, too
        allowed = {*near, *remains} if lack_of_fit(comparison.fitted[best]) else set(remains)
        enough = [
            names
            for names in allowed
            if _explains_enough(comparison, names, shares[names])
            and not lack_of_fit(comparison.fitted[names], is_misfit_allowed=True)
        ]
    return max(enough, key=comparison.score, default=best)


def _single_where_tied(
    comparison: ModelComparison, best: tuple[str, ...], shrinkages: Mapping[tuple[str, ...], Shrinkage]
) -> tuple[str, ...]:
    """Return a single effect in place of two where the data cannot tell them apart and nothing speaks against it."""
    if len(best) < 2:
        return best
    tied = [names for names in _group(comparison, best) if len(names) == 1 and names in shrinkages]
    return next((names for names in tied if not _objection(comparison, names, shrinkages)), best)


def _second_share(comparison: ModelComparison, single: tuple[str, ...], both: tuple[str, ...]) -> float:
    """Return what a second effect adds to the evidence, over what the first explains."""
    first = comparison.evidence[single] - comparison.evidence[()]
    return (comparison.evidence[both] - comparison.evidence[single]) / first if first > 0 else float("inf")


def _group(comparison: ModelComparison, best: tuple[str, ...]) -> list[tuple[str, ...]]:
    """Return the best cause and those that the data cannot distinguish from it, without supersets of the best."""
    return [best, *(names for names in comparison.tied_with(best) if not set(best) <= set(names))]


def in_words(names: Sequence[str]) -> str:
    """Return names of effects for people."""
    return " and ".join(name.replace("_", " ") for name in names)


def _explain(names: Sequence[str]) -> str:
    return "explains" if len(names) == 1 else "explain"
