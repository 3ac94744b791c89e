"""Where something unknown acts: the evidence of every place with a free law."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cached_property, partial
from warnings import warn

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.fitting import Fitted, best_of, minimise_scaled
from multilayer.diagnosis.places import BasePlace, places_of
from multilayer.diagnosis.thresholds import (
    DRAWN_ERROR,
    LAW_LENGTH,
    LAW_SIZES,
    LEAST_SCORE,
    NEAR,
    ROUGH,
    TOLD_SIZE,
    UNEXPLAINED,
)
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.errors import PluginWarning
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.places import DifferingLaw, DrawnLaw, MovingLaw, SimpleLaw, VaryingLaw
from multilayer.inference.derivative import central
from multilayer.inference.multistart import costs_per_datum
from multilayer.inference.problem import Minimum, Scaled

# evaluations and relative change of the cost: of descents on the way, and of those that are compared
COARSE, FINE = (30, 1e-3), (60, 1e-6)
_FOLLOWED = 3  # places that are followed where no law explains the data
_TOLD_AT, _AROUND = 61, 5.0  # frequencies at which a law is told; about a resonance as far as so many loss factors
_CONSTANTS = tuple(complex(size, loss) for size in np.linspace(-3, 3, 25) for loss in (-0.5, 0.0, 0.5))
_TINY = 1e-3  # of a law's largest value, where that is taken for its size


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
    price : float
        What the place's own fields, fitted besides, cost of the evidence of every law there, nats.
    """

    place: BasePlace
    fitted: Fitted
    log_evidence: float
    simple: Fitted | None = None
    term: SimpleForm | None = None
    price: float = 0.0

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

    Warns
    -----
    PluginWarning
        Of a place at which no law has a response: it is left out.
    """
    problem = nominal.hypothesis
    places: list[tuple[BasePlace, Fitted]] = []
    for name, kind in places_of(problem.kind).items():
        if names is not None and name not in names:
            continue
        steps = [(place, _first_step(nominal, place)) for place in kind.instances(problem.settings)]
        answering = [(place, step) for place, step in steps if step.minimum.is_finite]
        places += [max(answering, key=lambda pair: pair[1].log_evidence + _lead(pair[0]))] if answering else []
        if steps and not answering:
            text = f"place {name}: the model has no response (NaN or infinite) with a law there, so it is left out"
            warn(f"{text}; check_place of multilayer.testing tells more", PluginWarning, 2)
    # what gains nothing to first order is at its minimum after that step
    idle = [unfinished(step) for _, step in places if not _gains(nominal, step)]
    tasks = [partial(begun_at, nominal, place) for place, step in places if _gains(nominal, step)]
    begun = run_all(call, tasks, executor)
    begun.sort(key=lambda fit: -tolerant_evidence(fit))
    most = len(begun) if is_explained(begun) else _FOLLOWED  # where no law explains anything, orders mean little
    near = near_best(begun[:most])
    fits = run_all(call, [partial(finished, nominal, fit) for fit in near], executor)
    fits += [unfinished(fit) for fit in begun if not any(fit is other for other in near)]
    return ranked([*fits, *idle])


def as_told(nominal: Fitted, fit: PlaceFit) -> PlaceFit:
    """Return a place with its free law as it is told: with a standard deviation of at least `TOLD_SIZE`.

    The size of the most evidence is the smallest that the data bear, and pulls a law that the unknowns can take up in
    part, as a compliance beside the modulus, towards 0. The evidence stays that of the place as it was compared.
    """
    size = TOLD_SIZE * scale_of(nominal, fit.place)[0]
    if fit.simple is not None or np.all(fit.drawn.size >= size):
        return fit
    return replace(fit, fitted=descended(*_resized(fit.fitted, size), *FINE))


def free_to_differ(fit: PlaceFit) -> Fitted:
    """Return the explanation at a place; of a law that differs, with what differs as an unknown beside all others.

    A place has that fixed, so that it says nothing of what else would have to differ with it, as the modulus.
    """
    place, law = fit.place, fit.drawn
    if not (place.factors or place.moved):
        return fit.explanation
    hypothesis = fit.fitted.hypothesis
    kind, values = (VaryingLaw, place.factors) if place.factors else (MovingLaw, place.moved)
    pieces = hypothesis.pieces.get(place.differs_by) or {name: name for name in values}
    plain = replace(law, at_place=place.differing())
    differing: DifferingLaw = kind.of(plain, {name: pieces[name] for name in values}, place.differs_by)
    z = np.append(fit.fitted.minimum.z, differing.coordinates(values))
    return descended(hypothesis.with_effects(differing), z, *FINE)


def ranked(fits: Iterable[PlaceFit]) -> dict[str, PlaceFit]:
    """Return places by label, the one with the most evidence first."""
    return {fit.place.label: fit for fit in sorted(fits, key=lambda fit: -fit.log_evidence)}


def is_explained(fits: Iterable[Fitted]) -> bool:
    """Tell whether some fit explains the data at all."""
    return any(fit.minimum.cost_per_datum <= UNEXPLAINED for fit in fits)


def may_explain(nominal: Fitted, places: Mapping[str, PlaceFit], effect: BaseEffect) -> bool:
    """Tell whether an effect may be near the best explanation: a named law gains at most what a free one does there.

    Of an effect that acts in more ways than through its place, and without places, that is always so.
    """
    at = places.get(effect.place)
    if at is None or not effect.acts_through_place:
        return True
    cost = at.explanation.minimum.cost
    gain = 0.5 * (nominal.minimum.cost - cost)
    best = max(nominal.log_evidence, *(fit.log_evidence for fit in places.values()))
    return gain > LEAST_SCORE and nominal.log_evidence + gain > best - NEAR - ROUGH * cost


def scale_of(nominal: Fitted, place: BasePlace) -> tuple[float, RealArray]:
    """Return the place's scale, and the frequencies of all data, Hz."""
    problem = nominal.hypothesis
    frequency = np.concatenate([data.frequency for data in problem.data])
    centre = float(np.sqrt(frequency.min() * frequency.max()))
    return place.scale(problem.settings, problem.modulus_scale(nominal.minimum.z, centre)), frequency


