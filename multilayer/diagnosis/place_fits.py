"""Where something unknown acts: the evidence of every place with a free law, and simple forms of that law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import product

import numpy as np
from scipy.optimize import least_squares
from scipy.special import logsumexp

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted, begin, best_of, minimise_scaled
from multilayer.diagnosis.places import BasePlace, places_of
from multilayer.diagnosis.places.beside import OpenFaces
from multilayer.diagnosis.places.sample import SampleShape
from multilayer.diagnosis.thresholds import (
    DRAWN_ERROR,
    FIT_P,
    FORM_AS_WELL,
    LAW_LENGTH,
    LAW_SIZES,
    LEAST_SCORE,
    NEAR,
    ROUGH,
    SECOND_TERM,
    TOLD_SIZE,
    UNEXPLAINED,
)
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.places import SHORT, DrawnLaw, MovingLaw, SimpleLaw, Term
from multilayer.inference.derivative import central
from multilayer.inference.multistart import costs_per_datum
from multilayer.inference.priors import Priors
from multilayer.inference.problem import Minimum, Scaled

# evaluations and relative change of the cost: of descents on the way, of those that are compared, of what is told
_COARSE, _FINE, _TOLD = (30, 1e-3), (60, 1e-6), (200, 1e-9)
_TRENDS = (-1.0, 0.0, 1.0)  # of shifts of a law that moves, standard deviations in the last configuration at the start
_SHARP = 3  # places that are followed, and tried with a resonance, where no smooth law explains the data
_TOLD_AT, _AROUND = 61, 5.0  # frequencies at which a law is told; about a resonance as far as so many loss factors
_STARTS = 8  # of a simple form that is compared with the drawn law
# of a resonance in that law: amplitude, frequency and loss factor, of which the nearest are followed
_RESONANCES = tuple(product((-0.5, -0.1, -0.02, 0.02, 0.1, 0.5), np.linspace(-2, 2, 17), (-1.0, 0.0, 1.0)))
_CONSTANTS = tuple(complex(size, loss) for size in np.linspace(-3, 3, 25) for loss in (-0.5, 0.0, 0.5))
_LIKELY = 3  # resonances that are followed, of those of the grid
_TINY = 1e-3  # of a law's largest value, where that is taken for its size
_PROMISING = 3  # simple forms that are fitted to the data, of those near the drawn law
_TERMS = (
    Term("power", 0), Term("power", 1), Term("power", -1), Term("power", 2), Term("power", -2),
    Term("lossy"), Term("fractional"), Term("relaxation"), Term("resonance"),
)  # fmt: skip
_REAL_TERMS = (*_TERMS[:5], Term("fractional"))  # powers of f, where the law is real


@dataclass(frozen=True)
class PlaceFit:
    """A place with a free law.

    Attributes
    ----------
    place : BasePlace
    fitted : Fitted
        With the law's size of the most evidence, or as it is told (`as_told`).
    log_evidence : float
        Averaged over sizes, with a discrepancy as large as the differences of solvers; of the simple law where there
        is one.
    simple : Fitted, optional
        With a law of one term, where that is as probable as the free one.
    term : SimpleForm, optional
        The simple term of the most evidence, where all were tried.
    """

    place: BasePlace
    fitted: Fitted
    log_evidence: float
    simple: Fitted | None = None
    term: SimpleForm | None = None

    @property
    def explanation(self) -> Fitted:
        """The fit with the most evidence."""
        return self.fitted if self.simple is None else self.simple

    @property
    def drawn(self) -> DrawnLaw:
        """The law."""
        law: DrawnLaw = self.fitted.hypothesis.effects[-1]
        return law

    @cached_property
    def grid(self) -> RealArray:
        """Frequencies at which the law is told, Hz, shape (n,): closer about a resonance."""
        grid = np.exp(np.linspace(self.drawn.nodes[0], self.drawn.nodes[-1], _TOLD_AT))
        if self._simple is None or not self.is_resonant:
            return grid
        law, z, _ = self._simple
        natural, loss = _peak(law, z)
        near = natural * (1 + _AROUND * loss * np.linspace(-1, 1, _TOLD_AT))
        return np.unique(np.concatenate([grid, near[(near > grid[0]) & (near < grid[-1])]]))

    @property
    def is_resonant(self) -> bool:
        """Whether the law is a resonance."""
        return self.simple is not None and self.simple.hypothesis.effects[-1].is_resonant

    @property
    def _simple(self) -> tuple[SimpleLaw, RealArray, RealArray] | None:
        """The simple law, with its coordinates and their covariance."""
        if self.simple is None:
            return None
        law: SimpleLaw = self.simple.hypothesis.effects[-1]
        count = len(law.parameters)
        return law, self.simple.minimum.z[-count:], self.simple.minimum.covariance[-count:, -count:]

    def law(self) -> ComplexArray:
        """Return the most probable law at `grid`, in the place's unit, shape (n,)."""
        if self._simple is not None:
            law, z, _ = self._simple
            return law.curve(z, self.grid)
        return self.drawn.drawn(self.fitted.minimum.z[-len(self.drawn.parameters) :], self.grid)

    def departs_from(self) -> ComplexArray | None:
        """Return what the law changes, at `grid`, shape (n,); None where the law is all there is."""
        fit = self.explanation
        settings = fit.hypothesis.settings_at(fit.minimum.z)
        found = (self.place.departs_from(setting, self.grid) for setting in settings)
        return next((values for values in found if values is not None), None)

    def band(self, deviations: float = 1.645) -> tuple[ComplexArray, ComplexArray]:
        """Return ends of the central 90 % intervals of real and imaginary part, shape (n,) each.

        By Laplace's approximation, and by the error of the place's mechanics: a share of the law (`DRAWN_ERROR`).
        """
        law = self.law()
        if self._simple is not None:
            simple, z, covariance = self._simple
            slopes = central(lambda points: simple.curve(points, self.grid), z)[1]
            parts = [np.einsum("ni,ij,nj->n", slope, covariance, slope) for slope in (slopes.real, slopes.imag)]
        else:
            k, count = len(self.drawn.nodes), len(self.drawn.parameters)
            covariance = self.fitted.minimum.covariance[-count:, -count:]
            basis = self.drawn.size * self.drawn.basis(self.grid)
            blocks = [covariance[first : first + k, first : first + k] for first in range(0, count, k)]
            parts = [np.einsum("ni,ij,nj->n", basis, part, basis) for part in blocks]
        spread = [deviations * np.sqrt(part + (DRAWN_ERROR * np.abs(law)) ** 2) for part in parts]
        reach = spread[0] if self.place.is_real else spread[0] + 1j * spread[1]
        return law - reach, law + reach


