"""The search itself: descents with gradients within a variant, and a global search over choices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import IndexArray, RealArray
from multilayer.errors import MultilayerError
from multilayer.optimisation.aims import Aim, Catalogue, Figures
from multilayer.optimisation.design import Key, Space, Variant
from multilayer.optimisation.predict import TINY, Predictor
from multilayer.simulation.bands import Grid

KEPT = 1e-6  # by so little may a limit be missed, over its size, and count as kept
_STEP = 1e-6  # of differences, in coordinates from 0 to 1
FEW_FIELDS = 6  # of a variant: differences cost less than derivatives
_ROUNDS, _STEPS, _TOLERANCE = 3, 60, 1e-8  # of SLSQP, which is begun again where a kink stopped it
_MOST = 100  # designs of a round: at a kink, line searches lead nowhere
_GAIN = 1e-5  # of a round that another one is worth
_AUGMENTED = 1e-3  # share of the sum beside the largest: no design that is as good in one goal and worse in another
_FAR = 1e3  # merit of what keeps no limit; goals are near 1
_NO_RESPONSE = 1e6
_SPREAD = 16  # times as many designs are looked at for the limits of sizes
_POPULATION, _GENERATIONS = 48, 40
_NEAREST = 4  # a design has at most one of so many for neighbours
_FOUND = 6  # variants of a global search that are searched further


@dataclass(frozen=True)
class Scalar:
    """One number of several goals: the largest of their weighted distances from the best that each can be.

    The augmented Chebyshev norm: R. E. Steuer & E.-U. Choo, Math. Program. 26 (1983) 326-344. Unlike sums of weighted
    goals it reaches designs where the front is not convex.

    Attributes
    ----------
    weights : array, shape (n_goals,)
        At least 0; goals of weight 0 count in the sum alone.
    best, span : array, shape (n_goals,)
        The best value of each goal, and how far the others lie from it.
    """

    weights: RealArray
    best: RealArray
    span: RealArray

    @property
    def active(self) -> IndexArray:
        """Indices of the goals with a weight."""
        return np.flatnonzero(self.weights)

    def distances(self, goals: RealArray) -> RealArray:
        """Return distances from the best, in spans, of goals to be minimised, shape (..., n_goals)."""
        return np.asarray((goals - self.best) / self.span)

    def merit(self, goals: RealArray) -> RealArray:
        """Return what is to be minimised, shape (...)."""
        far = self.distances(goals)
        largest = np.max(self.weights[self.active] * far[..., self.active], axis=-1)  # 0 times infinity is no number
        return np.asarray(largest + self.rest(far))

    def rest(self, far: RealArray) -> RealArray:
        """Return the share of the sum."""
        return np.asarray(_AUGMENTED * np.sum(far, axis=-1) if len(self.weights) > 1 else np.zeros(far.shape[:-1]))


@dataclass(frozen=True)
class Point:
    """A design of a variant by its coordinates, its goals, and how far it keeps each limit; see `Problem.measure`."""

    x: RealArray
    goals: RealArray
    slack: RealArray


@dataclass(frozen=True)
class Problem:
    """Goals and limits over the designs of a space.

    Attributes
    ----------
    grid : Grid
    goals, bounds : tuple of Aim
    catalogue : mapping
    first : Variant
        Any of the space.
    margins : array, shape (n_bounds,)
        By how much more than a bound asks the search keeps it, over the bound's size.
    """

    grid: Grid
    goals: tuple[Aim, ...]
    bounds: tuple[Aim, ...]
    catalogue: Mapping[str, Catalogue]
    first: Variant
    margins: RealArray

    @cached_property
    def predictor(self) -> Predictor:
        """What computes the figures."""
        return Predictor(self.first, self.grid, self.catalogue, (*self.goals, *self.bounds))

    def measure(self, variant: Variant, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return goals, to be minimised, shape (n, n_goals), and how far each limit is kept, shape (n, n_limits).

        Infinite goals and limits missed by far stand for designs without a response.
        """
        goals, slack = self._measured(self.predictor.figures(variant, x))
        return np.nan_to_num(goals, nan=np.inf), np.nan_to_num(slack, nan=-1.0, neginf=-1.0)

    def _measured(self, figures: Figures) -> tuple[NDArray[Any], NDArray[Any]]:
        goals = np.concatenate([-aim.sign * aim.values(figures) for aim in self.goals], axis=1)
        kept = [aim.slack(aim.values(figures)) - margin for aim, margin in zip(self.bounds, self.margins, strict=True)]
        slack = np.concatenate([np.zeros((len(goals), 0)), *kept], axis=1)
        return goals, slack

    def slopes(self, variant: Variant, here: Point) -> tuple[RealArray, RealArray]:
        """Return derivatives by the coordinates of goals and of what keeps the limits, as `measure` has them.

        Of many fields they are exact (`Predictor.stepped`), of few, and where there is no response, differences.

        Parameters
        ----------
        variant : Variant
        here : Point

        Returns
        -------
        tuple of array
            Of shape (n_ranges, n_goals) and (n_ranges, n_limits), not finite where a figure is not.
        """
        if len(here.x) > FEW_FIELDS and np.all(np.isfinite(here.goals)):
            with suppress(MultilayerError, ArithmeticError), np.errstate(all="ignore"):
                goals, slack = self._measured(self.predictor.stepped(variant, here.x))
                return goals.imag / TINY, slack.imag / TINY
        return self.differences(variant, here)

    def differences(self, variant: Variant, here: Point) -> tuple[RealArray, RealArray]:
        """Return the same by differences, towards the middle of each field's range."""
        step = np.where(here.x > 0.5, -_STEP, _STEP)
        goals, slack = self.measure(variant, here.x + np.diag(step))
        with np.errstate(invalid="ignore"):
            return (goals - here.goals) / step[:, None], (slack - here.slack) / step[:, None]

    def oversized(self, variant: Variant, x: RealArray) -> RealArray:
        """Return the sum of what designs miss of the limits of sizes, without their spectra, shape (n,)."""
        figures = Figures({}, self.predictor.measures(variant, x))
        kept = [aim.slack(aim.values(figures)) for aim in self.bounds if not aim.quantity]
        return missed(np.concatenate([np.zeros((len(x), 0)), *kept], axis=1))


