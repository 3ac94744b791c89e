"""Finding every minimum of a small least-squares problem: a coarse grid, then refinement from each of its valleys.

Knows residuals and parameters only.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.optimize import least_squares

from multilayer.arrays import RealArray

ResidualAndJacobian = Callable[[RealArray], tuple[RealArray, RealArray]]


@dataclass(frozen=True)
class Minimum:
    """A local minimum.

    Attributes
    ----------
    x : array
        Parameters.
    misfit : float
        Norm of the residual there.
    at_bound : bool
        Whether a parameter lies on its bound.
    history : list of (array, float)
        Parameters and misfit at every evaluation on the way.
    """

    x: RealArray
    misfit: float
    at_bound: bool
    history: list[tuple[RealArray, float]] = field(repr=False, default_factory=list)


def valleys(values: RealArray, axes: tuple[RealArray, ...], most: int) -> list[RealArray]:
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


def refine(
    function: ResidualAndJacobian,
    start: RealArray,
    low: RealArray,
    high: RealArray,
    scale: RealArray,
    max_evaluations: int = 60,
    before: Sequence[tuple[RealArray, float]] = (),
) -> Minimum:
    """Return the minimum reached from `start` by a trust-region method within bounds.

    Parameters
    ----------
    function : callable
        Residual vector and its Jacobian at a point.
    start, low, high : array
    scale : array
        A sensible step of each parameter.
    max_evaluations : int
        Stop after so many evaluations.
    before : sequence
        History that led to `start`, to be continued.
    """
    history = list(before)
    latest: dict[bytes, tuple[RealArray, RealArray]] = {}

    def evaluate(x: RealArray) -> tuple[RealArray, RealArray]:
        key = np.asarray(x, dtype=float).tobytes()
        if key not in latest:
            latest.clear()
            latest[key] = function(x)
            history.append((np.array(x), float(np.linalg.norm(latest[key][0]))))
        return latest[key]

    def residual(x: RealArray) -> RealArray:
        return evaluate(x)[0]

    def jacobian(x: RealArray) -> RealArray:
        return evaluate(x)[1]

    margin = 1e-9 * (high - low)
    found = least_squares(
        residual,
        np.clip(start, low + margin, high - margin),
        jac=jacobian,
        bounds=(low, high),
        x_scale=scale,
        xtol=1e-8,
        ftol=1e-9,
        gtol=1e-15,  # of a product of two numbers that are both small where the data hardly depend on the unknowns
        max_nfev=max_evaluations,
    )
    on_bound = bool(np.any((found.x - low < 1e-6 * (high - low)) | (high - found.x < 1e-6 * (high - low))))
    return Minimum(found.x, float(np.sqrt(2 * found.cost)), on_bound, history)


def distinct(minima: list[Minimum], apart: RealArray) -> list[Minimum]:
    """Return the minima, lowest first, dropping those within `apart` (per parameter) of a lower one."""
    kept: list[Minimum] = []
    for minimum in sorted(minima, key=lambda m: m.misfit):
        if all(np.any(np.abs(minimum.x - other.x) > apart) for other in kept):
            kept.append(minimum)
    return kept