def _peak(law: SimpleLaw, z: RealArray) -> tuple[float, float]:
    """Return natural frequency, Hz, and loss factor of a law's resonance."""
    values = {p.name.partition(".")[2]: float(p.prior.value(x)) for p, x in zip(law.parameters, z, strict=True)}
    return values["frequency"], values["loss_factor"]


@dataclass(frozen=True)
class SimpleForm:
    """A place with a law of few parameters.

    Attributes
    ----------
    place : BasePlace
    fitted : Fitted
    log_evidence : float
    """

    place: BasePlace
    fitted: Fitted
    log_evidence: float

    @property
    def form(self) -> SimpleLaw:
        """The law."""
        law: SimpleLaw = self.fitted.hypothesis.effects[-1]
        return law

    def covariance(self, frequency: RealArray) -> RealArray:
        """Return the covariance of the law's coordinates, shape (k, k), with the error of the place's mechanics.

        To Laplace's approximation is added what smooth relative errors of the law (`DRAWN_ERROR`, `LAW_LENGTH`) do to
        the coordinates nearest to it (least squares, and the priors) at frequencies, Hz: a sharp resonance is known to
        as small a share of its width.
        """
        law, count = self.form, len(self.form.parameters)
        minimum, is_real = self.fitted.minimum, law.at_place.is_real
        curve, slopes = central(lambda points: law.curve(points, frequency), minimum.z[-count:])
        size = np.maximum(np.abs(curve), _TINY * np.max(np.abs(curve)) + np.finfo(float).tiny)[:, None]
        basis = DrawnLaw.at(law.at_place, frequency, 1.0, LAW_LENGTH).basis(frequency)
        errors = basis if is_real else np.concatenate([basis, 1j * basis], axis=1)

        def rows(columns: ComplexArray) -> RealArray:
            return columns.real if is_real else np.concatenate([columns.real, columns.imag])

        by_law = rows(slopes / size)
        weight = basis.shape[1] / (len(frequency) * DRAWN_ERROR**2)  # so many values are independent
        shifts = np.linalg.solve(
            weight * by_law.T @ by_law + np.eye(count),
            weight * by_law.T @ (DRAWN_ERROR * rows(errors * (curve[:, None] / size))),
        )
        return np.asarray(minimum.covariance[-count:, -count:] + shifts @ shifts.T)


