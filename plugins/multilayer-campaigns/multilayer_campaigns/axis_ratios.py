"""A modulus along each of three axes over the mean of the three."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.inference.consistency import ALIKE, Verdict, generalised_least_squares, p_value, verdict_of

AXES = ("x", "y", "z")
LEVEL = 0.95  # of intervals
Interval: TypeAlias = tuple[float, float, float]
"""A value and the ends of its interval."""
_SIGMAS = float(ndtri(0.5 + LEVEL / 2))
_FREE = len(AXES) - 1  # numbers that say all of three distances from their mean


@dataclass(frozen=True)
class AxisRatios:
    """A modulus along each axis over the geometric mean of the three, as logarithms.

    Attributes
    ----------
    frequency : array, shape (n,)
        Hz.
    each : array, shape (n, 3)
        At each frequency by itself.
    each_std : array, shape (n, 3)
    shared : array, shape (3,)
        Of all frequencies together.
    shared_std : array, shape (3,)
    p_shared : float
        Probability of ratios as different from frequency to frequency as these if they are one.
    p_isotropic : float
        Probability of ratios as far from 1 as these if the material is isotropic.
    """

    frequency: RealArray
    each: RealArray
    each_std: RealArray
    shared: RealArray
    shared_std: RealArray
    p_shared: float
    p_isotropic: float

    @classmethod
    def of(cls, frequency: RealArray, values: RealArray, covariance: RealArray) -> AxisRatios:
        """Return the ratios from distances of logarithms from their mean over the axes.

        Parameters
        ----------
        frequency : array, shape (n,)
            Hz.
        values : array, shape (3 n,)
            Axis by axis at every frequency.
        covariance : array, shape (3 n, 3 n)
            Of `values`; singular, for the distances of two axes say that of the third.
        """
        n = len(frequency)
        two = np.flatnonzero(np.arange(3 * n) % 3 < _FREE)
        d, c = values[two], covariance[np.ix_(two, two)]
        design = np.tile(np.eye(_FREE), (n, 1))
        mean, square = generalised_least_squares(d, c, design)
        p_shared = p_value(d - design @ mean, c, len(d) - _FREE)
        p_isotropic = p_value(mean, square) if p_shared > ALIKE else p_value(d, c)
        back = np.concatenate([np.eye(_FREE), -np.ones((1, _FREE))])
        spread = np.sqrt(np.diag(back @ square @ back.T))
        each_std = np.sqrt(np.maximum(np.diag(covariance), 0.0)).reshape(n, 3)
        return cls(frequency, values.reshape(n, 3), each_std, back @ mean, spread, p_shared, p_isotropic)

    @property
    def verdict(self) -> Verdict:
        """Whether the axes differ."""
        return verdict_of(self.p_isotropic)

    @property
    def intervals(self) -> dict[str, Interval]:
        """Ratio of each axis at all frequencies together, and the ends of its interval of probability `LEVEL`."""
        pairs = zip(self.shared.tolist(), self.shared_std.tolist(), strict=True)
        return dict(zip(AXES, (_interval(*pair) for pair in pairs), strict=True))

    def interval(self, index: int, axis: int) -> Interval:
        """Return the same at one frequency."""
        return _interval(float(self.each[index, axis]), float(self.each_std[index, axis]))

    def sentence(self, name: str) -> str:
        """Return the ratios in words."""
        shown = ", ".join(
            f"{axis} {r:.3f} ({low:.3f} to {high:.3f})" for axis, (r, low, high) in self.intervals.items()
        )
        varies = "" if self.p_shared > ALIKE else ", and not the same at all frequencies"
        return f"{name} over the mean of the axes: {shown}{varies}"

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        axes = {axis: dict(zip(("ratio", "low", "high"), found, strict=True)) for axis, found in self.intervals.items()}
        return {
            "verdict": self.verdict, "p_isotropic": self.p_isotropic, "p_same_at_all_frequencies": self.p_shared,
            "axes": axes,
        }  # fmt: skip


def _interval(log_ratio: float, std: float) -> Interval:
    value, low, high = np.exp(log_ratio + _SIGMAS * std * np.array([0.0, -1.0, 1.0]))
    return float(value), float(low), float(high)
