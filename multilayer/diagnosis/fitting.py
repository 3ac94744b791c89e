"""Fits of hypotheses, and the evidence of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import TypeVar
from warnings import warn

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.law_errors import with_errors_at_places
from multilayer.diagnosis.model_discrepancy import WithLawErrors, law_basis, smooth_basis
from multilayer.diagnosis.thresholds import NEAR, ROUGH, UNEXPLAINED
from multilayer.errors import PluginWarning
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.inference.least_squares import minimise, minimise_bfgs
from multilayer.inference.low_rank import LowRank, WithModelErrors
from multilayer.inference.multistart import continuation_sizes, costs_per_datum, is_far_off, valleys
from multilayer.inference.problem import Minimum, Problem

K = TypeVar("K")
H = TypeVar("H", bound=Hypothesis)
_WIDEST = 100.0  # most standard deviations of the prior, times an effect's `size_error`, that a law leaves uncertain
_TINY = 1e-300
_TOLERANCE = 1e-9  # of the cost, relative: sizes are then reproducible to 1e-3 on any processor
_COARSE = 1e-3  # tolerance of minima that are only compared
_SOME, _MOST = 30, 100  # steps after which minima are compared, and after which a descent is given up
COARSELY = (_SOME, _COARSE)  # steps and tolerance of minima that are only compared
_FOLLOWED = 2  # valleys that are followed to their minimum
_BEHIND = 10.0  # times the least misfit in the valleys of all effects, above which an effect is given up
# times the least cost, up to which coarse minima are polished and laws refined; and how many at most
NEAR_LEAST, _MOST_FOLLOWED = 2.0, 5
_POSITIVE = (-2.0, -1.0, 0.0, 1.0, 2.0)  # coordinates of an effect's parameters that are tried: of sizes above 0 ...
_SIGNED = (-2.0, -0.7, -0.2, 0.2, 0.7, 2.0)  # ... and of sizes of either sign


@dataclass(frozen=True)
class Fitted:
    """A hypothesis at its most probable parameters.

    Attributes
    ----------
    hypothesis : Hypothesis
    minimum : Minimum
        Its residuals are whitened by noise and by the errors of the effects' laws.
    errors : LowRank, optional
        Covariance of noise and of the laws' errors; none of the nominal model.
    valleys : array, shape (k, n), optional
        Coordinates where its descents began, the most promising first.
    """

    hypothesis: Hypothesis
    minimum: Minimum
    errors: LowRank | None = None
    valleys: RealArray | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return self.hypothesis.names

    @property
    def is_bent(self) -> bool:
        """Whether it takes an error of an effect's law: the law as it stands has less evidence."""
        return self.errors is not None or any(effect.error_of for effect in self.hypothesis.effects)

    @property
    def log_evidence(self) -> float:
        """Laplace's approximation, without the constant of the whitened data."""
        return self.minimum.log_evidence - (0.5 * self.errors.log_determinant if self.errors else 0.0)

    def of_effects(self, *, errors: bool = False) -> NDArray[np.bool_]:
        """Tell which parameters are the effects' own or, with `errors`, those of errors of their laws; shape (d,)."""
        # with the dot: what the laboratory states of a channel's gain has the effect's name
        names = tuple(f"{effect.name}." for effect in self.hypothesis.effects if bool(effect.error_of) == errors)
        return np.array([parameter.name.startswith(names) for parameter in self.hypothesis.parameters], dtype=bool)

    @property
    def parameter_cost(self) -> float:
        """Nats of evidence that the effects' own parameters cost: ln of the prior's volume over the posterior's."""
        own = self.of_effects()
        return -0.5 * float(np.linalg.slogdet(self.minimum.covariance[np.ix_(own, own)])[1])

    def hypothesis_as(self, kind: type[H]) -> H:
        """Return the hypothesis, which must be of a kind.

        Raises
        ------
        TypeError
            When it is of another kind.
        """
        if not isinstance(self.hypothesis, kind):
            raise TypeError(f"{type(self.hypothesis).__name__} is no {kind.__name__}")
        return self.hypothesis

    def whitened(self, values: RealArray) -> RealArray:
        """Return changes of the hypothesis' residuals, shape (..., n_data), whitened by the laws' errors as well."""
        return values if self.errors is None else self.errors.whitened(values)

    def interval(self, name: str, probability: float = 0.9) -> tuple[float, float, float]:
        """Return value and ends of the central interval of a parameter, in its unit.

        By Laplace's approximation, and of an effect's parameter by the uncertainty of sizes for a given law
        (`BaseEffect.error_of_size`).
        """
        index = [p.name for p in self.hypothesis.parameters].index(name)
        prior = self.hypothesis.parameters[index].prior
        value, z = prior.value, float(self.minimum.z[index])
        here, slope = float(value(z)), prior.slope(z)
        relative = abs(slope) if prior.is_logarithmic else abs(slope) / max(abs(here), _TINY)
        # far beyond a bound of the prior the value is constant: its whole range is uncertain
        std_by_law = self._size_error(name) / max(relative, 1 / _WIDEST)
        spread = float(np.hypot(np.sqrt(self.minimum.covariance[index, index]), std_by_law))
        reach = spread * float(ndtri(0.5 + probability / 2))
        return here, float(value(np.asarray(z - reach))), float(value(np.asarray(z + reach)))

    def _size_error(self, name: str) -> float:
        of, _, parameter = name.partition(".")
        acting = (*self.hypothesis.effects, *getattr(self.hypothesis, "given", ()))
        effect = next((effect for effect in acting if effect.name == of), None)
        if effect is None:  # of the nominal model
            return 0.0
        return float(effect.error_of_size(parameter))


