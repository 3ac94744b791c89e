"""Most probable parameters: least squares from many starts, and the distinct minima they end in."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import Literal

import numpy as np
from scipy.optimize import least_squares
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.executors import run_all
from multilayer.inverse.problem import Minimum, Problem

_CANDIDATES = 128  # points of the prior that are looked at
_CHUNK = 32
_MOST = 200  # evaluations from one start
_ALIKE = 0.1  # standard deviations: minima nearer than this are one
TIGHT = 1e-8
_HOPELESS = 4.0


def minimise(
    problem: Problem,
    start: RealArray,
    most: int = _MOST,
    tolerance: float = TIGHT,
    method: Literal["trf", "dogbox"] = "trf",
    *,
    scaled: bool = False,
) -> Minimum:
    """Return the minimum reached from a start by a trust-region method with a Jacobian of one batched solve each.

    Parameters
    ----------
    problem : Problem
    start : array, shape (n,)
    most : int
        Evaluations after which it stops where it is.
    tolerance : float
        Relative change of the cost at which it has arrived.
    method : {'trf', 'dogbox'}
        Of `scipy.optimize.least_squares`; the second takes fewer steps along curved valleys, and tells less exactly
        where it has arrived.
    scaled : bool
        Measure steps by what they change in the residuals, not in standard deviations of the prior: where some
        coordinates matter a thousand times as much as others, as with sharp resonances.
    """
    n = start.size
    last: dict[bytes, tuple[RealArray, RealArray]] = {}

    def both(z: RealArray) -> tuple[RealArray, RealArray]:
        key = z.tobytes()
        if key not in last:
            last.clear()
            last[key] = problem.linearised(z)
        return last[key]

    def residual(z: RealArray) -> RealArray:  # most are followed by their derivative, which then has cost one batch
        return np.concatenate([both(z)[0], z])

    def derivative(z: RealArray) -> RealArray:
        return np.concatenate([both(z)[1], np.eye(n)])

    found = least_squares(
        residual, start, jac=derivative, method=method, x_scale="jac" if scaled else 1.0, max_nfev=most,
        ftol=tolerance, xtol=1e-6, gtol=1e-6,
    )  # fmt: skip
    values, slopes = both(found.x)
    return Minimum(found.x, float(values @ values), values, slopes, bool(found.success))


def search(
    problem: Problem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = 6,
    n_candidates: int = _CANDIDATES,
    seed: int = 0,
    few: int = _MOST,
    tolerance: float = TIGHT,
    tell: Callable[[str], None] | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima of a problem, the most probable first.

    Parameters
    ----------
    problem : Problem
    starts : sequence of array, shape (n,)
        Points to follow besides the best of those drawn from the prior.
    n_best : int
        How many of these are followed.
    n_candidates : int
        How many are drawn; a power of two fills the prior evenly.
    seed : int
    few : int
        Evaluations after which a start is given up that is not `hopeful` beside the best one so far: most of those
        that need more creep along the floor of a wrong valley.
    tolerance : float
        See `minimise`.
    tell : callable, optional
        Called with a short text after each start.
    executor : Executor, optional
        Where the starts are followed; in this process when left out.
    """
    n = len(problem.parameters)
    points = draw_prior(n, n_candidates, seed)
    costs = np.concatenate([_cost(problem, points[i : i + _CHUNK]) for i in range(0, len(points), _CHUNK)])
    chosen = [*starts, *points[np.argsort(costs, kind="stable")[:n_best]]]
    ends = run_all(
        partial(minimise, problem, most=few, tolerance=tolerance),
        [np.asarray(start, dtype=float) for start in chosen],
        executor,
        lambda index: None if tell is None else tell(f"start {index + 1} of {len(chosen)}"),
    )
    minima: list[Minimum] = []
    for found in ends:
        is_done = found.converged or few >= _MOST or not hopeful(found, minima)
        minima.append(found if is_done else minimise(problem, found.z, tolerance=tolerance))
    return distinct(minima)


def hopeful(minimum: Minimum, others: Sequence[Minimum]) -> bool:
    """Tell whether the cost is within four times the least of the others, or what noise makes of that."""
    least = min((other.cost for other in others), default=np.inf)
    return bool(minimum.cost <= _HOPELESS * max(least, minimum.residual.size))


def draw_prior(n: int, count: int, seed: int) -> RealArray:
    """Return quasi-random points of the prior, shape (count, n), the first of them its centre."""
    from scipy.stats import qmc  # here, for it takes as long to import as all the rest of scipy

    points = ndtri(np.clip(qmc.Sobol(n, rng=np.random.default_rng(seed)).random(count), 1e-9, 1 - 1e-9))
    points[0] = 0.0
    return np.asarray(points)


def _cost(problem: Problem, z: RealArray) -> RealArray:
    values = problem.residual(z)
    cost = np.sum(values**2, axis=-1) + np.sum(z**2, axis=-1)
    return np.asarray(np.where(np.isfinite(cost), cost, np.inf))


def distinct(minima: Sequence[Minimum]) -> list[Minimum]:
    """Return one minimum of every group nearer than a tenth of a standard deviation, the lowest cost first."""
    kept: list[Minimum] = []
    for minimum in sorted((m for m in minima if np.isfinite(m.cost)), key=lambda m: m.cost):
        apart = (minimum.z - other.z for other in kept)
        if all(
            np.sqrt(d @ other.precision @ d) > _ALIKE * np.sqrt(d.size) for d, other in zip(apart, kept, strict=True)
        ):
            kept.append(minimum)
    return kept