@dataclass(frozen=True)
class Candidate:
    """A design: choices by their key, coordinates of the fields between bounds, and what the search knows of it."""

    key: Key
    x: RealArray
    goals: RealArray
    missed: float

    @property
    def is_kept(self) -> bool:
        """Whether all limits are."""
        return self.missed <= KEPT


def missed(slack: RealArray) -> RealArray:
    """Return the sum of what is missed of the limits, shape (...)."""
    return np.asarray(np.sum(np.maximum(-slack, 0), axis=-1))


def ranked(scalar: Scalar, goals: RealArray, short: RealArray) -> RealArray:
    """Return merits in which every design that keeps the limits stands before all others."""
    merit = np.clip(scalar.merit(goals), -_FAR, _FAR)
    merit = np.where(np.isfinite(goals).all(axis=-1), merit, _NO_RESPONSE)
    return np.asarray(np.where(short > KEPT, 2 * _FAR + short + 1e-6 * merit, merit))


class StoppedError(KeyboardInterrupt):
    """Ctrl-C in a search, with what it has found so far."""

    def __init__(self, found: Sequence[Candidate]) -> None:
        super().__init__()
        self.found = [*found]


@dataclass(frozen=True)
class Screen:
    """Designs of a variant spread evenly over its fields, of those that keep the limits of sizes if there are any."""

    problem: Problem
    variant: Variant
    points: int
    seed: int

    def __call__(self) -> list[Candidate]:
        """Return all of them, the one in the file first."""
        from scipy.stats.qmc import Sobol

        n = len(self.variant.ranges)
        x = self.variant.written[None]
        if n:
            spread = Sobol(n, rng=np.random.default_rng(self.seed)).random(_SPREAD * self.points)
            nearest = np.argsort(self.problem.oversized(self.variant, spread), kind="stable")
            x = np.concatenate([x, spread[nearest[: self.points]]])
        goals, slack = self.problem.measure(self.variant, x)
        return [Candidate(self.variant.key, *row) for row in zip(x, goals, missed(slack).tolist(), strict=True)]


@dataclass(frozen=True)
class Descent:
    """A descent from one design by sequential quadratic programming, within its variant."""

    problem: Problem
    variant: Variant
    scalar: Scalar
    start: RealArray

    def __call__(self) -> list[Candidate]:
        """Return the best design on the way."""
        walk = _Walk(self.problem, self.variant, self.scalar)
        try:
            return [self._end(walk.best_from(self.start))]
        except KeyboardInterrupt:
            raise StoppedError([self._end(walk.best())] if walk.visited else []) from None

    def _end(self, best: Point) -> Candidate:
        return Candidate(self.variant.key, best.x, best.goals, float(missed(best.slack)))


class _StuckError(Exception):
    """A round has taken too many designs."""


