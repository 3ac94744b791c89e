"""Fits of hypotheses, and the evidence of each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import TypeVar

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.model_discrepancy import Embedded, law_basis, smooth_basis
from multilayer.diagnosis.thresholds import ALIVE
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.inference.least_squares import minimise, minimise_bfgs
from multilayer.inference.low_rank import LowRank, WithModelErrors
from multilayer.inference.multistart import continuation_sizes, costs_per_datum, is_far_off, valleys
from multilayer.inference.problem import Minimum, Problem

K = TypeVar("K")
_WIDEST = 100.0  # standard deviations of the prior, times an effect's `size_error`, that a law leaves open at most
_TINY = 1e-300
_TOLERANCE = 1e-9  # of the cost, relative: sizes are then the same to 1e-3 whatever the processor
_ROUGH = 1e-3  # that of minima that are compared
_SOME, _MOST = 30, 100  # steps after which ends are compared, and a descent is given up
ROUGHLY = (_SOME, _ROUGH)  # steps and tolerance of minima that are compared
_FOLLOWED = 2  # valleys whose floor is sought
_BEHIND = 10.0  # times the least misfit of all effects in their valleys: of one that is given up
_NEAR, _MOST_FOLLOWED = 2.0, 5  # the same of fits whose rough minima are followed to the end, and how many of them
HOPELESS = 10.0  # cost per datum at a rough minimum, the errors of laws allowed, above which nothing is explained
_POSITIVE = (-2.0, -1.0, 0.0, 1.0, 2.0)  # coordinates of an effect's parameters that are tried: of sizes above 0 ...
_SIGNED = (-2.0, -0.7, -0.2, 0.2, 0.7, 2.0)  # ... and of those of either sign


@dataclass(frozen=True)
class Fitted:
    """A hypothesis at its most probable parameters.

    Attributes
    ----------
    hypothesis : Hypothesis
    minimum : Minimum
        Its residuals have unit variance where the effects' laws are as wrong as they may be.
    errors : LowRank, optional
        Those of the laws; none of the nominal model.
    valleys : array, shape (k, n), optional
        Coordinates where its search began, the most promising first.
    """

    hypothesis: Hypothesis
    minimum: Minimum
    errors: LowRank | None = None
    valleys: RealArray | None = None

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
        prior = self.hypothesis.parameters[index].prior
        value, z = prior.value, float(self.minimum.z[index])
        here, slope = float(value(z)), prior.slope(z)
        relative = abs(slope) if prior.is_logarithmic else abs(slope) / max(abs(here), _TINY)
        # far beyond a bound of the prior the value does not move any more: its whole range is open
        open_by_law = self._size_error(name) / max(relative, 1 / _WIDEST)
        spread = float(np.hypot(np.sqrt(self.minimum.covariance[index, index]), open_by_law))
        reach = spread * float(ndtri(0.5 + probability / 2))
        return here, float(value(np.asarray(z - reach))), float(value(np.asarray(z + reach)))

    def _size_error(self, name: str) -> float:
        effect = next(effect for effect in self.hypothesis.effects if name.startswith(f"{effect.name}."))
        return float(effect.law_error if effect.size_error is None else effect.size_error)


@dataclass(frozen=True)
class Begun:
    """A fit of which valleys are known, not their floors.

    Attributes
    ----------
    hypothesis : Hypothesis
    starts : array, shape (k, n)
        Coordinates in the valleys, the most promising first.
    given_up : Fitted
        The fit in the first of them, the errors of laws as there; at its end it would have more evidence.
    """

    hypothesis: Hypothesis
    starts: RealArray
    given_up: Fitted

    @classmethod
    def at(cls, hypothesis: Hypothesis, starts: RealArray) -> Begun:
        """Return what is known at the starts."""
        z, errors = starts[0], None
        problem: Problem = hypothesis
        if _has_law_errors(hypothesis):
            errors = LowRank.of(law_basis(hypothesis, z))
            problem = WithModelErrors(hypothesis, errors)
        residual, slopes = problem.linearised(z)
        return cls(
            hypothesis, starts, Fitted(hypothesis, Minimum(z, float(residual @ residual), residual, slopes), errors)
        )

    @property
    def ends(self) -> list[Callable[[], Fitted]]:
        """What finishes the fit in every valley, not done yet; that with the most evidence is the fit."""
        return [partial(at_minimum, self.hypothesis, z, *ROUGHLY) for z in self.starts]


def fit(hypothesis: Hypothesis, start: RealArray) -> Fitted:
    """Return the most probable parameters of a hypothesis; see `begin`."""
    return _polish(finish_all({0: begin(hypothesis, start)})[0])


def begin(
    hypothesis: Hypothesis, start: RealArray, *, others: RealArray | None = None, followed: int = _FOLLOWED
) -> Begun:
    """Return the valleys of a hypothesis.

    Parameters
    ----------
    hypothesis : Hypothesis
    start : array, shape (n,)
        Coordinates of law and nuisances, and of effects that are given already.
    others : array, shape (m, n), optional
        Further ones.
    followed : int
        Of how many valleys the floor is sought.
    """
    # what is stated of the laboratory may have been dragged far off to explain what the effect explains
    stated = np.array([parameter.nuisance for parameter in hypothesis.parameters[: len(start)]], dtype=bool)
    bases = [start[None], np.where(stated, 0.0, start)[None], *([] if others is None else [others])]
    effect = np.stack(_starting_points(hypothesis, len(hypothesis.parameters) - len(start)))
    starts = valleys(hypothesis, np.unique(np.concatenate(bases), axis=0), effect)
    if any(one.needs_finite_elements for one in hypothesis.effects):
        # these hold around one law, with which they were made: that is as good a start as a valley
        points = np.concatenate([np.broadcast_to(start, (len(effect), len(start))), effect], axis=1)
        straight = points[np.argmin(costs_per_datum(hypothesis.residual, points))]
        return Begun.at(hypothesis, np.insert(starts[:followed], 0, straight, axis=0))
    if not len(starts):  # no response anywhere: where it is, for what follows to say so
        starts = np.concatenate([start, effect[0]])[None]
    return Begun.at(hypothesis, starts[:followed])


def _has_law_errors(hypothesis: Hypothesis) -> bool:
    return any(effect.law_error for effect in hypothesis.effects)


def at_minimum(hypothesis: Hypothesis, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Fitted:
    """Return the minimum reached from a start near it, with the errors of laws there."""
    if not _has_law_errors(hypothesis):
        return Fitted(hypothesis, minimised(hypothesis, start, most, tolerance))
    embedded = Embedded(hypothesis)
    found = embedded.minimum(minimised(embedded, start, most, tolerance))
    return Fitted(hypothesis, found, embedded.errors(found.z))


def polished(fits: Mapping[K, Fitted], executor: Executor | None = None, most: float = float("inf")) -> dict[K, Fitted]:
    """Return fits at their minima, from near there.

    Those that explain far less than the best, or leave more than `most` per datum, stay as they are; those that an
    experiment may have to tell from the best are followed until nothing moves any more.
    """
    least = min((one.minimum.cost for one in fits.values()), default=0.0)
    near = [key for key, one in fits.items() if one.minimum.cost < _NEAR * least and one.minimum.cost_per_datum < most]
    chosen = sorted(near, key=lambda key: -fits[key].log_evidence)[:_MOST_FOLLOWED]
    found = _replaced(fits, chosen, _polish, executor)
    best = max((found[key].log_evidence for key in chosen), default=0.0)
    return _replaced(found, [key for key in chosen if found[key].log_evidence > best - ALIVE], _settled, executor)


def _replaced(
    fits: Mapping[K, Fitted], keys: Sequence[K], change: Callable[[Fitted], Fitted], executor: Executor | None
) -> dict[K, Fitted]:
    return {**fits, **dict(zip(keys, run_all(change, [fits[key] for key in keys], executor), strict=True))}


def _polish(fitted: Fitted) -> Fitted:
    """Return the best of a fit's own minimum and, where the data alone leave much over, those below its valleys.

    What the errors of laws may explain is no valley of the data alone, and a descent that uses them early is lost:
    there a smooth discrepancy is allowed first, and let go by and by.
    """
    hypothesis, starts = fitted.hypothesis, [fitted.minimum.z]
    if fitted.valleys is not None and is_far_off(float(costs_per_datum(hypothesis.residual, starts[0][None])[0])):
        misfits = costs_per_datum(hypothesis.residual, fitted.valleys)
        pairs = zip(fitted.valleys, map(continuation_sizes, misfits), strict=True)
        starts += [_eased(hypothesis, *pair) for pair in pairs]
    return best_of([at_minimum(hypothesis, start) for start in starts])


def _eased(hypothesis: Hypothesis, z: RealArray, sizes: Sequence[float]) -> RealArray:
    """Return roughly where a fit comes to with a smooth discrepancy that is let go by and by."""
    smooth = smooth_basis(hypothesis)
    for size in sizes:
        soft = LowRank.of(np.concatenate([size * smooth, law_basis(hypothesis, z)], axis=1))
        z = minimise(WithModelErrors(hypothesis, soft), z, _SOME, _ROUGH, "dogbox").z
    return z


def _settled(fitted: Fitted) -> Fitted:
    """Return a fit where nothing moves any more; what is hopeless stays where it is.

    How wrong a law is, is known roughly, and is not to tell how large its effect is: at last the errors are held as
    they are at the minimum of `Embedded`, and the fit follows.
    """
    if fitted.errors is None or fitted.minimum.cost_per_datum > HOPELESS:
        return fitted
    embedded = Embedded(fitted.hypothesis)
    z = minimise_bfgs(embedded, fitted.minimum.z).z
    errors = embedded.errors(z)
    return Fitted(fitted.hypothesis, minimised(WithModelErrors(fitted.hypothesis, errors), z), errors)


def minimised(problem: Problem, start: RealArray, most: int = _MOST, tolerance: float = _TOLERANCE) -> Minimum:
    """Return the minimum reached from a start."""
    return minimise(problem, start, most, tolerance, "trf", scaled=True)


def _starting_points(hypothesis: Hypothesis, missing: int) -> list[RealArray]:
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
    start: RealArray | None = None,
    executor: Executor | None = None,
) -> dict[tuple[str, ...], Fitted]:
    """Return the fit of every effect by itself, roughly: see `polished`.

    Parameters
    ----------
    nominal : Fitted
    effects : mapping
        By name; those that the model admits.
    start : array, optional
        The nominal model's unknowns to start from, where those of `nominal` are of no use.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    tasks = begin_tasks(nominal, effects, start)
    return finish_all(dict(zip(tasks, run_all(call, [*tasks.values()], executor), strict=True)), executor)


