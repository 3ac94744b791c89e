"""Two causes at once, at least one of them unknown: a known effect or a free law, and a free law at another place.

Where no cause explains the data by itself, the best one is taken for part of the model, and what is left of the gap is
looked for at all places.
"""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

from multilayer.diagnosis.cross_validation import cross_validate
from multilayer.diagnosis.decision import in_words
from multilayer.diagnosis.evidence import ModelComparison
from multilayer.diagnosis.fitting import Fitted, at_minimum
from multilayer.diagnosis.goodness_of_fit import is_enough
from multilayer.diagnosis.place_entries import DrawnPlace, law_entry
from multilayer.diagnosis.place_fits import PlaceFit, as_told, fit_places
from multilayer.diagnosis.simple_forms import simple_form
from multilayer.diagnosis.thresholds import LEAST_SHRINKAGE, SECOND_TERM
from multilayer.experiments.two_plate.campaign import CampaignProblem


@dataclass(frozen=True)
class TwoCauses:
    """A cause, and a free law at another place beside it.

    Attributes
    ----------
    first : PlaceFit or None
        The free law beside the second one; None where the first cause is a known effect.
    names : tuple of str
        Names of the known effect; empty where the first cause is a free law.
    place : str
        Name of the first cause's place; empty where it has none.
    drawn : DrawnPlace
        The second cause, with the shrinkage by both.
    """

    first: PlaceFit | None
    names: tuple[str, ...]
    place: str
    drawn: DrawnPlace

    @property
    def explanation(self) -> Fitted:
        """The fit with both; the first cause is part of its nominal model."""
        return self.drawn.free.explanation


def two_causes(comparison: ModelComparison, executor: Executor | None = None) -> TwoCauses | None:
    """Return the best known effect or free law with a free law at another place, where both together explain the data.

    They must fit, or leave no more of the gap than a law may miss; have more evidence than any single cause; and
    foretell configurations that were left out. A single configuration cannot tell two causes apart.

    Parameters
    ----------
    comparison : ModelComparison
        Of a campaign, whose verdict is an unknown cause.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    best_alone = next(iter(comparison.places.values()), None)
    if not comparison.several or best_alone is None or is_enough(comparison.nominal, best_alone.explanation):
        return None
    known = [names for names in comparison.ranked if len(names) == 1 and names in comparison.fitted]
    firsts = [comparison.fitted[names] for names in known[:1]] + [best_alone.explanation]
    pairs = [(first, *_beside(comparison, first, executor)) for first in firsts]
    first, base, second = max(pairs, key=lambda pair: pair[2].log_evidence)
    alone = max([best_alone.log_evidence, *(comparison.evidence[names] for names in known)])
    if second.log_evidence < alone + SECOND_TERM or not is_enough(comparison.nominal, second.explanation):
        return None
    (shrinkage,) = cross_validate(comparison.nominal, [second.explanation], executor, noise=comparison.noise)
    if shrinkage.share < LEAST_SHRINKAGE:
        return None
    is_known = first is not best_alone.explanation
    effect = first.hypothesis.effects[0]
    told = as_told(base, second)
    drawn = DrawnPlace(told, simple_form(base, told, executor), shrinkage)
    place = effect.place if is_known else best_alone.place.name
    return TwoCauses(None if is_known else best_alone, first.names if is_known else (), place, drawn)


def _beside(comparison: ModelComparison, first: Fitted, executor: Executor | None) -> tuple[Fitted, PlaceFit]:
    """Return the nominal model with the first cause as part of it, and the best free law at another place."""
    problem = comparison.nominal.hypothesis_as(CampaignProblem)
    effects = first.hypothesis_as(CampaignProblem).effects
    rigs = problem.finite if any(effect.needs_finite_elements for effect in effects) else problem.rigs
    whole = replace(problem, rigs=rigs, given=(*problem.given, *effects))
    base = at_minimum(whole, first.minimum.z)
    taken = {effect.place or effect.name for effect in effects}
    places = fit_places(base, executor, [fit.place.name for fit in comparison.places.values()])
    return base, next(fit for label, fit in places.items() if label not in taken)


def two_causes_entry(two: TwoCauses) -> dict[str, Any]:
    """Return the entry ``two_causes`` of ``diagnosis.json``: the first cause, place and law of the second one.

    `law` has the keys of the entry of the same name; a first cause that is a free law has its place only. `parameters`
    are those of a known effect, with 90 % intervals.
    """
    law, share = law_entry(two.drawn), two.drawn.shrinkage.share
    known = in_words(two.names) if two.first is None else f"a law of its own {two.first.place.title}"
    like = f" that acts like {law['form']['text']}" if law["form_is_enough"] else ""
    second = f"{'another' if two.first else 'a law of its own'} {two.drawn.free.place.title}{like}"
    return {
        "text": f"Two causes at once explain {100 * share:.0f} % of the gap on held-out data: {known}, and {second}.",
        "effects": list(two.names),
        "parameters": _parameters(two) if two.names else {},
        "places": [two.place, two.drawn.free.place.name],
        "shrinkage": round(share, 4),
        "law": law,
    }


def _parameters(two: TwoCauses) -> dict[str, dict[str, Any]]:
    entries = {}
    for parameter in two.explanation.hypothesis.parameters:
        if parameter.name.startswith(f"{two.names[0]}."):
            value, low, high = two.explanation.interval(parameter.name)
            entries[parameter.name] = {"value": value, "low": low, "high": high, "unit": parameter.unit}
    return entries
