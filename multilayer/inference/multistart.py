"""Valleys of a problem: where descents from many starts lead, before some of them are followed to the floor."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.least_squares import descend, in_pieces, total_cost

Residual = Callable[[RealArray], RealArray]
_STAGES = ((20, 10), (12, 10), (6, 10), (4, 10))  # descents that go on, and their steps, as the discrepancy falls
_AHEAD = 10  # steps in which all but an effect's parameters move, before these do
_TYPICAL, _LARGEST, _FALL = 0.004, 0.3, 6.0  # relative: a standard deviation of the data; of discrepancies; by steps of
_FAR = 4.0  # times the misfit that chance makes: of what is far off, and of valleys far behind the best one
# what tells descents apart: rms of what residuals differ by, or coordinates of the effect's parameters
_APART, _OTHER = 0.5, 0.3


class Rough(Protocol):
    """A problem whose residuals are also known roughly."""

    def roughly(self, size: float) -> Residual:
        """Return residuals for a first search, each datum being allowed to be off by `size` more, relative."""


def valleys(problem: Rough, bases: RealArray, extra: RealArray) -> RealArray:
    """Return where the data can be explained roughly: coordinates, the best first.

    What a model leaves out may bury the data: of another resonance it makes one of its parameters', and from there no
    descent leads back. And what is thousands of standard deviations off drags everything else along. So many starts go
    down at once, by continuation: each datum may be off by some more, much at first. Before that extra parameters are
    held while the others follow: where these were without them, a good value may cost as much as a bad one.

    Parameters
    ----------
    problem : Rough
    bases : array, shape (m, n)
        Starts of the parameters but the extra ones.
    extra : array, shape (p, k)
        Starts of the latter; each goes with each of the others.

    Returns
    -------
    array, shape (v, n + k)
        Empty where there is no response anywhere.
    """
    n, k = bases.shape[1], extra.shape[1]
    points = np.concatenate([np.repeat(bases, len(extra), axis=0), np.tile(extra, (len(bases), 1))], axis=1)
    sizes = discrepancies(float(np.min(costs_per_datum(problem.roughly(0.0), points))))
    residual = problem.roughly(sizes[0])
    costs = costs_per_datum(residual, points).reshape(len(bases), len(extra))
    points = points[_promising(costs, _STAGES[0][0])]
    if k:
        points, _ = descend(residual, points, _AHEAD, moving=n)
    for size, (kept, steps) in zip(sizes, _STAGES, strict=False):
        residual = problem.roughly(size)
        points = _distinct(residual, k, *descend(residual, points[:kept], steps))
    misfits = costs_per_datum(problem.roughly(_TYPICAL), points)
    return points[misfits <= _FAR * max(np.min(misfits, initial=np.inf), 1.0)]


def is_far_off(misfit: float) -> bool:
    """Tell whether a misfit per datum is much larger than chance makes it."""
    return not misfit <= _FAR


def costs_per_datum(residual: Residual, points: RealArray) -> RealArray:
    """Return misfits with the priors' share, per datum, infinite where there is no response."""
    values = in_pieces(residual, points)
    return np.asarray(total_cost(values, points) / values.shape[-1])


def discrepancies(per_datum: float) -> tuple[float, ...]:
    """Return relative sizes of a discrepancy that is allowed, falling; of what is near none."""
    if not is_far_off(per_datum):
        return (0.0,)
    first = min(_TYPICAL * float(np.sqrt(per_datum)), _LARGEST)
    falls = int(np.ceil(np.log(first / _TYPICAL) / np.log(_FALL)))
    return tuple(np.geomspace(first, _TYPICAL, min(max(2, falls), len(_STAGES))))


def _promising(costs: RealArray, most: int) -> list[int]:
    """Return flat indices of a table (m, k) of costs: all, or the best of rows and of columns, no two of the same."""
    if costs.size <= most:
        return [*range(costs.size)]
    k = costs.shape[1]
    rows = [int(i) * k + int(np.argmin(costs[i])) for i in np.argsort(costs.min(axis=1), kind="stable")]
    columns = [int(np.argmin(costs[:, j])) * k + int(j) for j in np.argsort(costs.min(axis=0), kind="stable")]
    return list(dict.fromkeys([*rows[: most - most // 3], *columns[: most // 3]]))


def _distinct(residual: Residual, k: int, points: RealArray, costs: RealArray) -> RealArray:
    """Return the points that differ in what they say of the data or in the last k coordinates, the best first."""
    values = residual(points)
    kept: list[int] = []
    for i in np.argsort(costs, kind="stable"):
        last = [np.max(np.abs(points[i] - points[j])[points.shape[1] - k :], initial=0.0) for j in kept]
        off = [np.mean((values[i] - values[j]) ** 2) for j in kept]
        if np.isfinite(costs[i]) and all(a > _OTHER or b > _APART**2 for a, b in zip(last, off, strict=True)):
            kept.append(int(i))
    return points[kept]


def lowest_on_grid(values: RealArray, axes: tuple[RealArray, ...], most: int) -> list[RealArray]:
    """Return the grid points lower than all their neighbours, lowest first, at most `most`.

    Parameters
    ----------
    values : array, shape (len(axes[0]), ...)
    axes : tuple of array
        Coordinates along each axis of `values`.
    """
    from scipy.ndimage import minimum_filter  # here, for many a command does without, and starts sooner

    lowest = values == minimum_filter(values, size=3, mode="nearest")
    points = np.argwhere(lowest)
    order = np.argsort(values[lowest])[:most]
    return [np.array([axis[i] for axis, i in zip(axes, points[k], strict=True)]) for k in order]
