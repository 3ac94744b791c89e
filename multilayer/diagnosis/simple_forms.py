"""Simple forms of the law that is drawn at a place: sums of few terms, as a mass, a delay, a resonance."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted, begin, best_of, minimise_scaled
from multilayer.diagnosis.place_fits import COARSE, FINE, PlaceFit, SimpleForm, descended, ranked, scale_of
from multilayer.diagnosis.places import BasePlace
from multilayer.diagnosis.thresholds import FORM_AS_WELL, NEAR, SECOND_TERM
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.places import SimpleLaw, Term
from multilayer.inference.priors import Priors

_TOLD = (200, 1e-9)  # evaluations and relative change of the cost of the descent whose end is told
_STARTS = 8  # of a form that is compared with the drawn law
# of a resonance in that law: amplitude, frequency and loss factor, of which the nearest are followed
RESONANCES = tuple(product((-0.5, -0.1, -0.02, 0.02, 0.1, 0.5), np.linspace(-2, 2, 17), (-1.0, 0.0, 1.0)))
_PROMISING = 3  # forms that are fitted to the data, of those near the drawn law
_TERMS = (
    Term("power", 0), Term("power", 1), Term("power", -1), Term("power", 2), Term("power", -2),
    Term("lossy"), Term("fractional"), Term("relaxation"), Term("resonance"),
)  # fmt: skip
_REAL_TERMS = (*_TERMS[:5], Term("fractional"))  # powers of f, where the law is real


def with_simple_laws(
    nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places, with a simple law where that is as probable as the free one.

    For few measurements: a free law explains a single one at any place that changes all of its values. That a law of
    few parameters does so at some of these places is what tells them from the others. A free law's evidence is mostly
    the price of its nodes, so places are left out by its misfit alone, which no simple law there is below.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    best = max((fit.log_evidence for fit in places.values()), default=0.0)

    def simplified(fit: PlaceFit) -> PlaceFit:
        if best + 0.5 * fit.explanation.minimum.cost >= NEAR:
            return fit
        term = simple_term(nominal, fit, executor, most=len(_TERMS))
        is_enough = term.log_evidence > fit.log_evidence - FORM_AS_WELL
        evidence = max(term.log_evidence, fit.log_evidence)
        return replace(fit, log_evidence=evidence, simple=term.fitted if is_enough else None, term=term)

    return ranked(map(simplified, places.values()))


def _terms_at(place: BasePlace) -> tuple[Term, ...]:
    return _REAL_TERMS if place.is_real else _TERMS


def simple_term(nominal: Fitted, at: PlaceFit, executor: Executor | None = None, most: int = _PROMISING) -> SimpleForm:
    """Return the simple term at a place that has the most evidence.

    Parameters
    ----------
    nominal : Fitted
    at : PlaceFit
        The place with a free law.
    executor : Executor, optional
    most : int
        How many terms, of those near the free law, are fitted to the data; a resonance besides.
    """
    single = _fit_forms(nominal, at, [(term,) for term in _terms_at(at.place)], executor, most)
    return max(single, key=lambda form: form.log_evidence)


def simple_form(
    nominal: Fitted, at: PlaceFit, executor: Executor | None = None, term: SimpleForm | None = None
) -> SimpleForm:
    """Return the sum of at most two simple terms at a place that has the most evidence.

    Parameters
    ----------
    nominal : Fitted
    at : PlaceFit
        The place with a free law.
    executor : Executor, optional
    term : SimpleForm, optional
        As `simple_term` returns it, where it is known already.
    """
    best = simple_term(nominal, at, executor) if term is None else term
    others = [t for t in _terms_at(at.place) if t not in best.form.terms and t.kind in ("power", "resonance")]
    double = _fit_forms(nominal, at, [(*best.form.terms, other) for other in others], executor)
    second = max(double, key=lambda form: form.log_evidence)
    chosen = second if second.log_evidence > best.log_evidence + SECOND_TERM else best
    minimum = minimise_scaled(chosen.fitted.hypothesis, chosen.fitted.minimum.z, *_TOLD)
    fitted = Fitted(chosen.fitted.hypothesis, minimum)
    return SimpleForm(at.place, fitted, tolerant_evidence(fitted) - at.price)


def _fit_forms(
    nominal: Fitted, at: PlaceFit, sums: Sequence[tuple[Term, ...]], executor: Executor | None, most: int = _PROMISING
) -> list[SimpleForm]:
    """Return fits of the sums nearest to the drawn law, and of those with a resonance, which none may show."""
    scale, frequency = scale_of(nominal, at.place)
    laws = [SimpleLaw.at(at.place, terms, frequency, scale) for terms in sums]
    distances = [nearest_form(at, law) for law in laws]
    order = sorted(range(len(laws)), key=lambda i: distances[i][0])
    sharp = [i for i, law in enumerate(laws) if law.is_resonant]
    chosen = dict.fromkeys([*sharp, *order[:most]])  # what takes longest first
    tasks = [(i, task) for i in chosen for task in descents(nominal, at, laws[i], distances[i][1])]
    ends = run_all(call, [task for _, task in tasks], executor)
    fits = [best_of([end for (j, _), end in zip(tasks, ends, strict=True) if i == j]) for i in chosen]
    return [SimpleForm(at.place, fitted, tolerant_evidence(fitted) - at.price) for fitted in fits]


def nearest_form(at: PlaceFit, law: SimpleLaw) -> tuple[float, RealArray]:
    """Return how far a simple law is from the drawn one, and its coordinates there.

    The distance is that of the nodes by the posterior's covariance, squared, with the priors of the simple law.
    """
    drawn, count = at.drawn, len(at.drawn.parameters)
    nodes = at.fitted.minimum.z[-count:]
    # of the nodes' precision, all else integrated out: the nodes stand last, and nothing is inverted
    jacobian = at.fitted.minimum.jacobian
    _, whole = np.linalg.qr(np.concatenate([jacobian, np.eye(jacobian.shape[1])]))
    root = whole[-count:, -count:]
    frequency, priors = np.exp(drawn.nodes), Priors.of(law.parameters)
    basis = drawn.size * drawn.basis(frequency)

    def residual(z: RealArray) -> RealArray:
        values = law.law_at(frequency, list(priors.values(z)[:, None]))
        parts = [values.real] if at.place.is_real else [values.real, values.imag]
        ahead = np.linalg.solve(basis, np.stack(parts, axis=-1))
        return np.concatenate([root @ (ahead.T.ravel() - nodes), z])

    starts = [np.array(start) for start in law.starts[:_STARTS]]
    if law.is_resonant:
        before = starts[0][: -law.terms[-1].count]
        grid = [np.array([*before, *resonance]) for resonance in RESONANCES]
        starts = sorted(grid, key=lambda z: float(np.sum(residual(z) ** 2)))[:_STARTS]
    ends = [least_squares(residual, start, max_nfev=COARSE[0]) for start in starts]
    best = min(ends, key=lambda end: end.cost)
    return float(best.cost), best.x


def descents(nominal: Fitted, at: PlaceFit, law: SimpleLaw, near: RealArray) -> list[Callable[[], Fitted]]:
    """Return the tasks of which the best result is the fit of a simple law: from near its solution, `near`.

    Of a resonance also from everywhere: a smooth drawn law need not show it.
    """
    hypothesis, start = nominal.hypothesis.with_effects(law), at.fitted.minimum.z[: len(nominal.minimum.z)]
    starts = [np.concatenate([start, near])]
    if at.simple is not None and at.simple.hypothesis.effects[-1].terms == law.terms:
        starts.append(at.simple.minimum.z)
    tasks: list[Callable[[], Fitted]] = [partial(descended, hypothesis, z, *FINE) for z in starts]
    return [partial(_from_everywhere, hypothesis, start, nominal.minimum.z), *tasks] if law.is_resonant else tasks


def _from_everywhere(hypothesis: Hypothesis, start: RealArray, other: RealArray) -> Fitted:
    starts = begin(hypothesis, start, others=other[None]).starts
    return best_of([descended(hypothesis, z, *FINE) for z in starts])