class _Walk:
    """Values and slopes along a descent, each computed once."""

    def __init__(self, problem: Problem, variant: Variant, scalar: Scalar) -> None:
        self.problem, self.variant, self.scalar = problem, variant, scalar
        self.visited: dict[bytes, Point] = {}
        self.slopes: dict[bytes, tuple[RealArray, RealArray]] = {}
        self.most = _MOST

    def at(self, x: RealArray) -> Point:
        """Return goals and limits at a point."""
        x = np.clip(x, 0, 1)
        key = x.tobytes()
        if key not in self.visited:
            if len(self.visited) >= self.most:
                raise _StuckError
            goals, slack = self.problem.measure(self.variant, x[None])
            self.visited[key] = Point(x, goals[0], slack[0])
        return self.visited[key]

    def slope(self, x: RealArray) -> tuple[RealArray, RealArray]:
        """Return derivatives of the distances of the goals, and of the limits, by the coordinates."""
        here = self.at(x)
        if (key := here.x.tobytes()) not in self.slopes:
            of_goals, of_slack = self.problem.slopes(self.variant, here)
            scaled = of_goals / self.scalar.span
            self.slopes[key] = (
                np.nan_to_num(scaled, posinf=0, neginf=0).T,
                np.nan_to_num(of_slack, posinf=0, neginf=0).T,
            )
        return self.slopes[key]

    def far(self, x: RealArray) -> RealArray:
        """Return the distances of the goals, large and finite where there is no response."""
        return np.clip(self.scalar.distances(self.at(x).goals), -_FAR, _FAR)

    def best(self) -> Point:
        """Return the best point that was visited."""
        points = [*self.visited.values()]
        goals, slack = np.array([p.goals for p in points]), np.array([p.slack for p in points])
        return points[int(np.argmin(ranked(self.scalar, goals, missed(slack))))]

    def best_from(self, start: RealArray) -> Point:
        """Return the best point of descents, each from where the last one ended."""
        self.at(start)
        if not len(start):
            return self.best()
        before = np.inf
        for _ in range(_ROUNDS):
            self.most = len(self.visited) + _MOST
            with suppress(_StuckError):
                self.round(self.best().x)
            now = self.best()
            value = float(ranked(self.scalar, now.goals[None], missed(now.slack)[None])[0])
            if not value < before - _GAIN:
                break
            before = value
        return self.best()

    def round(self, start: RealArray) -> None:
        """Descend once; with several goals, t above all weighted distances is the last variable."""
        from scipy.optimize import minimize

        n, active, weights = len(start), self.scalar.active, self.scalar.weights
        several = len(active) > 1
        share = _AUGMENTED if len(weights) > 1 else 0.0

        def cost(z: RealArray) -> float:
            far = self.far(z[:n])
            largest = z[n] if several else float(weights[active[0]] * far[active[0]])
            return float(largest + self.scalar.rest(far))

        def cost_slope(z: RealArray) -> RealArray:
            of_goals, _ = self.slope(z[:n])
            slope = share * np.sum(of_goals, axis=0)
            return np.append(slope, 1.0) if several else slope + weights[active[0]] * of_goals[active[0]]

        def kept(z: RealArray) -> RealArray:
            above = z[n] - weights[active] * self.far(z[:n])[active] if several else np.zeros(0)
            return np.concatenate([self.at(z[:n]).slack, above])

        def kept_slope(z: RealArray) -> RealArray:
            of_goals, of_slack = self.slope(z[:n])
            if not several:
                return of_slack
            above = -weights[active, None] * of_goals[active]
            return np.block([[of_slack, np.zeros((len(of_slack), 1))], [above, np.ones((len(active), 1))]])

        z, box = start, [(0.0, 1.0)] * n
        if several:
            z, box = np.append(start, np.max(weights[active] * self.far(start)[active])), [*box, (-_FAR, _FAR)]
        limits: Any = [{"type": "ineq", "fun": kept, "jac": kept_slope}] if len(kept(z)) else []
        options: Any = {"maxiter": _STEPS, "ftol": _TOLERANCE}
        with np.errstate(all="ignore"):
            minimize(cost, z, jac=cost_slope, method="SLSQP", bounds=box, constraints=limits, options=options)