def fit_places(
    nominal: Fitted, executor: Executor | None = None, names: Sequence[str] | None = None
) -> dict[str, PlaceFit]:
    """Return every place with a free law, by its label, the one with the most evidence first.

    Of the configurations that might depart by themselves only that is fitted which explains most to first order.

    Parameters
    ----------
    nominal : Fitted
        The nominal model of a campaign.
    executor : Executor, optional
        Where fits run; in this process when left out.
    names : sequence of str, optional
        Names of the places; all that are registered when left out.
    """
    problem = nominal.hypothesis
    places: list[tuple[BasePlace, Fitted]] = []
    for name, kind in places_of(problem.kind).items():
        if names is not None and name not in names:
            continue
        steps = [(place, _first_step(nominal, place)) for place in kind.instances(problem.settings)]
        places += [max(steps, key=lambda step: step[1].log_evidence)] if steps else []
    # what gains nothing to first order is at its minimum after that step
    idle = [_unfinished(step) for _, step in places if not _gains(nominal, step)]
    tasks = [partial(_begun, nominal, place) for place, step in places if _gains(nominal, step)]
    begun = run_all(call, tasks, executor)
    begun.sort(key=lambda fit: -tolerant_evidence(fit))
    most = len(begun) if is_explained(begun) else _SHARP  # where no law explains anything, orders mean little
    near = _near(begun[:most])
    fits = run_all(call, [partial(_finished, nominal, fit) for fit in near], executor)
    fits += [_unfinished(fit) for fit in begun if not any(fit is other for other in near)]
    return _ranked([*fits, *idle])