@dataclass(frozen=True)
class StartedFit:
    """A fit of which the valleys are known, but not yet their minima.

    Attributes
    ----------
    hypothesis : Hypothesis
    starts : array, shape (k, n)
        Coordinates in the valleys, the most promising first.
    provisional : Fitted
        The fit at the first of them, for the case that it is given up; a finished fit would have more evidence.
    """

    hypothesis: Hypothesis
    starts: RealArray
    provisional: Fitted

    @classmethod
    def at(cls, hypothesis: Hypothesis, starts: RealArray) -> StartedFit:
        """Return a fit that begins at these starts."""
        z, errors = starts[0], None
        problem: Problem = hypothesis
        if _has_law_errors(hypothesis) and np.all(np.isfinite(basis := law_basis(hypothesis, z))):
            errors = LowRank.of(basis)
            problem = WithModelErrors(hypothesis, errors)
        return cls(hypothesis, starts, Fitted(hypothesis, problem.as_minimum(z), errors))

    @property
    def ends(self) -> list[Callable[[], Fitted]]:
        """Tasks that finish the fit in each valley; the result with the most evidence is the fit."""
        return [partial(at_minimum, self.hypothesis, z, *COARSELY) for z in self.starts]


def fit(hypothesis: Hypothesis, start: RealArray) -> Fitted:
    """Return the most probable parameters of a hypothesis; see `begin`."""
    return _polish(finish_all({0: begin(hypothesis, start)})[0])


def begin(
    hypothesis: Hypothesis, start: RealArray, *, others: RealArray | None = None, followed: int = _FOLLOWED
) -> StartedFit:
    """Return a fit of a hypothesis whose valleys are known.

    Parameters
    ----------
    hypothesis : Hypothesis
    start : array, shape (n,)
        Coordinates of law and nuisances, and of the effects but the last.
    others : array, shape (m, n), optional
        Further starts.
    followed : int
        How many valleys are followed to their minimum.
    """
    # without the effect, nuisances may have been fitted far off to explain what the effect explains
    is_nuisance = np.array([parameter.nuisance for parameter in hypothesis.parameters[: len(start)]], dtype=bool)
    bases = [start[None], np.where(is_nuisance, 0.0, start)[None], *([] if others is None else [others])]
    effect = np.stack(_starting_points(hypothesis, len(hypothesis.parameters) - len(start)))
    starts = valleys(hypothesis, np.unique(np.concatenate(bases), axis=0), effect)
    if any(e.needs_finite_elements for e in hypothesis.effects):
        # finite elements hold around the law that they were made for: this is as good a start as a valley
        points = np.concatenate([np.broadcast_to(start, (len(effect), len(start))), effect], axis=1)
        best = points[np.argmin(costs_per_datum(hypothesis.residual, points))]
        return StartedFit.at(hypothesis, np.insert(starts[:followed], 0, best, axis=0))
    if not len(starts):  # no response anywhere: the start itself, at which the fit will have no finite cost
        starts = np.concatenate([start, effect[0]])[None]
    return StartedFit.at(hypothesis, starts[:followed])