@dataclass(frozen=True)
class GlobalSearch:
    """Differential evolution over choices and fields together, where there are too many variants to go through."""

    problem: Problem
    space: Space
    scalar: Scalar
    seed: int
    best: dict[Key, Candidate] = field(default_factory=dict, compare=False)

    def __call__(self) -> list[Candidate]:
        """Return the best design of each of the best variants, and choices not allowed together, without goals."""
        try:
            self._evolve()
        except KeyboardInterrupt:
            raise StoppedError(self._found) from None
        return self._found

    @property
    def _found(self) -> list[Candidate]:
        refused = [one for one in self.best.values() if self.space.allowed(one.key) is None]
        allowed = [one for one in self.best.values() if self.space.allowed(one.key) is not None]
        return [*sorted(allowed, key=self._rank)[:_FOUND], *refused]

    def _evolve(self) -> None:
        from scipy.optimize import differential_evolution

        axes, ranges = self.space.axes, self.space.ranges
        box: Any = [*((0, n - 1) for n in axes), *((0.0, 1.0) for _ in ranges)]
        free = [i for i, (low, high) in enumerate(box) if high > low]  # a choice of one is none

        def merits(vectors: Any) -> Any:
            rows = np.zeros((vectors.shape[1], len(box)))
            rows[:, free] = vectors.T
            return self._merits(rows)

        bounds: Any = [box[i] for i in free]
        differential_evolution(
            merits, bounds, integrality=[i < len(axes) for i in free], vectorized=True,
            updating="deferred", polish=False, maxiter=_GENERATIONS, popsize=max(2, _POPULATION // len(free)),
            rng=np.random.default_rng(self.seed), tol=1e-3, init="sobol",
        )  # fmt: skip

    def _rank(self, one: Candidate) -> float:
        return float(ranked(self.scalar, one.goals[None], np.array([one.missed]))[0])

    def _merits(self, rows: RealArray) -> RealArray:
        """Return merits of rows of choices and coordinates; those of one variant are computed at once."""
        n = len(self.space.axes)
        keys = [tuple(round(i) for i in row[:n].tolist()) for row in rows]
        merits = np.zeros(len(rows))
        columns = {item.name: n + i for i, item in enumerate(self.space.ranges)}
        for key in dict.fromkeys(keys):
            which = [i for i, other in enumerate(keys) if other == key]
            variant = self.space.allowed(key)
            if variant is None:
                self.best[key] = Candidate(key, np.zeros(0), np.full(len(self.problem.goals), np.inf), np.inf)
                merits[which] = _NO_RESPONSE
                continue
            if not variant.ranges and key in self.best:
                merits[which] = self._rank(self.best[key])
                continue
            x = rows[np.ix_(which, [columns[item.name] for item in variant.ranges])]
            goals, slack = self.problem.measure(variant, x)
            short = missed(slack)
            merits[which] = ranked(self.scalar, goals, short)
            i = int(np.argmin(merits[which]))
            candidate = Candidate(key, x[i], goals[i], float(short[i]))
            if key not in self.best or merits[which][i] < self._rank(self.best[key]):
                self.best[key] = candidate
        return merits


def in_order(candidates: Sequence[Candidate], scalar: Scalar) -> list[Candidate]:
    """Return designs, the best first."""
    if not candidates:
        return []
    goals, short = np.array([one.goals for one in candidates]), np.array([one.missed for one in candidates])
    return [candidates[int(i)] for i in np.argsort(ranked(scalar, goals, short), kind="stable")]


def valleys(candidates: Sequence[Candidate], scalar: Scalar) -> list[Candidate]:
    """Return designs that are better than all that lie nearest to them, the best first.

    Starts of descents into different valleys, however small beside the best: A. Toern & S. Viitanen, J. Glob. Optim. 5
    (1994) 267-276. Of each variant by itself; the nearest are twice as many as it has fields, and a quarter of its
    designs at most.
    """
    of_variants: dict[Key, list[Candidate]] = {}
    for one in in_order(candidates, scalar):
        of_variants.setdefault(one.key, []).append(one)
    lowest = {id(one) for ordered in of_variants.values() for one in _lowest(ordered)}
    return [one for one in in_order(candidates, scalar) if id(one) in lowest]


def _lowest(ordered: Sequence[Candidate]) -> Iterator[Candidate]:
    """Give the local minima of designs of one variant that stand in order, the best first."""
    x = np.array([one.x for one in ordered])
    count = min(2 * x.shape[1] + 1, len(x) // _NEAREST)
    for i, one in enumerate(ordered):
        nearest = np.argsort(np.max(np.abs(x - x[i]), axis=-1, initial=0.0), kind="stable")[: count + 1]
        if nearest.min() >= i:
            yield one


def apart(
    candidates: Sequence[Candidate], scalar: Scalar, distance: float = 0.1, first: Sequence[Candidate] = ()
) -> Iterator[Candidate]:
    """Give designs that are not near each other, `first` some and then the best: of other variants, or coordinates."""
    chosen: list[Candidate] = []
    for one in [*first, *in_order(candidates, scalar)]:
        if all(one.key != other.key or np.max(np.abs(one.x - other.x), initial=0.0) > distance for other in chosen):
            chosen.append(one)
            yield one


def lattice(n_goals: int, most: int) -> list[Any]:
    """Return at most so many weights that sum to 1, spread evenly, none of them 0.

    A lattice on the simplex: I. Das & J. E. Dennis, SIAM J. Optim. 8 (1998) 631-657.
    """
    parts = next(p for p in range(n_goals, 1000) if _compositions(p + 1, n_goals) > most)
    return [np.array(one) / parts for one in _sums(parts, n_goals)]


def _compositions(parts: int, n: int) -> int:
    return len(_sums(parts, n))


def _sums(total: int, n: int) -> list[tuple[int, ...]]:
    if n == 1:
        return [(total,)]
    return [(first, *rest) for first in range(1, total - n + 2) for rest in _sums(total - first, n - 1)]
