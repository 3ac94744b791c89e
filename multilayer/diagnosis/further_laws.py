"""What is tried at places where neither a known effect nor a smooth law explains the data.

Laws that vary faster, resonances, rims of the sample in finite elements, and laws that differ from configuration to
configuration.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

import numpy as np

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.causality import is_causal
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.effects.delamination import Delamination, WornRim
from multilayer.diagnosis.effects.finite_size import FiniteSize
from multilayer.diagnosis.fitting import (
    COARSELY,
    Fitted,
    begin_tasks,
    best_of,
    finish_all,
    minimise_scaled,
)
from multilayer.diagnosis.free_rim import free_rim, with_rigs
from multilayer.diagnosis.goodness_of_fit import explains_data, is_enough
from multilayer.diagnosis.place_fits import (
    COARSE,
    FINE,
    PlaceFit,
    begun_at,
    best_variant,
    descended,
    finished,
    near_best,
    ranked,
    scale_of,
    unfinished,
)
from multilayer.diagnosis.places import BasePlace
from multilayer.diagnosis.places.beside import Faces, OpenFaces
from multilayer.diagnosis.places.sample import SampleShape
from multilayer.diagnosis.simple_forms import RESONANCES, descents, nearest_form
from multilayer.diagnosis.starting_laws import other_starts
from multilayer.diagnosis.thresholds import FIT_P, LAW_SIZES
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.executors import call, run_all
from multilayer.experiments.places import (
    SHORT,
    DifferingLaw,
    DrawnLaw,
    LawAtPlace,
    MovingLaw,
    SimpleLaw,
    Term,
    VaryingLaw,
)
from multilayer.experiments.two_plate.campaign import Acting, CampaignProblem
from multilayer.inference.multistart import costs_per_datum
from multilayer.inference.priors import Priors
from multilayer.inference.problem import Minimum

_TRENDS = (-1.0, 0.0, 1.0)  # of shifts of a law that moves, standard deviations in the last configuration at the start
_CONSTANTS = (0j, 0.3 + 0j)  # of a law that varies, beyond what it was before: standard deviations at the start
_LIKELY = 3  # resonances that are followed, of those of the grid


def with_further_laws(
    nominal: Fitted,
    minima: list[Minimum],
    effects: Mapping[str, BaseEffect],
    places: dict[str, PlaceFit],
    executor: Executor | None,
) -> tuple[Fitted, dict[str, PlaceFit]]:
    """Return the nominal model, with finite elements where a rim matters, and the places with what else they may hold.

    Parameters
    ----------
    nominal, minima
        As `diagnose.fit_nominal` returns them.
    effects : mapping
        Known effects, by name: what these have of the sample's rims is not drawn.
    places : mapping
        As `fit_places` returns them.
    executor : Executor or None
        Where fits run; None for this process.
    """
    places = with_resonances(nominal, places, executor)
    nominal, places = search_free_rim(nominal, minima, effects, places)
    places = search_open_rims(nominal, minima, effects, places, executor)
    for differing in (VaryingLaw, MovingLaw):
        if not explain_data(places):
            places = with_differing_laws(differing, nominal, places, executor)
    return nominal, places


def explain_data(places: Mapping[str, PlaceFit]) -> bool:
    """Tell whether a law at some place explains the data (`explains_data`)."""
    return any(explains_data(place.explanation) for place in places.values())


def has_open_rims(given: Sequence[Acting]) -> bool:
    """Tell whether the nominal model has open rims, by name or as a law that stands beside them."""
    places = [effect.at_place for effect in given if isinstance(effect, LawAtPlace)]
    return Delamination.name in [effect.name for effect in given] or any(isinstance(p, OpenFaces) for p in places)


def with_resonances(
    nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places with laws that vary faster or resonate, where that has more evidence.

    For data that neither a known effect nor a smooth law fits: ten nodes cannot hold a sharp resonance. It is tried at
    all places: where no law fits, their order means little.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    smooth = list(places.values())
    tasks = [partial(begun_at, nominal, fit.place, SHORT) for fit in smooth if not fit.place.needs_finite_elements]
    rough = {fit.place.label: fit for fit in map(unfinished, run_all(call, tasks, executor))}
    pairs = [(fit, rough.get(fit.place.label, fit)) for fit in smooth]
    fits = [max(pair, key=lambda fit: fit.log_evidence) for pair in pairs]
    return ranked(run_all(partial(_with_resonance, nominal), fits, executor))


def search_free_rim(
    nominal: Fitted, minima: list[Minimum], effects: Mapping[str, BaseEffect], places: dict[str, PlaceFit]
) -> tuple[Fitted, dict[str, PlaceFit]]:
    """Return the nominal model with finite elements, and the places with a rim that is free in these.

    Only where no known effect has these elements, and a rim matters.
    """
    problem = nominal.hypothesis_as(CampaignProblem)
    is_known = any(effect.needs_finite_elements for effect in (*effects.values(), *problem.given))
    if is_known or SampleShape.name not in places or not FiniteSize().applies(problem.campaign):
        return nominal, places
    rigs, start = free_rim(problem, minima)
    nominal = with_rigs(nominal, rigs)
    return nominal, with_free_rim(nominal, places, start)


def with_free_rim(nominal: Fitted, places: Mapping[str, PlaceFit], start: RealArray) -> dict[str, PlaceFit]:
    """Return the places, that of the sample's shape with a rim that is free in finite elements where that is better.

    Parameters
    ----------
    nominal : Fitted
        With the finite elements (`CampaignProblem.finite`).
    places : mapping
        As `fit_places` returns them.
    start : array, shape (n,)
        Coordinates of the nominal model that fit with a free rim roughly.
    """
    return _with_place(nominal, places, _at_rest(nominal, SampleShape(needs_finite_elements=True), start))


def search_open_rims(
    nominal: Fitted,
    minima: list[Minimum],
    effects: Mapping[str, BaseEffect],
    places: dict[str, PlaceFit],
    executor: Executor | None,
) -> dict[str, PlaceFit]:
    """Return the places, with open rims at the sample's faces unless a known effect has these."""
    problem, rims = nominal.hypothesis_as(CampaignProblem), Delamination()
    is_known = rims.name in [effect.name for effect in effects.values()] or has_open_rims(problem.given)
    if is_known or Faces.name not in places or not problem.admits(rims):
        return places
    others = {rims.name: other_starts(nominal, minima, places, rims)}
    ((key, task),) = begin_tasks(nominal, {rims.name: rims}, others=others).items()
    begun = finish_all({key: task()}, executor)[key]
    hypothesis, z = begun.hypothesis.bare(begun.minimum.z)
    z, worn = minimise_scaled(hypothesis, z, *COARSELY).z, WornRim()
    starts = [np.append(z, depth) for depth in sorted({start[-1] for start in worn.starts})]
    hypothesis = hypothesis.with_effects(worn)
    ends = run_all(call, [partial(minimise_scaled, hypothesis, start, *COARSELY) for start in starts], executor)
    return with_open_rims(nominal, places, best_of([Fitted(hypothesis, end) for end in ends]))


