"""Multistart search by continuation: which valleys of a problem descents from many starts lead to.

With a tolerance of the data that is large at first and falls (continuation, graduated optimisation: E. L. Allgower & K.
Georg, Numerical Continuation Methods, Springer 1990). `least_squares.minimise` then finds the lowest points.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.least_squares import descend, in_batches, total_cost

Residual = Callable[[RealArray], RealArray]
_STAGES = ((20, 10), (12, 10), (6, 10), (4, 10))  # descents that go on, and their steps, as the tolerance falls
_AHEAD = 10  # steps in which all but the extra parameters move, before these do
# relative: a standard deviation of the data; the largest tolerance; the factor by which the tolerance falls
_TYPICAL, _LARGEST, _FALL = 0.004, 0.3, 6.0
_FAR = 4.0  # times the misfit that chance gives: far off, and valleys far behind the best
# descents differ by more than this: rms difference of residuals, or difference of an extra parameter's coordinate
_APART, _OTHER = 0.5, 0.3


class Inflatable(Protocol):
    """A problem whose residuals can be weighed with enlarged errors."""

    def inflated_residual(self, size: float) -> Residual:
        """Return residuals for a first search: every datum has an additional relative error of `size`."""


def valleys(problem: Inflatable, bases: RealArray, extra: RealArray) -> RealArray:
    """Return points in the valleys in which the data are explained roughly: coordinates, the best first.

    Far from a solution the cost has a valley for every resonance that the model may mistake for another, from which no
    descent leads back; and data that are thousands of standard deviations off dominate all others. Therefore many
    starts descend together, with an additional error of all data that is large at first and then falls. Before that the
    extra parameters are held while the others follow: at the others' old values a good value of an extra parameter may
    cost as much as a bad one.

    Parameters
    ----------
    problem : Inflatable
    bases : array, shape (m, n)
        Starts of all parameters but the extra ones.
    extra : array, shape (p, k)
        Starts of the extra parameters; each is combined with each of the others.

    Returns
    -------
    array, shape (v, n + k)
        Empty where there is no response anywhere.
    """
    n, k = bases.shape[1], extra.shape[1]
    points = np.concatenate([np.repeat(bases, len(extra), axis=0), np.tile(extra, (len(bases), 1))], axis=1)
    sizes = continuation_sizes(float(np.min(costs_per_datum(problem.inflated_residual(0.0), points))))
    residual = problem.inflated_residual(sizes[0])
    costs = costs_per_datum(residual, points).reshape(len(bases), len(extra))
    points = points[_promising(costs, _STAGES[0][0])]
    if k and n:
        points, _ = descend(residual, points, _AHEAD, moving=n)
    for size, (count, steps) in zip(sizes, _STAGES, strict=False):
        residual = problem.inflated_residual(size)
        points = _distinct(residual, k, *descend(residual, points[:count], steps))
        if not len(points):
            return points
    misfits = costs_per_datum(problem.inflated_residual(_TYPICAL), points)
    return points[misfits <= _FAR * max(np.min(misfits, initial=np.inf), 1.0)]


def is_far_off(misfit: float) -> bool:
    """Tell whether a misfit per datum is more than four times what chance gives."""
    return not misfit <= _FAR


def costs_per_datum(residual: Residual, points: RealArray) -> RealArray:
    """Return costs (misfit and priors) over the number of data; infinite where there is no response."""
    values = in_batches(residual, points)
    return np.asarray(total_cost(values, points) / values.shape[-1])


def continuation_sizes(per_datum: float) -> tuple[float, ...]:
    """Return falling relative errors for the continuation from a cost per datum; 0 alone where this is not far off."""
    if not is_far_off(per_datum):
        return (0.0,)
    first = min(_TYPICAL * float(np.sqrt(per_datum)), _LARGEST)
    falls = int(np.ceil(np.log(first / _TYPICAL) / np.log(_FALL)))
    return tuple(np.geomspace(first, _TYPICAL, min(max(2, falls), len(_STAGES))))


def _promising(costs: RealArray, most: int) -> list[int]:
    """Return flat indices of a table (m, k) of costs: all, or those of the best rows and columns, each once."""
    if costs.size <= most:
        return [*range(costs.size)]
    k = costs.shape[1]
    rows = [int(i) * k + int(np.argmin(costs[i])) for i in np.argsort(costs.min(axis=1), kind="stable")]
    columns = [int(np.argmin(costs[:, j])) * k + int(j) for j in np.argsort(costs.min(axis=0), kind="stable")]
    return list(dict.fromkeys([*rows[: most - most // 3], *columns[: most // 3]]))


def _distinct(residual: Residual, k: int, points: RealArray, costs: RealArray) -> RealArray:
    """Return the points that differ in their residuals or in the last k coordinates, the best first."""
    values = residual(points)
    kept: list[int] = []
    for i in np.argsort(costs, kind="stable"):
        extra = [np.max(np.abs(points[i] - points[j])[points.shape[1] - k :], initial=0.0) for j in kept]
        misfit = [np.mean((values[i] - values[j]) ** 2) for j in kept]
        if np.isfinite(costs[i]) and all(a > _OTHER or b > _APART**2 for a, b in zip(extra, misfit, strict=True)):
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
    from scipy.ndimage import minimum_filter  # here, since many commands do not need it and start sooner

    lowest = values == minimum_filter(values, size=3, mode="nearest")
    points = np.argwhere(lowest)
    order = np.argsort(values[lowest])[:most]
    return [np.array([axis[i] for axis, i in zip(axes, points[k], strict=True)]) for k in order]
