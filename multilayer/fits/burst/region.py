"""Mean and standard deviation over a region of solutions, explored on purpose from its inside out.

Knows a gauge and parameters only: a solution belongs to the region where the gauge is at most 1.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.legendre import leggauss

from multilayer.arrays import BoolArray, RealArray

_RAYS, _STEPS, _REACH, _WIDENINGS = 36, 12, 1.6, 3


@dataclass(frozen=True)
class Region:
    """A region about a solution, by its outline.

    Attributes
    ----------
    centre : array, shape (2,)
    outline : array, shape (n_rays, 2)
        Where the gauge reaches 1, or a bound is met, along rays from the centre.
    """

    centre: RealArray
    outline: RealArray

    def moments(self, function: Callable[[RealArray], RealArray]) -> tuple[RealArray, RealArray]:
        """Return mean and standard deviation, over the region's area, of a function of the parameters.

        Parameters
        ----------
        function : callable
            Maps parameters of shape (..., 2) to values of shape (..., n).
        """
        nodes, weights = leggauss(6)
        radius = 0.5 * (1 + nodes)
        arms = self.outline - self.centre
        points = self.centre + radius[:, None, None] * arms
        following = np.roll(arms, -1, axis=0)
        triangle = np.abs(arms[:, 0] * following[:, 1] - arms[:, 1] * following[:, 0])
        sector = 0.5 * (triangle + np.roll(triangle, 1))
        weight = (weights * radius)[:, None] * sector
        total = weight.sum()
        values = function(points)
        if total <= 0:  # no area: the region is the centre alone
            return function(self.centre), np.zeros_like(function(self.centre))
        mean = np.tensordot(weight, values, axes=2) / total
        variance = np.tensordot(weight, (values - mean) ** 2, axes=2) / total
        return mean, np.sqrt(variance)


def explore(
    gauge: Callable[[RealArray], RealArray],
    centre: RealArray,
    shape: RealArray,
    low: RealArray,
    high: RealArray,
) -> Region:
    """Return the part of ``gauge <= 1`` that is seen from `centre`.

    Parameters
    ----------
    gauge : callable
        Maps parameters of shape (..., 2) to numbers of shape (...); evaluated on all rays at once.
    centre : array, shape (2,)
    shape : array, shape (2, 2)
        Guess of the region: ``centre + shape @ u`` with u on the unit circle should lie near its outline. The search
        widens itself where the guess is too small.
    low, high : array, shape (2,)
        Bounds of the parameters.
    """
    angle = 2 * np.pi * np.arange(_RAYS) / _RAYS
    circle = np.round(np.stack([np.cos(angle), np.sin(angle)], axis=-1), 15)  # cos(pi/2) is 0
    rays = circle @ shape.T
    wall = _distance_to_bounds(centre, rays, low, high)
    reach = _REACH
    for _ in range(_WIDENINGS):
        radii = np.linspace(0, 1, _STEPS + 1) * np.minimum(reach, wall)[:, None]
        values = gauge(centre + radii[..., None] * rays[:, None])
        values[:, 0] = np.minimum(values[:, 0], 1)  # the centre belongs to the region
        crossing, open_end = _first_crossing(radii, values)
        if not np.any(open_end & (reach < wall)):
            break
        reach *= 4
    return Region(centre, centre + crossing[:, None] * rays)


def _distance_to_bounds(centre: RealArray, rays: RealArray, low: RealArray, high: RealArray) -> RealArray:
    with np.errstate(divide="ignore", invalid="ignore"):  # a ray along an axis never meets the other bounds
        to_low = np.where(rays < 0, (low - centre) / rays, np.inf)
        to_high = np.where(rays > 0, (high - centre) / rays, np.inf)
    return np.asarray(np.maximum(np.minimum(to_low, to_high).min(axis=-1), 0))


def _first_crossing(radii: RealArray, values: RealArray) -> tuple[RealArray, BoolArray]:
    """Return the radius where the gauge first passes 1 on each ray (interpolated), and which rays never do."""
    outside = ~(values <= 1)
    open_end = np.asarray(~outside.any(axis=1))
    after = np.where(open_end, values.shape[1] - 1, np.argmax(outside, axis=1))
    before = np.maximum(after - 1, 0)
    rows = np.arange(len(values))
    low, high = values[rows, before], values[rows, after]
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(open_end | ~np.isfinite(high) | (high <= low), 1.0, (1 - low) / (high - low))
    share = np.where(np.isfinite(high), np.clip(share, 0, 1), 0.0)
    return radii[rows, before] + share * (radii[rows, after] - radii[rows, before]), open_end
