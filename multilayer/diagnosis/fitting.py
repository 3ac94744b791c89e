"""Fits of hypotheses, and the evidence of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from itertools import product
from typing import TypeVar

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.diagnosis.law_errors import Embedded, LawErrors, Softened, law_basis, smooth_basis
from multilayer.diagnosis.thresholds import ALIVE
from multilayer.executors import call, run_all
from multilayer.inverse.least_squares import minimise, settle
from multilayer.inverse.problem import Minimum, Problem

K = TypeVar("K")
_STEP = 1e-3  # of a coordinate
_WIDEST = 100.0  # standard deviations of the prior, times an effect's `size_error`, that a law leaves open at most
_TINY = 1e-300
_TOLERANCE = 1e-9  # of the cost, relative: sizes are then the same to 1e-3 whatever the processor
_ROUGH = 1e-3  # that of minima that are compared
_FEW, _SOME, _MOST = 15, 30, 100  # steps after which starts, and ends, are compared, and a descent is given up
ROUGHLY = (_SOME, _ROUGH)  # steps and tolerance of minima that are compared
_FAR = 4.0  # times the misfit that chance makes
_BEHIND = 10.0  # times the least misfit of all effects after the first steps: of one that is given up
_NEAR, _MOST_FOLLOWED = 2.0, 5  # the same of fits whose rough minima are followed to the end, and how many of them
_TYPICAL, _LARGEST, _FALL = 0.004, 0.3, 6.0  # relative: a standard deviation of the data; of discrepancies; by steps of
_POSITIVE = (-2.0, -1.0, 0.0, 1.0, 2.0)  # coordinates of an effect's parameters that are tried: of sizes above 0 ...
_SIGNED = (-2.0, -0.7, -0.2, 0.2, 0.7, 2.0)  # ... and of those of either sign


@dataclass(frozen=True)
class Fitted:
    """A hypothesis at its most probable parameters.

    Attributes
    ----------
    hypothesis : AnyHypothesis
    minimum : Minimum
        Its residuals have unit variance where the effects' laws are as wrong as they may be.
    errors : LawErrors, optional
        Those of the laws; none of the nominal model.
    """

    hypothesis: AnyHypothesis
    minimum: Minimum
    errors: LawErrors | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its effects."""
        return self.hypothesis.names

    @property
    def log_evidence(self) -> float:
        """Laplace's, but for the constant of the whitened data."""
        return self.minimum.log_evidence - (0.5 * self.errors.log_determinant if self.errors else 0.0)

    def softened(self, values: RealArray) -> RealArray:
        """Return changes of the hypothesis' residuals, shape (..., n_data), as changes of those of the minimum."""
        return values if self.errors is None else self.errors.whitened(values)

    def interval(self, name: str, probability: float = 0.9) -> tuple[float, float, float]:
        """Return value and ends of the central interval of an effect's parameter, in its own unit.

        Laplace's approximation, and what the effect's law leaves open of the size (`BaseEffect.size_error`).
        """
        index = [p.name for p in self.hypothesis.parameters].index(name)
        value = self.hypothesis.parameters[index].prior.value
        z = float(self.minimum.z[index])
        here, ahead, behind = (float(value(np.asarray(x))) for x in (z, z + _STEP, z - _STEP))
        # far beyond a bound of the prior the value does not move any more: its whole range is open
        slope = max(abs(ahead - behind) / (2 * _STEP), abs(here) / _WIDEST, _TINY)
        open_by_law = self._size_error(name) * abs(here) / slope
        spread = float(np.hypot(np.sqrt(self.minimum.covariance[index, index]), open_by_law))
        reach = spread * float(ndtri(0.5 + probability / 2))
        return here, float(value(np.asarray(z - reach))), float(value(np.asarray(z + reach)))

    def _size_error(self, name: str) -> float:
        effect = next(effect for effect in self.hypothesis.effects if name.startswith(f"{effect.name}."))
        return effect.law_error if effect.size_error is None else effect.size_error


@dataclass(frozen=True)
class Begun:
    """A fit after a few steps.

    Attributes
    ----------
    hypothesis : AnyHypothesis
    ways : tuple of (tuple of float, Minimum)
        Sizes of a discrepancy that is let go by and by, none of the straight way, and the minimum with the first of
        them. Any way may end in a wrong valley. Those of `begin` are the straight one, and one with a discrepancy of
        what is far off.
    """

    hypothesis: AnyHypothesis
    ways: tuple[tuple[tuple[float, ...], Minimum], ...]

    @property
    def costs(self) -> tuple[float, ...]:
        """Of every way so far."""
        return tuple(minimum.cost for _, minimum in self.ways)

    @property
    def ends(self) -> list[Callable[[], Fitted]]:
        """What finishes the fit on every way, not done yet; that with the most evidence is the fit."""
        return [partial(_finish, self.hypothesis, minimum.z, sizes) for sizes, minimum in self.ways]

    def given_up(self) -> Fitted:
        """Return the fit where it is; at its end it would have more evidence."""
        return Fitted(self.hypothesis, self.ways[0][1])


