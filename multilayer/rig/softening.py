"""A rod whose modulus falls with strain: its equations of motion integrated in time.

The rod is cut into N elements with a lumped mass at each node; the top plate is a mass at the last one, and the base
moves as the shaker moves it. The stress of an element is that of a linear viscoelastic one (a spring beside Maxwell
elements, a Prony series fitted to the modulus law) of the strain

    phi(e) = e / (1 + n x)^(1/n),  x = b |e| (|e| / 1e-3)^(n - 1),

that is ``e / (1 + b |e|)`` for n = 1. It always rises with e, and all exponents n agree for x << 1 at a strain of 1e-3.

Central differences in time, which are explicit, with an exact exponential step of each Maxwell element for a strain
that is linear within the step (R. L. Taylor, K. S. Pister & G. L. Goudreau, Int. J. Numer. Meth. Eng. 2 (1970) 45-59).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls

from multilayer.arrays import ArrayLike, ComplexArray, RealArray

_PER_DECADE, _BEYOND = 2.5, 3.0  # Maxwell elements
_USUAL_STRAIN = 1e-3  # of a foam of 25 mm near its resonance on a shaker of 5 m/s2
_PER_WAVELENGTH = 12
_FEWEST_ELEMENTS, _MOST_ELEMENTS = 10, 60
_COURANT = 0.5  # of the largest stable step


@dataclass(frozen=True)
class PronySeries:
    """E = E0 + sum_k E_k i w tau_k / (1 + i w tau_k), all E_k at least 0: causal and passive.

    Attributes
    ----------
    relaxed : array, shape (...)
        E0, Pa.
    stiffnesses : array, shape (k, ...)
        E_k, Pa.
    times : array, shape (k,)
        tau_k, s.
    """

    relaxed: RealArray
    stiffnesses: RealArray
    times: RealArray

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return the modulus, Pa, at `frequency`, Hz, of a series without further axes."""
        turn = 2j * np.pi * np.asarray(frequency, dtype=float)[..., np.newaxis] * self.times
        return np.asarray(self.relaxed + (turn / (1 + turn)) @ self.stiffnesses)

    @property
    def instantaneous(self) -> RealArray:
        """The modulus at infinite frequency, Pa."""
        return np.asarray(self.relaxed + self.stiffnesses.sum(axis=0))


def fit_prony(frequency: RealArray, modulus: ComplexArray) -> PronySeries:
    """Return the series nearest to a modulus in relative error, by least squares with no negative stiffness.

    The non-negative least squares are those of C. L. Lawson & R. J. Hanson, Solving Least Squares Problems,
    Prentice-Hall 1974, chapter 23.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz, rising; relaxation times are spread from three times below to three times above.
    modulus : complex array, shape (n,)
        Pa.

    Notes
    -----
    A fractional Zener law is met to 0.05 %. A law that is not causal, such as a constant loss factor without
    dispersion, cannot be met: E1 is then off by some 10 % at the ends of the band.
    """
    low, high = frequency[0] / _BEYOND, frequency[-1] * _BEYOND
    n_times = int(np.ceil(_PER_DECADE * np.log10(high / low))) + 1
    times = 1 / (2 * np.pi * np.geomspace(low, high, n_times))
    turn = 2j * np.pi * frequency[:, np.newaxis] * times
    columns = np.concatenate([np.ones((len(frequency), 1)), turn / (1 + turn)], axis=1)
    weight = 1 / np.abs(modulus)
    rows = np.concatenate([columns.real, columns.imag]) * np.tile(weight, 2)[:, np.newaxis]
    targets = np.concatenate([modulus.real, modulus.imag]) * np.tile(weight, 2)
    stiffnesses, _ = nnls(rows, targets)
    return PronySeries(np.asarray(stiffnesses[0]), stiffnesses[1:], times)


