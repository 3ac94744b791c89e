"""The modulus at one frequency in place of two of a law's unknowns: what a resonance tells beside what it does not."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import ComplexArray, RealArray
from multilayer.inference.derivative import central
from multilayer.inference.priors import Priors
from multilayer.inference.reparameterisation import Reparameterisation
from multilayer.media.laws.parameters import LawSpace

_STEPS = 12  # of the secant method, of which a step of a descent needs few
_SMALL = 1e-11  # rad


@dataclass(frozen=True, eq=False)
class AmountAt(Reparameterisation):
    """ln abs(E) at one frequency in place of the coordinate that scales a law's modulus.

    Data tell the modulus within their band to a ten-thousandth, and of the law's unknowns only the combination that
    makes it: the valley of laws that do as well is bent in the coordinates of these.

    Attributes
    ----------
    space : LawSpace
        Of a law with a `LawSpace.scale`.
    priors : Priors
        Of the law's unknowns, uniform within the space's bounds.
    frequency : float
        Hz.
    near : array, shape (n_law,)
        Coordinates around which they are made.
    """

    space: LawSpace
    priors: Priors
    frequency: float
    near: RealArray

    @property
    def count(self) -> int:
        """The law's unknowns."""
        return len(self.priors.priors)

    def of(self, z: RealArray) -> RealArray:
        """Return coordinates with the amount of the modulus in place of that which scales it."""
        w = np.array(z, dtype=float)
        self._insert(w, self._logarithm(z))
        return w

    def back(self, w: RealArray) -> RealArray:
        """Return standard normal coordinates; NaN where no law of the space has that modulus."""
        low, high = self.space.low[self._scale], self.space.high[self._scale]
        with np.errstate(all="ignore"):
            z, logarithm = self._unscaled(w)
            missing = w[..., self._scale] + self._here[0].real - logarithm.real
            share = (self.priors.values(z)[..., self._scale] + missing - low) / (high - low)
            z[..., self._scale] = ndtri(np.where((share > 0) & (share < 1), share, np.nan))
        return z

    def slopes(self, z: RealArray) -> RealArray:
        """Return dw/dz, shape (n_law, n_law), at z of all unknowns."""
        at, slopes = z[: self.count], np.eye(self.count)
        here = self._here if np.array_equal(at, self.near) else central(self._logarithm, at)
        self._insert(slopes.T, here[1], 0.0)
        return slopes

    def _insert(self, w: RealArray, logarithm: ComplexArray, origin: float | None = None) -> None:
        """Write what stands for ln E, shape (...), into coordinates, shape (..., n_law)."""
        w[..., self._scale] = logarithm.real - (self._here[0].real if origin is None else origin)

    def _unscaled(self, w: RealArray) -> tuple[RealArray, ComplexArray]:
        """Return z of a modulus of any amount, and its logarithm."""
        z = np.array(w, dtype=float)
        z[..., self._scale] = self.near[self._scale]
        return z, self._logarithm(z)

    @property
    def _scale(self) -> int:
        assert self.space.scale is not None
        return self.space.scale

    @cached_property
    def _here(self) -> tuple[ComplexArray, ComplexArray]:
        """Ln E in the middle, and its derivative by z."""
        return central(self._logarithm, self.near)

    def _logarithm(self, z: RealArray) -> ComplexArray:
        """Return ln E, shape (...)."""
        return np.asarray(np.log(self.space.modulus(self.priors.values(z), np.array([self.frequency]))[..., 0]))


@dataclass(frozen=True, eq=False)
class ModulusAt(AmountAt):
    """The loss angle besides, in place of the unknown by which it changes most.

    Where other unknowns bound the angle that this one can reach, there are limits: the coordinates serve around a point
    that is nearly a minimum.
    """

    def _insert(self, w: RealArray, logarithm: ComplexArray, origin: float | None = None) -> None:
        super()._insert(w, logarithm, origin)
        w[..., self._lossy] = logarithm.imag

    def _unscaled(self, w: RealArray) -> tuple[RealArray, ComplexArray]:
        """Return z of a modulus with the angle that w has, NaN where it cannot be reached, and its logarithm."""
        lossy, wanted, by_z = self._lossy, w[..., self._lossy], self._here[1].imag
        ahead = (w - self.near) @ np.where(np.arange(self.count) == lossy, 0.0, by_z)
        ahead -= (w[..., self._scale] - self.near[self._scale]) * by_z[self._scale]  # no amount changes the angle
        w = np.array(w, dtype=float)
        w[..., lossy] = self.near[lossy] + (wanted - self._here[0].imag - ahead) / by_z[lossy]
        z, logarithm = super()._unscaled(w)
        slope: RealArray = by_z[lossy]
        for _ in range(_STEPS):
            step = (wanted - logarithm.imag) / slope
            if not np.any(np.abs(wanted - logarithm.imag) > _SMALL):
                break
            z[..., lossy] += step
            before, logarithm = logarithm, self._logarithm(z)
            slope = np.where(step == 0, slope, (logarithm.imag - before.imag) / step)
        z[~(np.abs(wanted - logarithm.imag) <= _SMALL)] = np.nan
        return z, logarithm

    @cached_property
    def _lossy(self) -> int:
        """Place of the unknown by which the angle changes most."""
        return int(np.argmax(np.abs(self._here[1].imag)))