def fit(hypothesis: AnyHypothesis, start: RealArray, *, followed: int | None = None) -> Fitted:
    """Return the most probable parameters of a hypothesis; see `begin`."""
    return _polish(best_of([end() for end in begin(hypothesis, start, followed=followed).ends]))


def begin(hypothesis: AnyHypothesis, start: RealArray, *, followed: int | None = None) -> Begun:
    """Return the first steps of the fit of a hypothesis.

    Parameters
    ----------
    hypothesis : AnyHypothesis
    start : array
        Coordinates of law and nuisances, and of effects that are given already.
    followed : int, optional
        How many of the starts with the least cost are followed; by default one for a single number to be found, two
        for several: resonances have more than one valley.
    """
    missing = len(hypothesis.parameters) - len(start)
    # what is stated of the laboratory may have been dragged far off to explain what the effect explains
    stated = np.array([parameter.nuisance for parameter in hypothesis.parameters[: len(start)]], dtype=bool)
    bases = (start, np.where(stated, 0.0, start)) if np.any(start[stated]) else (start,)
    own = starting_points(hypothesis, missing)
    points = np.stack([np.concatenate([base, at]) for base in bases for at in own])
    residuals, priors = hypothesis.residual(points), np.sum(points**2, axis=-1)
    sizes = _discrepancies(float(np.nanmin(np.sum(residuals**2, axis=-1) + priors)) / residuals.shape[-1])
    if sizes:
        residuals = LawErrors.of(sizes[0] * smooth_basis(hypothesis)).whitened(residuals)
    costs = np.sum(residuals**2, axis=-1) + priors
    order = np.argsort(costs, kind="stable")
    chosen = list(order[: followed or (1 if missing < 2 else 2)])
    if sizes:  # far off, the cost of a start says little: the best of either kind is followed
        kinds = range(len(bases))
        chosen = list(dict.fromkeys([*chosen, *(int(order[order // len(own) == kind][0]) for kind in kinds)]))
    ways = ((), sizes) if sizes else ((),)
    return Begun(hypothesis, tuple((way, _first_steps(hypothesis, points[chosen], way)) for way in ways))


def _discrepancies(per_datum: float) -> tuple[float, ...]:
    """Return relative sizes of a smooth discrepancy that is allowed while the fit is far off, falling.

    What is thousands of standard deviations off drags everything else along; a minimum is found by and by.
    """
    if not per_datum > _FAR:
        return ()
    first = min(_TYPICAL * float(np.sqrt(per_datum)), _LARGEST)
    return tuple(np.geomspace(first, _TYPICAL, max(2, int(np.ceil(np.log(first / _TYPICAL) / np.log(_FALL))))))


def _first_steps(hypothesis: AnyHypothesis, starts: RealArray, sizes: Sequence[float]) -> Minimum:
    """Return where the best of some starts has come to, with the first of the discrepancies."""

    def roughly(start: RealArray) -> Minimum:
        return _approached(_softened(hypothesis, start, sizes[0]) if sizes else hypothesis, start, _FEW)

    return min((roughly(start) for start in starts), key=lambda one: one.cost)


def _finish(hypothesis: AnyHypothesis, start: RealArray, sizes: Sequence[float]) -> Fitted:
    """Return roughly the minimum reached from a start, with the errors of laws there."""
    z = start
    for size in sizes:
        z = _approached(_softened(hypothesis, z, size), z).z
    return at_minimum(hypothesis, z, *ROUGHLY)


def at_minimum(hypothesis: AnyHypothesis, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Fitted:
    """Return the minimum reached from a start near it, with the errors of laws there."""
    if not any(effect.law_error for effect in hypothesis.effects):
        return Fitted(hypothesis, minimised(hypothesis, start, most, tolerance))
    embedded = Embedded(hypothesis)
    found = embedded.minimum(minimised(embedded, start, most, tolerance))
    return Fitted(hypothesis, found, embedded.errors(found.z))


def polished(fits: Mapping[K, Fitted], executor: Executor | None = None) -> dict[K, Fitted]:
    """Return fits at their minima, from near there.

    Those that explain far less than the best are left as they are; those that an experiment may have to tell from the
    best are followed until nothing moves any more.
    """
    least = min((one.minimum.cost for one in fits.values()), default=0.0)
    near = [key for key, one in fits.items() if one.minimum.cost < _NEAR * least]
    chosen = sorted(near, key=lambda key: -fits[key].log_evidence)[:_MOST_FOLLOWED]
    found = _replaced(fits, chosen, _polish, executor)
    best = max((found[key].log_evidence for key in chosen), default=0.0)
    return _replaced(found, [key for key in chosen if found[key].log_evidence > best - ALIVE], _settled, executor)


def _replaced(
    fits: Mapping[K, Fitted], keys: Sequence[K], change: Callable[[Fitted], Fitted], executor: Executor | None
) -> dict[K, Fitted]:
    return {**fits, **dict(zip(keys, run_all(change, [fits[key] for key in keys], executor), strict=True))}


def _polish(fitted: Fitted) -> Fitted:
    return at_minimum(fitted.hypothesis, fitted.minimum.z)


def _settled(fitted: Fitted) -> Fitted:
    """Return a fit where nothing moves any more; what is far off anyway stays where it is.

    How wrong a law is, is known roughly, and is not to tell how large its effect is: at last the errors are held as
    they are at the minimum of `Embedded`, and the fit follows.
    """
    if fitted.errors is None or fitted.minimum.cost > _FAR * len(fitted.minimum.residual):
        return fitted
    embedded = Embedded(fitted.hypothesis)
    z = settle(embedded, fitted.minimum.z).z
    errors = embedded.errors(z)
    return Fitted(fitted.hypothesis, minimised(Softened(fitted.hypothesis, errors), z), errors)


def minimised(problem: Problem, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Minimum:
    """Return the minimum reached from a start.

    From afar it takes more steps than `_approached`, and comes nearer where the valley is narrow.
    """
    return minimise(problem, start, most, tolerance, "trf", scaled=True)


def _approached(problem: Problem, start: RealArray, most: int = _MOST) -> Minimum:
    """Return roughly the minimum reached from a start that may be far off."""
    return minimise(problem, start, most, _ROUGH, "dogbox")


def _softened(hypothesis: AnyHypothesis, z: RealArray, size: float) -> Softened:
    """Return the hypothesis with a smooth discrepancy and the errors of laws at z."""
    basis = np.concatenate([size * smooth_basis(hypothesis), law_basis(hypothesis, z)], axis=1)
    return Softened(hypothesis, LawErrors.of(basis))


def starting_points(hypothesis: AnyHypothesis, missing: int) -> list[RealArray]:
    """Return the coordinates to start from of what is missing: the last effect's own where it says some."""
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
    starts: Mapping[str, RealArray] | None = None,
    executor: Executor | None = None,
) -> dict[tuple[str, ...], Fitted]:
    """Return the fit of every effect by itself, roughly: see `polished`.

    Parameters
    ----------
    nominal : Fitted
    effects : mapping
        By name; those that the model admits.
    starts : mapping, optional
        The nominal model's unknowns to start from, by effect, where those of `nominal` are of no use.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    tasks = begin_tasks(nominal, effects, starts)
    return finish_all(dict(zip(tasks, run_all(call, [*tasks.values()], executor), strict=True)), executor)


def begin_tasks(
    nominal: Fitted, effects: Mapping[str, BaseEffect], starts: Mapping[str, RealArray] | None = None
) -> dict[tuple[str, ...], Callable[[], Begun]]:
    """Return the first steps of the fits of `fit_effects`, not made yet."""
    known = starts or {}
    return {
        (name,): partial(begin, nominal.hypothesis.with_effects(one), known.get(name, nominal.minimum.z))
        for name, one in effects.items()
    }


def finish_all(
    begun: Mapping[K, Begun],
    executor: Executor | None = None,
    rivals: Sequence[Fitted] = (),
    behind: float = _BEHIND,
) -> dict[K, Fitted]:
    """Return roughly the fits that have begun, by the same keys; those far behind another, either way, are given up.

    Parameters
    ----------
    begun : mapping
    executor : Executor, optional
    rivals : sequence of Fitted
        Fits that have been finished already.
    behind : float
        Times the least misfit after the first steps: where those that are far off are given up.
    """
    done = [one.minimum.cost for one in rivals]
    straight = min((*done, *(one.costs[0] for one in begun.values())), default=0.0)
    eased = min((*done, *(one.costs[-1] for one in begun.values())), default=0.0)
    hopeless = {
        key
        for key, one in begun.items()
        if len(one.ways) > 1 and one.costs[0] > behind * straight and one.costs[1] > behind * eased
    }
    tasks = [(way, key, end) for key, one in begun.items() if key not in hopeless for way, end in enumerate(one.ends)]
    tasks.sort(key=lambda task: -task[0])  # the long ways first: workers then end together
    found: dict[K, list[Fitted]] = {key: [begun[key].given_up()] for key in hopeless}
    for (_, key, _), end in zip(tasks, run_all(call, [end for *_, end in tasks], executor), strict=True):
        found.setdefault(key, []).append(end)
    return {key: best_of(found[key]) for key in begun}


def best_of(ends: Sequence[Fitted]) -> Fitted:
    """Return the fit with the most evidence."""
    return max(ends, key=lambda one: one.log_evidence)