@dataclass(frozen=True)
class SofteningRod:
    """A rod per burst, all of one length and with one mass on top, each with its own modulus.

    Attributes
    ----------
    thickness, density : float
        m, kg/m3.
    top_mass : float
        Per area, kg/m2.
    series : PronySeries
        Last axis: bursts.
    softening, exponent : float
        b and n of the law.
    highest : float
        Frequency up to which waves are resolved, Hz.
    """

    thickness: float
    density: float
    top_mass: float
    series: PronySeries
    softening: float
    exponent: float
    highest: float

    @property
    def n_elements(self) -> int:
        """Elements of the rod: 12 to a wavelength."""
        speed = np.sqrt(float(np.min(self.series.instantaneous)) / self.density)
        wanted = _PER_WAVELENGTH * self.thickness * self.highest / speed
        return int(np.clip(np.ceil(wanted), _FEWEST_ELEMENTS, _MOST_ELEMENTS))

    def oversampling(self, sampling_rate: float) -> int:
        """Return how many steps there are to a sample: half the largest stable step, at least four."""
        speed = np.sqrt(float(np.max(self.series.instantaneous)) / self.density)
        return max(int(np.ceil(speed * self.n_elements / self.thickness / (_COURANT * sampling_rate))), 4)

    def top(self, base: RealArray, sampling_rate: float, *, softened: bool = True) -> RealArray:
        """Return the acceleration of the top mass, m/s2, at every step.

        Parameters
        ----------
        base : array, shape (bursts, n_steps)
            The base's acceleration, m/s2.
        sampling_rate : float
            Steps per second, Hz: a multiple of that of the samples by `oversampling`.
        softened : bool
            False for the linear rod.
        """
        motion = _Motion(self, len(base), 1 / sampling_rate, softened)
        return np.stack([motion.step(now) for now in base.T], axis=1)

    def effective(self, strain: RealArray) -> RealArray:
        """Return phi(e): the strain of a linear sample that bears the same stress."""
        n, size = self.exponent, np.abs(strain)
        if n == 1:
            return np.asarray(strain / (1 + self.softening * size))
        x = self.softening * _USUAL_STRAIN * (size / _USUAL_STRAIN) ** n
        return np.asarray(strain / (1 + n * x) ** (1 / n))


class _Motion:
    """State of the rods, advanced from one time step to the next."""

    def __init__(self, rod: SofteningRod, bursts: int, dt: float, softened: bool) -> None:
        n, series = rod.n_elements, rod.series
        self.rod, self.dt, self.softened, self.size = rod, dt, softened, rod.thickness / n
        self.mass = np.full(n, rod.density * self.size)
        self.mass[-1] = 0.5 * self.mass[-1] + rod.top_mass
        rate = (dt / series.times)[:, np.newaxis, np.newaxis]
        self.kept = np.exp(-rate)
        self.gained = -np.expm1(-rate) / rate * np.reshape(series.stiffnesses, (len(series.times), -1, 1))
        self.relaxed = np.reshape(series.relaxed, (-1, 1))
        self.place, self.speed = np.zeros((bursts, n + 1)), np.zeros((bursts, n))  # relative to the base
        self.strain, self.pull = np.zeros((bursts, n)), np.zeros((bursts, n))
        self.branches = np.zeros((len(series.times), bursts, n))

    def step(self, base: RealArray) -> RealArray:
        """Return the top's acceleration at this step, m/s2 (that of the base included), and advance by one step."""
        before, strain = self.strain, (self.place[:, 1:] - self.place[:, :-1]) / self.size
        self.strain = self.rod.effective(strain) if self.softened else strain
        self.branches *= self.kept
        self.branches += self.gained * (self.strain - before)
        stress = self.relaxed * self.strain + self.branches.sum(axis=0)
        self.pull[:, :-1] = stress[:, 1:] - stress[:, :-1]
        self.pull[:, -1] = -stress[:, -1]
        self.pull /= self.mass
        self.speed += self.dt * (self.pull - base[:, np.newaxis])
        self.place[:, 1:] += self.dt * self.speed
        return self.pull[:, -1].copy()