def begin_tasks(
    nominal: Fitted,
    effects: Mapping[str, BaseEffect],
    start: RealArray | None = None,
    others: RealArray | None = None,
) -> dict[tuple[str, ...], Callable[[], Begun]]:
    """Return the search for valleys in the fits of `fit_effects`, not done yet."""
    first = nominal.minimum.z if start is None else start
    return {
        (name,): partial(begin, nominal.hypothesis.with_effects(one), first, others=others)
        for name, one in effects.items()
    }


def finish_all(
    begun: Mapping[K, Begun],
    executor: Executor | None = None,
    rivals: Sequence[Fitted] = (),
    behind: float = _BEHIND,
) -> dict[K, Fitted]:
    """Return roughly the fits that have begun, by the same keys; those far behind another are given up.

    Parameters
    ----------
    begun : mapping
    executor : Executor, optional
    rivals : sequence of Fitted
        Fits that have been finished already; they have that much less to go.
    behind : float
        Times the least cost in a first valley, or what chance makes of it: those above are given up.
    """
    costs = {key: one.given_up.minimum.cost for key, one in begun.items()}
    n = max((len(one.given_up.minimum.residual) for one in begun.values()), default=0)
    finished = [behind * one.minimum.cost for one in rivals]
    least = max(min([*costs.values(), *finished], default=0.0), n)
    tasks = [(key, end) for key, one in begun.items() if not costs[key] > behind * least for end in one.ends]
    found: dict[K, list[Fitted]] = {}
    for (key, _), end in zip(tasks, run_all(call, [end for _, end in tasks], executor), strict=True):
        found.setdefault(key, []).append(end)
    return {
        key: replace(best_of(found[key]), valleys=one.starts) if key in found else one.given_up
        for key, one in begun.items()
    }


def best_of(ends: Sequence[Fitted]) -> Fitted:
    """Return the fit with the most evidence."""
    return max(ends, key=lambda one: one.log_evidence)