def with_open_rims(nominal: Fitted, places: Mapping[str, PlaceFit], rims: Fitted) -> dict[str, PlaceFit]:
    """Return the places, that of the sample's faces with open rims where that is better.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    rims : Fitted
        The nominal model with open rims, whose widths are taken from there.
    """
    (effect,), z, n = rims.hypothesis.effects, rims.minimum.z, len(nominal.minimum.z)
    sizes = Priors.of(effect.parameters).values(z[n:])
    named = {parameter.name: float(size) for parameter, size in zip(effect.parameters, sizes, strict=True)}
    place = OpenFaces(named["open_rim"], named["trend"], named["at_base"], named["depth"])
    return _with_place(nominal, places, _at_rest(nominal, place, z[:n]), _price(rims, len(z) - n))


def with_differing_laws(
    kind: type[DifferingLaw], nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places, with laws that differ from configuration to configuration where these are better.

    For data that nothing else fits: samples, their glue and what hangs on the rig differ after each mounting. What
    differs is fitted with the law, and fixed in the place; where that is so far out that its prior says otherwise
    (`FIT_P`), the law not that of a causal response, or not enough either, it is no explanation.

    Parameters
    ----------
    kind : type of DifferingLaw
        Whether sizes or frequencies differ.
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    if len(nominal.hypothesis.data) < 2:  # nothing tells a law that differs from another
        return dict(places)
    able = [fit for fit in places.values() if fit.place.can_move]
    wanted = [fit for fit in able if kind is MovingLaw or not fit.place.differs_already]
    tasks = [partial(_differing, kind, nominal, fit) for fit in wanted]
    begun = [found for found in run_all(call, tasks, executor) if found is not None]
    near = near_best([fit for fit, _ in begun])
    for fit, price in begun:
        if any(fit is other for other in near):
            places = _with_place(nominal, places, fit, price, must_explain=True)
    return dict(places)


def _with_resonance(nominal: Fitted, at: PlaceFit) -> PlaceFit:
    """Return a place with a law that resonates, where that has more evidence."""
    scale, frequency = scale_of(nominal, at.place)
    law = SimpleLaw.at(at.place, (Term("resonance"),), frequency, scale)
    found = best_of([descent() for descent in descents(nominal, at, law, nearest_form(at, law)[1])])
    likely = [descended(found.hypothesis, z, *FINE) for z in _likely_resonances(nominal, at, law)]
    fitted = best_variant(nominal, max([found, *likely], key=tolerant_evidence), *FINE)
    evidence, place = tolerant_evidence(fitted) - at.price, fitted.hypothesis.effects[-1].at_place
    return replace(at, place=place, simple=fitted, log_evidence=evidence) if evidence > at.log_evidence else at


def _likely_resonances(nominal: Fitted, at: PlaceFit, law: SimpleLaw) -> list[RealArray]:
    """Return coordinates with the resonances that fit the data best, all else as with the free law, and at rest.

    That law need not show them: sharp ones that move the data by more than themselves. Where it explains nothing, what
    is stated of the laboratory was bent to fit what it cannot.
    """
    hypothesis, likely = nominal.hypothesis.with_effects(law), list[RealArray]()
    fitted = at.fitted.minimum.z[: len(nominal.minimum.z)]
    for rest in (fitted, nominal.hypothesis.at_rest(nominal.minimum.z)):
        points = np.stack([np.concatenate([rest, resonance]) for resonance in RESONANCES])
        costs = costs_per_datum(hypothesis.residual, points)
        likely += [points[i] for i in np.argsort(costs)[:_LIKELY]]
    return likely


def _differing(kind: type[DifferingLaw], nominal: Fitted, fit: PlaceFit) -> tuple[Fitted, float] | None:
    """Return a place with a free law as it differs by the data, not finished, and what that costs, nats.

    None where it differs by more than its prior allows.
    """
    # of a place whose law differs in another way already, that is given up: it would not be paid for
    place, law = fit.place.differing() if fit.place.tells_more else fit.place, fit.drawn
    names = [data.name for data in nominal.hypothesis.data]
    if kind is MovingLaw:
        # `with_resonances` has such a fit already, but where a resonance acts in another way than the law
        is_short = law.length == SHORT and law.at_place is place
        begun = fit.fitted if is_short else begun_at(nominal, place, SHORT)
        starts = [np.concatenate([begun.minimum.z, trend * np.linspace(-1, 1, len(names))]) for trend in _TRENDS]
    else:
        begun = begun_at(nominal, place)
        function: DrawnLaw = begun.hypothesis.effects[-1]
        # a law that other unknowns take up is 0: it must be there to differ
        more = [np.concatenate([np.zeros(len(nominal.minimum.z)), function.constant(size)]) for size in _CONSTANTS]
        starts = [np.concatenate([begun.minimum.z + there, np.zeros(len(names))]) for there in more]
    differing = kind.of(begun.hypothesis.effects[-1], dict(zip(names, names, strict=True)))
    hypothesis = nominal.hypothesis.with_effects(differing)
    fitted = max((descended(hypothesis, z, *COARSE) for z in starts), key=tolerant_evidence)
    if kind is VaryingLaw:
        fitted = max([fitted, *_by_piece(nominal, begun.hypothesis.effects[-1], fitted)], key=tolerant_evidence)
    differing = fitted.hypothesis.effects[-1]
    z, unknowns = np.split(fitted.minimum.z, [len(begun.minimum.z)])
    if exceeding(float(unknowns @ unknowns), len(unknowns)) < FIT_P:
        return None
    fixed = replace(begun.hypothesis.effects[-1], at_place=differing.place_at(fitted.minimum.z))
    hypothesis = nominal.hypothesis.with_effects(fixed)
    return Fitted(hypothesis, hypothesis.as_minimum(z)), _price(fitted, len(unknowns))


def _by_piece(nominal: Fitted, plain: DrawnLaw, fitted: Fitted) -> list[Fitted]:
    """Return fits of a law that differs from sample to sample, or from plate to plate, near one that differs freely."""
    law, found = fitted.hypothesis.effects[-1], []
    factors = law.place_at(fitted.minimum.z).factors
    for by, pieces in nominal.hypothesis.pieces.items():
        shared = {name: pieces[name] for name in factors}
        if 1 < len(set(shared.values())) < len(factors):
            differing = VaryingLaw.of(plain, shared, by)
            z = np.append(fitted.minimum.z[: -len(law.names)], differing.coordinates(factors))
            found.append(descended(nominal.hypothesis.with_effects(differing), z, *COARSE))
    return found


def _price(fitted: Fitted, count: int) -> float:
    """Return what a fit of its last unknowns costs, nats, by Laplace's approximation: a place has them fixed."""
    z, precision = fitted.minimum.z[-count:], fitted.minimum.precision
    volume = np.linalg.slogdet(precision)[1] - np.linalg.slogdet(precision[:-count, :-count])[1]
    return 0.5 * float(z @ z + volume)


def _at_rest(nominal: Fitted, place: BasePlace, start: RealArray) -> Fitted:
    """Return a place with a free law of the larger size that is 0, from coordinates of the nominal model."""
    scale, frequency = scale_of(nominal, place)
    law = DrawnLaw.at(place, frequency, LAW_SIZES[-1] * scale)
    hypothesis = nominal.hypothesis.with_effects(law)
    return Fitted(hypothesis, hypothesis.as_minimum(np.concatenate([start, np.zeros(len(law.parameters))])))


def _with_place(
    nominal: Fitted, places: Mapping[str, PlaceFit], begun: Fitted, price: float = 0.0, *, must_explain: bool = False
) -> dict[str, PlaceFit]:
    """Return the places, that of a label in another way where that has more evidence.

    `begun` is where the search begins, `price` what the place's fields cost of evidence, nats; `must_explain`,
    whether the law must be that of a causal response and explain the data.
    """
    other = finished(nominal, begun)
    other = replace(other, log_evidence=other.log_evidence - price, price=price)
    label = other.place.label
    is_better = other.log_evidence > places[label].log_evidence
    if must_explain:
        is_better = is_better and is_enough(nominal, other.explanation) and is_causal(other) is not False
    better = {label: other} if is_better else {}
    return ranked({**places, **better}.values())