def _first_step(nominal: Fitted, place: BasePlace) -> Fitted:
    """Return a place with a free law of the larger size, one Gauss-Newton step from the nominal model."""
    scale, frequency = scale_of(nominal, place)
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


def begun_at(nominal: Fitted, place: BasePlace, length: float | None = None) -> Fitted:
    """Return a coarse fit of a place with a free law of the larger size."""
    scale, frequency = scale_of(nominal, place)
    law = DrawnLaw.at(place, frequency, LAW_SIZES[-1] * scale, length or place.length)
    hypothesis, at_rest = nominal.hypothesis.with_effects(law), nominal.hypothesis.at_rest(nominal.minimum.z)
    sizes = [*(_CONSTANTS if place.detunes else (0j,)), *(value / law.size for value in place.known_values)]
    starts = np.stack([np.concatenate([at_rest, law.constant(complex(size))]) for size in sizes])
    return descended(hypothesis, starts[np.argmin(costs_per_datum(hypothesis.residual, starts))], *COARSE)


def near_best(begun: Sequence[Fitted]) -> list[Fitted]:
    """Return the coarse fits that may turn out to be the best."""
    best = max((tolerant_evidence(fit) for fit in begun), default=0.0)
    return [fit for fit in begun if tolerant_evidence(fit) > best - NEAR - ROUGH * fit.minimum.cost]


def unfinished(begun: Fitted) -> PlaceFit:
    """Return a coarse fit as that of its place."""
    return PlaceFit(begun.hypothesis.effects[-1].at_place, begun, tolerant_evidence(begun))


def finished(nominal: Fitted, begun: Fitted) -> PlaceFit:
    """Return the fit of a place, from a coarse one and from the nominal model, with each size of its law."""
    begun = best_variant(nominal, begun, *COARSE)
    law: DrawnLaw = begun.hypothesis.effects[-1]
    at_rest = np.concatenate([nominal.hypothesis.at_rest(nominal.minimum.z), np.zeros(len(law.parameters))])
    fits = [descended(begun.hypothesis, begun.minimum.z, *FINE)]
    for size in LAW_SIZES[:-1]:
        hypothesis, z = _resized(fits[0], law.size * size / LAW_SIZES[-1])
        fits.append(best_of([descended(hypothesis, start, *FINE) for start in (z, at_rest)]))
    evidences = [tolerant_evidence(fit) for fit in fits]
    best = fits[int(np.argmax(evidences))]
    return PlaceFit(law.at_place, best, float(logsumexp(evidences) - np.log(len(evidences))))


def _resized(fitted: Fitted, size: float | RealArray) -> tuple[Hypothesis, RealArray]:
    """Return the hypothesis with a drawn law of another size, and coordinates at which the law is the same."""
    law, z = fitted.hypothesis.effects[-1], fitted.minimum.z.copy()
    z[-len(law.parameters) :] *= law.size / size
    return fitted.hypothesis.with_effects(replace(law, size=size)), z


def best_variant(nominal: Fitted, fitted: Fitted, most: int, tolerance: float) -> Fitted:
    """Return the fit of a law at a place in the way of acting there that has the most evidence, each from that fit.

    The first of its ways, unless another is ahead by as much as a cause must be of none. Of large laws the first step
    from the nominal model, by which a variant is chosen, does not tell.
    """
    hypothesis, z = fitted.hypothesis, fitted.minimum.z
    law = hypothesis.effects[-1]
    kinds = [kind for kind in type(law.at_place).variants() if kind is not type(law.at_place)]
    known = [place for kind in kinds for place in kind.instances(hypothesis.settings) if type(place) is kind]
    others = [place for place in known if place.label == law.at_place.label]
    laws = [_at_other(nominal, law, place.differing(*law.at_place.differences)) for place in others]
    fits = [fitted, *(descended(nominal.hypothesis.with_effects(each), z, most, tolerance) for each in laws)]
    if isinstance(law, DrawnLaw):
        fits += [begun_at(nominal, place, law.length) for place in others if place.known_values]
    return max(fits, key=lambda fit: tolerant_evidence(fit) + _lead(fit.hypothesis.effects[-1].at_place))


def _lead(place: BasePlace) -> float:
    """Return by how many nats a place is ahead of its variants: its first way of acting, unless another is clearly so.

    Ways of acting may be the same in some rigs, and differ by rounding alone.
    """
    return LEAST_SCORE if type(place) is type(place).variants()[0] else 0.0


def _at_other(nominal: Fitted, law: DrawnLaw | SimpleLaw, place: BasePlace) -> DrawnLaw | SimpleLaw:
    """Return a law at another place, where the same coordinates do about as much."""
    scale, frequency = scale_of(nominal, place)
    if isinstance(law, SimpleLaw):
        return SimpleLaw.at(place, law.terms, frequency, scale)
    factor = scale / scale_of(nominal, law.at_place)[0]
    return replace(law, at_place=place, name=place.label, size=factor * law.size)


def descended(hypothesis: Hypothesis, z: RealArray, most: int, tolerance: float) -> Fitted:
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
            z = minimise_scaled(Scaled(hypothesis, scale), z, *COARSE).z
    return Fitted(hypothesis, minimise_scaled(hypothesis, z, most, tolerance))
