"""All moduli with which a rod under a rigid mass has a given transmissibility.

With ``theta = w l sqrt(rho/E)`` and ``r = M/m``, eq. (11) of Bonfiglio & Pompoli 2015 reads ``D(theta) = cos(theta) -
r theta sin(theta) = 1/T``. D is entire: Newton's method finds its solutions from a grid of starts, and the argument
principle counts them, so that none is missed unnoticed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray

QUARTER = 0.25  # thickness over wavelength below which a modulus is the only one
NOWHERE = complex(np.nan, np.nan)
_ITERATIONS = 60
_SPACING = 0.5  # of starts in Re(theta); solutions lie about pi apart
_DAMPING = (0.1, 0.5, 1.5, 4.0)  # Im(theta) of starts, beside those spread over the sector
_GROWTH = (0.0, 1e-3, 3e-3, 1e-2)  # of the counted region, when a solution lies on its rim
_HALVINGS = 30
_APART = 1e-6
_CONVERGED = 1e-9  # a step of Newton this small leaves an error of its square
_REACH = 0.7  # from burst to burst in (ln E1, E2/E1), beside the dispersion of the last one


@dataclass(frozen=True)
class Rod:
    """A rod-like sample under a rigid mass.

    Attributes
    ----------
    density : float
        kg/m3.
    length : float
        m.
    mass_per_area : float
        Of the top plate, kg/m2.
    """

    density: float
    length: float
    mass_per_area: float

    @property
    def mass_ratio(self) -> float:
        """Mass of the top plate over that of the sample."""
        return self.mass_per_area / (self.density * self.length)

    def phase(self, frequency: float, modulus: complex) -> complex:
        """Return theta: 2 pi times the length over the wavelength, lossy with a negative imaginary part."""
        return complex(2 * np.pi * frequency * self.length * np.sqrt(self.density / complex(modulus)))

    def modulus(self, frequency: float, phase: ComplexArray) -> ComplexArray:
        """Return the modulus, Pa, that belongs to theta."""
        return np.asarray(self.density * (2 * np.pi * frequency * self.length / phase) ** 2)


@dataclass(frozen=True)
class Solutions:
    """Every modulus within bounds.

    Attributes
    ----------
    moduli : complex array, shape (n,)
        Pa, the stiffest first: the one with the fewest waves in the sample.
    complete : bool
        Whether the argument principle confirms that there are no others.
    """

    moduli: ComplexArray
    complete: bool


def motion(phase: ComplexArray, mass_ratio: float) -> tuple[ComplexArray, ComplexArray]:
    """Return D and dD/dtheta, both times exp(-|Im theta|): a positive factor that keeps them finite."""
    decay = np.abs(phase.imag)
    ahead, back = np.exp(1j * phase - decay), np.exp(-1j * phase - decay)
    cosine, sine = (ahead + back) / 2, (ahead - back) / 2j
    value = cosine - mass_ratio * phase * sine
    return value, -(1 + mass_ratio) * sine - mass_ratio * phase * cosine


def solve(
    rod: Rod, frequency: float, transmissibility: complex, storage: tuple[float, float], loss: tuple[float, float]
) -> Solutions:
    """Return all moduli that give a transmissibility.

    Parameters
    ----------
    rod : Rod
    frequency : float
        Hz.
    transmissibility : complex
        Top over base motion, not 0.
    storage, loss : tuple of float
        Bounds of E1, Pa, above 0, and of E2/E1; both included.
    """
    angle = np.arctan(loss)
    size = storage[0], storage[1] * np.hypot(1, np.abs(loss).max())
    phases = np.abs([rod.phase(frequency, size[1]), rod.phase(frequency, size[0])])
    sector = _Sector(np.log(phases[0]), np.log(phases[1]), -angle[1] / 2, -angle[0] / 2)
    equation = _Equation(rod.mass_ratio, 1 / transmissibility)
    roots, complete = equation.roots(sector)
    e = rod.modulus(frequency, roots)
    factor = e.imag / e.real
    inside = (e.real >= storage[0]) & (e.real <= storage[1]) & (factor >= loss[0]) & (factor <= loss[1])
    return Solutions(e[inside], complete)


@dataclass(frozen=True)
class _Sector:
    """A rectangle in ln(theta)."""

    low: float
    high: float
    bottom: float
    top: float

    def grown(self, by: float) -> _Sector:
        return _Sector(self.low - by, self.high + by, self.bottom - by, self.top + by)

    def holds(self, phase: ComplexArray) -> BoolArray:
        u = np.log(phase)
        wide = (u.real >= self.low) & (u.real <= self.high)
        return np.asarray(wide & (u.imag >= self.bottom) & (u.imag <= self.top))

    def along(self, spacing: float) -> RealArray:
        """Return ln|theta| from end to end, in steps of `spacing` of |theta| and at most of ln|theta|."""
        low, high = np.exp([self.low, self.high])
        fine = np.arange(low, high, spacing) if high > 1 else np.empty(0)
        slow = np.linspace(self.low, self.high, int((self.high - self.low) / spacing) + 2)
        return np.unique(np.concatenate([slow[slow <= 0], np.log(fine[fine > 1]), [self.low, self.high]]))

    def starts(self, spacing: float) -> ComplexArray:
        radius = self.along(spacing)[:, np.newaxis]
        spread = np.broadcast_to(np.linspace(self.bottom, self.top, 7), (len(radius), 7))
        shallow = np.clip(-np.array(_DAMPING) / np.exp(radius), self.bottom, self.top)
        return np.asarray(np.exp(radius + 1j * np.concatenate([spread, shallow], axis=1)).ravel())

    def rim(self) -> ComplexArray:
        """Return points of ln(theta) once around, the first one again at the end."""
        across, up = self.along(0.25), np.linspace(self.bottom, self.top, 20)
        sides = (across + 1j * self.bottom, self.high + 1j * up, across[::-1] + 1j * self.top, self.low + 1j * up[::-1])
        return np.concatenate(sides)


@dataclass(frozen=True)
class _Equation:
    """``D(theta) = wanted``."""

    mass_ratio: float
    wanted: complex

    def __call__(self, phase: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        value, slope = motion(phase, self.mass_ratio)
        return value - self.wanted * np.exp(-np.abs(phase.imag)), slope

    def roots(self, sector: _Sector) -> tuple[ComplexArray, bool]:
        """Return the solutions in a sector by rising wavenumber, and whether there are no others."""
        roots = np.empty(0, dtype=complex)
        for by in _GROWTH:
            region = sector.grown(by)
            number = self.count(region)
            for finer in (1, 2, 4):
                roots = self.newton(region.starts(_SPACING / finer))
                roots = _distinct(roots[region.holds(roots)])
                if len(roots) == number:
                    return roots, True
        return roots, False

    def newton(self, phase: ComplexArray) -> ComplexArray:
        """Return where the starts lead, without those that lead nowhere."""
        arrived = []
        with np.errstate(all="ignore"):  # a start on a stationary point goes to infinity and is dropped
            for _ in range(_ITERATIONS):
                value, slope = self(phase)
                step = value / slope
                step *= np.minimum(1, np.minimum(1.0, 0.3 * np.abs(phase)) / np.abs(step))
                phase = phase - step
                there = np.abs(step) < _CONVERGED * np.abs(phase)
                arrived.append(phase[there])
                phase = phase[~there & np.isfinite(phase) & (phase.real > 0)]
                if not phase.size:
                    break
        return np.concatenate(arrived)

    def count(self, region: _Sector) -> int:
        """Return the number of solutions by the argument principle; -1 when one lies too near the rim."""
        path = region.rim()
        for _ in range(_HALVINGS):
            value = self(np.exp(path))[0]
            if not np.all(value != 0):
                return -1
            turns = np.angle(value[1:] / value[:-1])
            coarse = np.flatnonzero(np.abs(turns) > 1)
            if not coarse.size:
                return round(float(np.sum(turns)) / (2 * np.pi))
            path = np.insert(path, coarse + 1, (path[coarse] + path[coarse + 1]) / 2)
        return -1


def _distinct(roots: ComplexArray) -> ComplexArray:
    """Return each root once, by rising real part."""
    kept: list[complex] = []
    for root in roots[np.argsort(roots.real)]:
        if all(abs(root - other) > _APART * abs(root) for other in reversed(kept[-4:])):
            kept.append(complex(root))
    return np.array(kept, dtype=complex)


def follow_branch(rod: Rod, frequencies: Sequence[float], solutions: Sequence[Solutions]) -> list[complex]:
    """Return one modulus per frequency, each the continuation of the one below; NaN where there is none.

    Parameters
    ----------
    rod : Rod
    frequencies : sequence of float
        Hz, rising.
    solutions : sequence of Solutions
        Pa.
    """
    chosen: list[complex] = []
    last: tuple[float, complex] | None = None
    for frequency, found in zip(frequencies, solutions, strict=True):
        best = _first(rod, frequency, found) if last is None else _next(*last, frequency, found)
        if np.isfinite(best):
            last = frequency, best
        chosen.append(best)
    return chosen


def _first(rod: Rod, frequency: float, found: Solutions) -> complex:
    """Return the solution of a sample thinner than a quarter of the wavelength, where there is one at most."""
    thin = [complex(e) for e in found.moduli if rod.phase(frequency, e).real <= 2 * np.pi * QUARTER]
    return thin[0] if thin else NOWHERE


def _next(before: float, modulus: complex, frequency: float, found: Solutions) -> complex:
    expected = modulus * (frequency / before) ** (2 / np.pi * np.angle(modulus))
    if not found.moduli.size:
        return NOWHERE
    loss = found.moduli.imag / found.moduli.real
    distance = np.hypot(np.log(found.moduli.real / expected.real), loss - expected.imag / expected.real)
    nearest = int(np.argmin(distance))
    return complex(found.moduli[nearest]) if distance[nearest] <= _REACH else NOWHERE
