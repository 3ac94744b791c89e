"""Other coordinates of a problem's unknowns, in which its residuals are nearer to straight lines.

Where data tell a combination of some unknowns to many digits, and the rest hardly, the most probable points lie along a
narrow valley. If that is bent, steps of a descent are as short as the root of its width, and differences for a
derivative along it lose what is to be found: across the valley, residuals change a hundred thousand times as much. In
coordinates one of which is the combination that is known, the valley is nearly straight.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from multilayer.arrays import RealArray

_ALIKE = 1e-6  # standard deviations
_SINGULAR = 1e8  # ratio of the most to the least that coordinates change with a step of others


class Reparameterisation(ABC):
    """Coordinates w in place of the first unknowns' standard normal coordinates z; those of all others stay."""

    @property
    @abstractmethod
    def count(self) -> int:
        """How many unknowns have other coordinates."""

    @abstractmethod
    def of(self, z: RealArray) -> RealArray:
        """Return w, shape (..., count), at z of the same shape."""

    @abstractmethod
    def back(self, w: RealArray) -> RealArray:
        """Return z, shape (..., count), at w of the same shape; NaN where there is none."""

    def all_of(self, z: RealArray) -> RealArray:
        """Return coordinates of all unknowns, shape (..., n), at z of the same shape."""
        return np.concatenate([self.of(z[..., : self.count]), z[..., self.count :]], axis=-1)

    def all_back(self, w: RealArray) -> RealArray:
        """Return z of all unknowns, shape (..., n), at coordinates of the same shape."""
        return np.concatenate([self.back(w[..., : self.count]), w[..., self.count :]], axis=-1)

    @abstractmethod
    def slopes(self, z: RealArray) -> RealArray:
        """Return dw/dz, shape (count, count), at z of all unknowns, shape (n,)."""

    def turn(self, z: RealArray) -> RealArray | None:
        """Return dw/dz with w in such units that a unit step of each is one of z; None where w do not tell z.

        That is the `turn` of a `Stencil`.
        """
        slopes = self.slopes(z)
        inverse = _inverse(slopes)
        return None if inverse is None else slopes * np.sqrt(np.sum(inverse**2, axis=0))[:, None]

    def holds(self, z: RealArray) -> bool:
        """Tell whether z of all unknowns is found again: it is lost neither to bounds nor to rounding."""
        return self.turn(z) is not None and bool(np.all(np.abs(self.all_back(self.all_of(z)) - z) < _ALIKE))

    def by_z(self, jacobian: RealArray, z: RealArray) -> RealArray:
        """Return a derivative by z, shape (m, n), from that by w."""
        return self._multiplied(jacobian, self.slopes(z))

    def by_w(self, jacobian: RealArray, z: RealArray) -> RealArray | None:
        """Return a derivative by w, shape (m, n), from that by z; None where w do not tell z."""
        inverse = _inverse(self.slopes(z))
        return None if inverse is None else self._multiplied(jacobian, inverse)

    def _multiplied(self, jacobian: RealArray, slopes: RealArray) -> RealArray:
        return np.concatenate([jacobian[:, : self.count] @ slopes, jacobian[:, self.count :]], axis=1)


def _inverse(slopes: RealArray) -> RealArray | None:
    """Return the inverse of a small matrix; None where it has none to more than half of the digits."""
    try:
        inverse = np.asarray(np.linalg.inv(slopes), dtype=float)
    except np.linalg.LinAlgError:
        return None
    return inverse if np.sum(slopes**2) * np.sum(inverse**2) < _SINGULAR**2 else None