def with_resonances(
    nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places with laws that vary faster, and the first few with a resonance, where that has more evidence.

    For data that neither a known effect nor a smooth law fits: ten nodes cannot hold a sharp resonance.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    smooth = list(places.values())
    tasks = [partial(_begun, nominal, fit.place, SHORT) for fit in smooth if not fit.place.needs_finite_elements]
    rough = {fit.place.label: fit for fit in map(_unfinished, run_all(call, tasks, executor))}
    pairs = [(fit, rough.get(fit.place.label, fit)) for fit in smooth]
    fits = [*_ranked(max(pair, key=lambda fit: fit.log_evidence) for pair in pairs).values()]
    sharp = run_all(call, [partial(_with_resonance, nominal, fit) for fit in fits[:_SHARP]], executor)
    return _ranked([*sharp, *fits[_SHARP:]])


def with_simple_laws(
    nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places, those near the first with a simple law where that is as probable as the free one.

    For few measurements: a free law explains a single one at any place that changes all of its values. That a law of
    few parameters does so at some of these places is what tells them from the others.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    best = max((fit.log_evidence for fit in places.values()), default=0.0)

    def simplified(fit: PlaceFit) -> PlaceFit:
        if best - fit.log_evidence >= NEAR:
            return fit
        term = simple_term(nominal, fit, executor, most=len(_TERMS))
        is_enough = term.log_evidence > fit.log_evidence - FORM_AS_WELL
        evidence = max(term.log_evidence, fit.log_evidence)
        return replace(fit, log_evidence=evidence, simple=term.fitted if is_enough else None, term=term)

    return _ranked(map(simplified, places.values()))


def as_told(nominal: Fitted, fit: PlaceFit) -> PlaceFit:
    """Return a place with its free law as it is told: with a standard deviation of at least `TOLD_SIZE`.

    The size of the most evidence is the smallest that the data bear, and pulls a law that the unknowns can take up in
    part, as a compliance beside the modulus, towards 0. The evidence stays that of the place as it was compared.
    """
    size = TOLD_SIZE * _scale(nominal, fit.place)[0]
    if fit.simple is not None or np.all(fit.drawn.size >= size):
        return fit
    return replace(fit, fitted=_descended(*_resized(fit.fitted, size), *_FINE))


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


def with_moving_laws(
    nominal: Fitted, places: Mapping[str, PlaceFit], executor: Executor | None = None
) -> dict[str, PlaceFit]:
    """Return the places, with laws whose frequencies move from configuration to configuration where these are better.

    For data that nothing else fits: what hangs on the rig resonates elsewhere after each mounting. The shifts are
    fitted with the law, and fixed in the place; those so far from 0 that their prior says they are not (`FIT_P`) are no
    explanation.

    Parameters
    ----------
    nominal : Fitted
    places : mapping
        As `fit_places` returns them.
    executor : Executor, optional
    """
    if len(nominal.hypothesis.data) < 2:  # nothing tells a law that moves from another
        return dict(places)
    tasks = [partial(_moving, nominal, fit.place) for fit in places.values() if fit.place.can_move]
    begun = [found for found in run_all(call, tasks, executor) if found is not None]
    near = _near([fit for fit, _ in begun])
    for fit, price in begun:
        if any(fit is other for other in near):
            places = _with_place(nominal, places, fit, price)
    return dict(places)


def _moving(nominal: Fitted, place: BasePlace) -> tuple[Fitted, float] | None:
    """Return a place with a free law moved as the data have it, not finished, and what the shifts cost, nats.

    None where the shifts are too far from 0.
    """
    begun = _begun(nominal, place, SHORT)
    names = [data.name for data in nominal.hypothesis.data]
    law = MovingLaw.of(begun.hypothesis.effects[-1], names)
    hypothesis = nominal.hypothesis.with_effects(law)
    starts = [np.concatenate([begun.minimum.z, trend * np.linspace(-1, 1, len(names))]) for trend in _TRENDS]
    fitted = max((_descended(hypothesis, z, *_COARSE) for z in starts), key=tolerant_evidence)
    z, shifts = np.split(fitted.minimum.z, [len(begun.minimum.z)])
    if exceeding(float(shifts @ shifts), len(shifts)) < FIT_P:
        return None
    fixed = replace(begun.hypothesis.effects[-1], at_place=place.moving(law.moved(fitted.minimum.z)))
    hypothesis = nominal.hypothesis.with_effects(fixed)
    return Fitted(hypothesis, hypothesis.as_minimum(z)), _price(fitted, len(names))


def _price(fitted: Fitted, count: int) -> float:
    """Return what a fit of its last unknowns costs, nats, by Laplace's approximation: a place has them fixed."""
    z, precision = fitted.minimum.z[-count:], fitted.minimum.precision
    volume = np.linalg.slogdet(precision)[1] - np.linalg.slogdet(precision[:-count, :-count])[1]
    return 0.5 * float(z @ z + volume)


def _at_rest(nominal: Fitted, place: BasePlace, start: RealArray) -> Fitted:
    """Return a place with a free law of the larger size that is 0, from coordinates of the nominal model."""
    scale, frequency = _scale(nominal, place)
    law = DrawnLaw.at(place, frequency, LAW_SIZES[-1] * scale)
    hypothesis = nominal.hypothesis.with_effects(law)
    return Fitted(hypothesis, hypothesis.as_minimum(np.concatenate([start, np.zeros(len(law.parameters))])))


def _with_place(
    nominal: Fitted, places: Mapping[str, PlaceFit], begun: Fitted, price: float = 0.0
) -> dict[str, PlaceFit]:
    """Return the places, that of a label in another way where that has more evidence.

    `begun` is where the search begins, `price` what the place's fields cost of evidence, nats.
    """
    other = _finished(nominal, begun)
    other = replace(other, log_evidence=other.log_evidence - price)
    label = other.place.label
    better = {label: other} if other.log_evidence > places[label].log_evidence else {}
    return _ranked({**places, **better}.values())


def _ranked(fits: Iterable[PlaceFit]) -> dict[str, PlaceFit]:
    """Return places by label, the one with the most evidence first."""
    return {fit.place.label: fit for fit in sorted(fits, key=lambda fit: -fit.log_evidence)}


def is_explained(fits: Iterable[Fitted]) -> bool:
    """Tell whether some fit explains the data at all."""
    return any(fit.minimum.cost_per_datum <= UNEXPLAINED for fit in fits)


def may_explain(nominal: Fitted, places: Mapping[str, PlaceFit], effect: BaseEffect) -> bool:
    """Tell whether an effect may be near the best explanation: a named law gains at most what a free one does there.

    Of an effect that acts in more ways than through its place, and without places, that is always so.
    """
    at = places.get(str(getattr(effect, "place", "")))
    if at is None or not getattr(effect, "acts_through_place", False):
        return True
    cost = at.explanation.minimum.cost
    gain = 0.5 * (nominal.minimum.cost - cost)
    best = max(nominal.log_evidence, *(fit.log_evidence for fit in places.values()))
    return gain > LEAST_SCORE and nominal.log_evidence + gain > best - NEAR - ROUGH * cost


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
    return SimpleForm(at.place, fitted, tolerant_evidence(fitted))


def _scale(nominal: Fitted, place: BasePlace) -> tuple[float, RealArray]:
    """Return the place's scale, and the frequencies of all data, Hz."""
    problem = nominal.hypothesis
    frequency = np.concatenate([data.frequency for data in problem.data])
    centre = float(np.sqrt(frequency.min() * frequency.max()))
    return place.scale(problem.settings, problem.modulus_scale(nominal.minimum.z, centre)), frequency


def _first_step(nominal: Fitted, place: BasePlace) -> Fitted:
    """Return a place with a free law of the larger size, one Gauss-Newton step from the nominal model."""
    scale, frequency = _scale(nominal, place)
    law = DrawnLaw.at(place, frequency, LAW_SIZES[-1] * scale, place.length)
    hypothesis = nominal.hypothesis.with_effects(law)
    z = np.concatenate([nominal.minimum.z, np.zeros(len(law.parameters))])
    residual, jacobian = hypothesis.linearised(z)
    step = -np.linalg.solve(jacobian.T @ jacobian + np.eye(z.size), jacobian.T @ residual + z)
    ahead = residual + jacobian @ step
    return Fitted(hypothesis, Minimum(z + step, ahead, jacobian))


def _gains(nominal: Fitted, step: Fitted) -> bool:
    """Tell whether a law lowers the cost by more than chance, to first order."""
    return 0.5 * (nominal.minimum.cost - step.minimum.cost) > LEAST_SCORE


def _begun(nominal: Fitted, place: BasePlace, length: float | None = None) -> Fitted:
    """Return a coarse fit of a place with a free law of the larger size."""
    scale, frequency = _scale(nominal, place)
    law = DrawnLaw.at(place, frequency, LAW_SIZES[-1] * scale, length or place.length)
    hypothesis, at_rest = nominal.hypothesis.with_effects(law), nominal.hypothesis.at_rest(nominal.minimum.z)
    constants = [law.constant(value) for value in (_CONSTANTS if place.detunes else (0j,))]
    starts = np.stack([np.concatenate([at_rest, constant]) for constant in constants])
    return _descended(hypothesis, starts[np.argmin(costs_per_datum(hypothesis.residual, starts))], *_COARSE)


def _near(begun: Sequence[Fitted]) -> list[Fitted]:
    """Return the coarse fits that may turn out to be the best."""
    best = max((tolerant_evidence(fit) for fit in begun), default=0.0)
    return [fit for fit in begun if tolerant_evidence(fit) > best - NEAR - ROUGH * fit.minimum.cost]


def _unfinished(begun: Fitted) -> PlaceFit:
    return PlaceFit(begun.hypothesis.effects[-1].at_place, begun, tolerant_evidence(begun))


def _finished(nominal: Fitted, begun: Fitted) -> PlaceFit:
    """Return the fit of a place, from a coarse one and from the nominal model, with each size of its law."""
    begun = _best_variant(nominal, begun, *_COARSE)
    law: DrawnLaw = begun.hypothesis.effects[-1]
    at_rest = np.concatenate([nominal.hypothesis.at_rest(nominal.minimum.z), np.zeros(len(law.parameters))])
    fits = [_descended(begun.hypothesis, begun.minimum.z, *_FINE)]
    for size in LAW_SIZES[:-1]:
        hypothesis, z = _resized(fits[0], law.size * size / LAW_SIZES[-1])
        fits.append(best_of([_descended(hypothesis, start, *_FINE) for start in (z, at_rest)]))
    evidences = [tolerant_evidence(fit) for fit in fits]
    best = fits[int(np.argmax(evidences))]
    return PlaceFit(law.at_place, best, float(logsumexp(evidences) - np.log(len(evidences))))


def _resized(fitted: Fitted, size: float | RealArray) -> tuple[Hypothesis, RealArray]:
    """Return the hypothesis with a drawn law of another size, and coordinates at which the law is the same."""
    law, z = fitted.hypothesis.effects[-1], fitted.minimum.z.copy()
    z[-len(law.parameters) :] *= law.size / size
    return fitted.hypothesis.with_effects(replace(law, size=size)), z


def _best_variant(nominal: Fitted, fitted: Fitted, most: int, tolerance: float) -> Fitted:
    """Return the fit of a law at a place in the way of acting there that has the most evidence, each from that fit.

    Of large laws the first step from the nominal model, by which a variant is chosen, does not tell.
    """
    law, z = fitted.hypothesis.effects[-1], fitted.minimum.z
    others = [kind for kind in type(law.at_place).variants() if kind is not type(law.at_place)]
    places = [kind().moving(law.at_place.moved) if law.at_place.moved else kind() for kind in others]
    hypotheses = [nominal.hypothesis.with_effects(replace(law, at_place=place)) for place in places]
    fits = [fitted, *(_descended(hypothesis, z, most, tolerance) for hypothesis in hypotheses)]
    return max(fits, key=tolerant_evidence)


def _descended(hypothesis: Hypothesis, z: RealArray, most: int, tolerance: float) -> Fitted:
    """Return the minimum reached by continuation: with all errors of the data enlarged at first.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (n,)
        Where it starts.
    most, tolerance
        Evaluations of the last descent, and relative change of the cost at which it has converged.
    """
    residual = hypothesis.residual(z)
    first = max(float(np.sqrt(residual @ residual / residual.size)), 1.0)
    for scale in (first, np.sqrt(first)):
        if scale > 1:
            z = minimise_scaled(Scaled(hypothesis, scale), z, *_COARSE).z
    return Fitted(hypothesis, minimise_scaled(hypothesis, z, most, tolerance))


def _with_resonance(nominal: Fitted, at: PlaceFit) -> PlaceFit:
    """Return a place with a law that resonates, where that has more evidence."""
    scale, frequency = _scale(nominal, at.place)
    law = SimpleLaw.at(at.place, (Term("resonance"),), frequency, scale)
    form = _fit_form(nominal, at, law, _nearest(at, law)[1])
    likely = [_descended(form.fitted.hypothesis, z, *_FINE) for z in _likely_resonances(nominal, at, law)]
    fitted = _best_variant(nominal, max([form.fitted, *likely], key=tolerant_evidence), *_FINE)
    evidence, place = tolerant_evidence(fitted), fitted.hypothesis.effects[-1].at_place
    return replace(at, place=place, simple=fitted, log_evidence=evidence) if evidence > at.log_evidence else at


def _likely_resonances(nominal: Fitted, at: PlaceFit, law: SimpleLaw) -> list[RealArray]:
    """Return coordinates with the resonances that fit the data best, all else as with the free law.

    That law need not show them: sharp ones that move the data by more than themselves.
    """
    hypothesis = nominal.hypothesis.with_effects(law)
    rest = at.fitted.minimum.z[: len(nominal.minimum.z)]
    points = np.stack([np.concatenate([rest, resonance]) for resonance in _RESONANCES])
    costs = costs_per_datum(hypothesis.residual, points)
    return [points[i] for i in np.argsort(costs)[:_LIKELY]]


def _fit_forms(
    nominal: Fitted, at: PlaceFit, sums: Sequence[tuple[Term, ...]], executor: Executor | None, most: int = _PROMISING
) -> list[SimpleForm]:
    """Return fits of the sums nearest to the drawn law, and of those with a resonance, which none may show."""
    scale, frequency = _scale(nominal, at.place)
    laws = [SimpleLaw.at(at.place, terms, frequency, scale) for terms in sums]
    distances = [_nearest(at, law) for law in laws]
    order = sorted(range(len(laws)), key=lambda i: distances[i][0])
    sharp = [i for i, law in enumerate(laws) if law.is_resonant]
    chosen = dict.fromkeys([*sharp, *order[:most]])  # what takes longest first
    tasks = [partial(_fit_form, nominal, at, laws[i], distances[i][1]) for i in chosen]
    return run_all(call, tasks, executor)


def _nearest(at: PlaceFit, law: SimpleLaw) -> tuple[float, RealArray]:
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
        grid = [np.array([*before, *resonance]) for resonance in _RESONANCES]
        starts = sorted(grid, key=lambda z: float(np.sum(residual(z) ** 2)))[:_STARTS]
    ends = [least_squares(residual, start, max_nfev=_COARSE[0]) for start in starts]
    best = min(ends, key=lambda end: end.cost)
    return float(best.cost), best.x


def _fit_form(nominal: Fitted, at: PlaceFit, law: SimpleLaw, near: RealArray) -> SimpleForm:
    """Return the fit of a simple law from coordinates near its solution; of a resonance also from everywhere.

    A smooth drawn law need not show it.
    """
    hypothesis, start = nominal.hypothesis.with_effects(law), at.fitted.minimum.z[: len(nominal.minimum.z)]
    starts = np.concatenate([start, near])[None]
    if at.simple is not None and at.simple.hypothesis.effects[-1].terms == law.terms:
        starts = np.concatenate([starts, at.simple.minimum.z[None]])
    if law.is_resonant:
        starts = np.concatenate([starts, begin(hypothesis, start, others=nominal.minimum.z[None]).starts])
    best = best_of([_descended(hypothesis, z, *_FINE) for z in starts])
    return SimpleForm(at.place, best, tolerant_evidence(best))