def _has_law_errors(hypothesis: Hypothesis) -> bool:
    return any(hypothesis.law_errors)


def at_minimum(hypothesis: Hypothesis, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Fitted:
    """Return the minimum reached from a start near it, with the errors of laws there."""
    if not _has_law_errors(hypothesis):
        return Fitted(hypothesis, minimise_scaled(hypothesis, start, most, tolerance))
    with_errors = WithLawErrors(hypothesis, exact=tolerance < _COARSE)
    minimum = with_errors.minimum(minimise_scaled(with_errors, start, most, tolerance))
    return Fitted(hypothesis, minimum, with_errors.errors(minimum.z))


def polish_fits(
    fits: Mapping[K, Fitted], executor: Executor | None = None, most: float = float("inf")
) -> dict[K, Fitted]:
    """Return coarse fits at their exact minima.

    Fits that explain far less than the best, or leave a cost of more than `most` per datum, stay as they are; those
    that an experiment may have to distinguish from the best are followed to full convergence. A coarse fit has more
    room for errors of its law than the effect's place gives it: as long as one promises more than those at places hold,
    it is tried there.
    """
    least = min((fit.minimum.cost for fit in fits.values()), default=0.0)
    ranked = sorted(fits, key=lambda key: -fits[key].log_evidence)
    promising = [key for key in ranked if fits[key].minimum.cost_per_datum < most]
    chosen = [key for key in promising if fits[key].minimum.cost < NEAR_LEAST * least][:_MOST_FOLLOWED]
    tried, polished, best = list[K](), dict(fits), float("-inf")
    while chosen:
        polished = _replaced(polished, chosen, _at_places, executor)
        tried += chosen
        best = max(polished[key].log_evidence for key in tried)
        rest = [key for key in promising if key not in tried and fits[key].log_evidence > best - NEAR]
        chosen = rest[:_MOST_FOLLOWED]
    tried.sort(key=lambda key: -polished[key].log_evidence)
    near = [key for key in tried if polished[key].log_evidence > best - NEAR - ROUGH * polished[key].minimum.cost]
    near = near[:_MOST_FOLLOWED]
    polished = _replaced(polished, near, _polish, executor)
    best = max((polished[key].log_evidence for key in near), default=0.0)
    rivals = [key for key in near if polished[key].log_evidence > best - NEAR]
    return _replaced(polished, rivals, _with_fixed_errors, executor)


def _replaced(
    fits: Mapping[K, Fitted], keys: Sequence[K], change: Callable[[Fitted], Fitted], executor: Executor | None
) -> dict[K, Fitted]:
    return {**fits, **dict(zip(keys, run_all(change, [fits[key] for key in keys], executor), strict=True))}


def _at_places(fitted: Fitted) -> Fitted:
    """Return a coarse fit with errors of its laws at their places, or with laws as they are, whatever is better.

    A hypothesis without such a place stays as it is.
    """
    placed = with_errors_at_places(fitted.hypothesis, fitted.minimum.z)
    if placed is None:
        return fitted
    exact = Fitted(fitted.hypothesis, minimise_scaled(fitted.hypothesis, fitted.minimum.z, *COARSELY))
    again = with_errors_at_places(fitted.hypothesis, exact.minimum.z)
    ends = [at_minimum(*at, *COARSELY) for at in (placed, again) if at is not None]
    return replace(best_of([exact, *ends]), valleys=fitted.valleys)


def _polish(fitted: Fitted) -> Fitted:
    """Return the best of the minima reached from a fit and, where its misfit is large, from its valleys.

    With errors of laws, and with the laws as they are: how wrong a law is cannot be known beforehand, and one that
    holds exactly needs no room for errors. Where an effect has a place, the error of its law is a function there, the
    same in all configurations. The misfit is that without errors of laws that are taken in to first order. A minimum
    that needs these need not be near a valley without them, and a descent with them from far away goes astray: from
    there a smooth discrepancy is allowed first, and reduced in steps.
    """
    misfit = float(costs_per_datum(fitted.hypothesis.residual, fitted.minimum.z[None])[0])
    hypothesis, z = fitted.hypothesis.bare(fitted.minimum.z)
    starts = [z]
    if fitted.valleys is not None and is_far_off(misfit):
        misfits = costs_per_datum(hypothesis.residual, fitted.valleys)
        pairs = zip(fitted.valleys, map(continuation_sizes, misfits), strict=True)
        starts += [_by_continuation(hypothesis, *pair) for pair in pairs]
    if not _has_law_errors(hypothesis):
        return best_of([at_minimum(hypothesis, start) for start in starts])
    exact = best_of([Fitted(hypothesis, minimise_scaled(hypothesis, start, *COARSELY)) for start in starts])
    placed = with_errors_at_places(hypothesis, exact.minimum.z)
    exact = Fitted(hypothesis, minimise_scaled(hypothesis, exact.minimum.z))
    if placed is None:
        return best_of([exact, *(at_minimum(hypothesis, start) for start in starts)])
    ends = [at_minimum(*placed, *COARSELY)]
    if fitted.hypothesis.effects != hypothesis.effects:
        ends.append(fitted)
    end = best_of(ends)
    return best_of([exact, at_minimum(end.hypothesis, end.minimum.z)])


def _by_continuation(hypothesis: Hypothesis, z: RealArray, sizes: Sequence[float]) -> RealArray:
    """Return coordinates near the minimum that a descent reaches with a smooth discrepancy of falling size."""
    smooth = smooth_basis(hypothesis)
    for size in sizes:
        errors = LowRank.of(np.concatenate([size * smooth, law_basis(hypothesis, z)], axis=1))
        z = minimise(WithModelErrors(hypothesis, errors), z, _SOME, _COARSE, "dogbox").z
    return z


def _with_fixed_errors(fitted: Fitted) -> Fitted:
    """Return a fully converged fit with the errors of laws fixed; one that explains nothing stays as it is.

    The size of a law's error is known only roughly and must not influence the size of its effect: the errors are fixed
    at the minimum of `WithLawErrors`, and the hypothesis is fitted again.
    """
    if fitted.errors is None or fitted.minimum.cost_per_datum > UNEXPLAINED:
        return fitted
    with_errors = WithLawErrors(fitted.hypothesis)
    z = minimise_bfgs(with_errors, fitted.minimum.z).z
    errors = with_errors.errors(z)
    return Fitted(fitted.hypothesis, minimise_scaled(WithModelErrors(fitted.hypothesis, errors), z), errors)


def minimise_scaled(problem: Problem, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Minimum:
    """Return the minimum reached from a start, with steps scaled by the Jacobian."""
    return minimise(problem, start, most, tolerance, "trf", scaled=True)


def _starting_points(hypothesis: Hypothesis, missing: int) -> list[RealArray]:
    """Return starting coordinates of the last effect, of which `missing` is the number of parameters."""
    if not missing:
        return [np.empty(0)]
    effect = hypothesis.effects[-1]
    if effect.starts:
        return [np.array(point) for point in effect.starts]
    grids = [_SIGNED if parameter.prior.normal is not None else _POSITIVE for parameter in effect.parameters]
    return [np.array(point) for point in product(*grids)]


def fit_effects(
    nominal: Fitted,
    effects: Mapping[str, BaseEffect],
    start: RealArray | None = None,
    executor: Executor | None = None,
) -> dict[tuple[str, ...], Fitted]:
    """Return coarse fits of every effect by itself, for `polish_fits`.

    Parameters
    ----------
    nominal : Fitted
    effects : mapping
        By name; those that the model admits.
    start : array, optional
        The nominal model's unknowns to start from; those of `nominal` when left out.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    tasks = begin_tasks(nominal, effects, start)
    return finish_all(dict(zip(tasks, run_all(call, [*tasks.values()], executor), strict=True)), executor)


def begin_tasks(
    nominal: Fitted,
    effects: Mapping[str, BaseEffect],
    start: RealArray | None = None,
    others: Mapping[str, RealArray] | None = None,
) -> dict[tuple[str, ...], Callable[[], StartedFit]]:
    """Return the tasks that search the valleys of the fits of `fit_effects`; `others` are further starts by name."""
    first = nominal.minimum.z if start is None else start
    return {
        (name,): partial(begin, nominal.hypothesis.with_effects(effect), first, others=(others or {}).get(name))
        for name, effect in effects.items()
    }


def rough_fit(nominal: Fitted, effect: BaseEffect) -> Fitted:
    """Return an effect at the best of its starting points, beside the nominal model's unknowns as they are."""
    hypothesis, z = nominal.hypothesis.with_effects(effect), nominal.minimum.z
    sizes = np.stack(_starting_points(hypothesis, len(hypothesis.parameters) - len(z)))
    points = np.concatenate([np.broadcast_to(z, (len(sizes), len(z))), sizes], axis=1)
    best = points[np.argmin(costs_per_datum(hypothesis.residual, points))]
    return StartedFit.at(hypothesis, best[None]).provisional


def finish_all(
    started: Mapping[K, StartedFit],
    executor: Executor | None = None,
    rivals: Sequence[Fitted] = (),
    behind: float = _BEHIND,
) -> dict[K, Fitted]:
    """Return coarse fits from started ones, by the same keys; those far behind the best are given up.

    Parameters
    ----------
    started : mapping
    executor : Executor, optional
    rivals : sequence of Fitted
        Fits that have been finished already, whose costs times `behind` are compared with.
    behind : float
        Fits are given up above so many times the least cost in a first valley, or the number of data where larger.
    """
    ends = worth_finishing(started, rivals, behind)
    return best_ends(started, ends, run_all(call, [end for _, end in ends], executor))


def worth_finishing(
    started: Mapping[K, StartedFit], rivals: Sequence[Fitted] = (), behind: float = _BEHIND
) -> list[tuple[K, Callable[[], Fitted]]]:
    """Return the descents of `finish_all`, by the keys of their fits."""
    costs = {key: fit.provisional.minimum.cost for key, fit in started.items()}
    n = max((len(fit.provisional.minimum.residual) for fit in started.values()), default=0)
    finished = [behind * fit.minimum.cost for fit in rivals]
    least = max(min([*costs.values(), *finished], default=0.0), n)
    worth = [key for key, cost in costs.items() if np.isfinite(cost) and cost <= behind * least]
    return [(key, end) for key in worth for end in started[key].ends]


def best_ends(
    started: Mapping[K, StartedFit], tasks: Sequence[tuple[K, Callable[[], Fitted]]], fits: Sequence[Fitted]
) -> dict[K, Fitted]:
    """Return the fits of `finish_all` from what its descents reach."""
    ends: dict[K, list[Fitted]] = {}
    for (key, _), end in zip(tasks, fits, strict=True):
        if end.minimum.is_finite:
            ends.setdefault(key, []).append(end)
    return {
        key: replace(best_of(ends[key]), valleys=fit.starts) if key in ends else fit.provisional
        for key, fit in started.items()
    }


def with_response(
    fits: Mapping[tuple[str, ...], Fitted], effects: Mapping[str, BaseEffect]
) -> tuple[dict[tuple[str, ...], Fitted], dict[str, BaseEffect]]:
    """Return the fits of effects one by one that have a response, and their effects.

    Warns
    -----
    PluginWarning
        Of each effect that is left out.
    """
    kept = {names: fit for names, fit in fits.items() if fit.minimum.is_finite}
    for names in (names for names in fits if names not in kept):
        text = "the model has no response (NaN or infinite) wherever its fit began, so it is left out of the diagnosis"
        warn(f"effect {'+'.join(names)}: {text}; check_effect of multilayer.testing tells more", PluginWarning, 3)
    return kept, {name: effect for name, effect in effects.items() if (name,) in kept}


def best_of(ends: Sequence[Fitted]) -> Fitted:
    """Return the fit with the most evidence."""
    return max(ends, key=lambda fit: fit.log_evidence)
