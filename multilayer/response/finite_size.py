"""Radiation of a panel of finite size, and its transmission and absorption from those of an infinite one."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Protocol

import numpy as np
from numpy.polynomial.chebyshev import chebpts1, chebval, chebvander
from numpy.polynomial.legendre import leggauss
from scipy.special import j0

from multilayer.arrays import ArrayLike, ComplexArray, IndexArray, RealArray
from multilayer.bounds import ACROSS_PANEL
from multilayer.errors import InputError, Problem
from multilayer.stack import FluidHalfSpace, Stack

_NODES, _WEIGHTS = leggauss(24)
_RADIANS = 32.0  # of phase that a panel of nodes resolves to many digits
_LEAST_PANELS = 2
_AT_ONCE = 2**20  # values of the integrand
_MOST_KEPT = 2**19  # coefficients of series that are kept, 8 MB; there are 32 of these at most


class Radiation(Protocol):
    """The radiation impedance, over rho c, at wavenumbers known before, by their indices and trace wavenumbers."""

    def __call__(self, which: IndexArray, trace: RealArray) -> ComplexArray:
        """Return the impedance, for two arrays of one shape."""
        ...

    def efficiency(self, which: IndexArray, trace: RealArray) -> RealArray:
        """Return its real part alone, the radiation efficiency."""
        ...


@dataclass(frozen=True)
class Window:
    """A rectangular panel in a rigid baffle.

    Attributes
    ----------
    width, height : float
        m.
    """

    width: float
    height: float

    def __post_init__(self) -> None:
        if not (self.width > 0 and self.height > 0):
            raise InputError(f"a panel of {self.width} m by {self.height} m is not allowed; both must be above 0")

    @property
    def area(self) -> float:
        """Area, m2."""
        return self.width * self.height

    @property
    def diagonal(self) -> float:
        """Largest distance of two points, m."""
        return float(np.hypot(self.width, self.height))


def radiation_impedance(window: Window, wavenumber: ArrayLike, trace: ArrayLike) -> ComplexArray:
    """Return the radiation impedance of a panel that a plane wave moves, over rho c.

    Parameters
    ----------
    window : Window
    wavenumber : array
        k0 of the fluid, rad/m.
    trace : array
        Trace wavenumber of the motion along the panel, rad/m; broadcasts with `wavenumber`.

    Returns
    -------
    complex array
        Averaged over the azimuth of the motion. Its real part is the radiation efficiency. For a very large panel it
        tends to 1/cos(angle), for a very small one to k0^2 S/(2 pi) + i ...

    Raises
    ------
    InputError
        For a panel of more wavelengths than `bounds.ACROSS_PANEL` allows.

    Notes
    -----
    Spatial windowing, Villot, Guigou & Gagliardini, J. Sound Vib. 245 (2001) 433-455, and Rhazi & Atalla, J. Acoust.
    Soc. Am. 127 (2010) EL30-EL36. In space rather than in wavenumbers, the mean over the azimuth turns the double
    integral into a single one,

        Z/(rho c) = i k0/(2 pi S) int_0^D C(r) J0(kt r) exp(-i k0 r) dr,

    C(r) the overlap of the panel with itself displaced by r, summed over all directions: a closed form for rectangles.
    """
    k0, kt = np.broadcast_arrays(np.asarray(wavenumber, dtype=float), np.asarray(trace, dtype=float))
    fluid, which = np.unique(k0, return_inverse=True)
    meetings = kt.size // max(fluid.size, 1)
    return radiation_at(window, fluid, float(np.max(kt, initial=0.0)), meetings)(which.reshape(kt.shape), kt)


def radiation_at(window: Window, wavenumber: RealArray, largest: float, meetings: int) -> Radiation:
    """Return a function that gives `radiation_impedance` at wavenumbers known before, by their indices.

    Parameters
    ----------
    window : Window
    wavenumber : array, shape (n_wavenumbers,)
        k0 of the fluid, rad/m.
    largest : float
        Of the trace wavenumbers, rad/m.
    meetings : int
        About how many trace wavenumbers will be asked for at each wavenumber of the fluid.

    Returns
    -------
    Radiation
    """
    if largest > 0 and meetings > 2 and meetings * wavenumber.size > (n := _n_terms(window, largest)):
        made = _kept_series if n * wavenumber.size < _MOST_KEPT else _series
        return made(window, np.asarray(wavenumber, dtype=float).tobytes(), largest)
    return _OneByOne(window, wavenumber)


@dataclass(frozen=True)
class _OneByOne:
    """Integrals at wavenumbers of the fluid, shape (n,)."""

    window: Window
    wavenumber: RealArray

    def __call__(self, which: IndexArray, trace: RealArray) -> ComplexArray:
        return _integrals(self.window, self.wavenumber[which], trace)

    def efficiency(self, which: IndexArray, trace: RealArray) -> RealArray:
        return self(which, trace).real


@dataclass(frozen=True)
class _Series:
    """Chebyshev series in the squared trace wavenumber, up to its largest value.

    Attributes
    ----------
    real, imaginary : array, shape (n_terms, n_wavenumbers)
    largest : float
        rad/m.
    """

    real: RealArray
    imaginary: RealArray
    largest: float

    def __call__(self, which: IndexArray, trace: RealArray) -> ComplexArray:
        return np.asarray(self.efficiency(which, trace) + 1j * self._sum(self.imaginary, which, trace))

    def efficiency(self, which: IndexArray, trace: RealArray) -> RealArray:
        return self._sum(self.real, which, trace)

    def _sum(self, coefficients: RealArray, which: IndexArray, trace: RealArray) -> RealArray:
        x = 2 * (trace / self.largest) ** 2 - 1
        return np.asarray(chebval(x, coefficients[:, which], tensor=False))


def _series(window: Window, wavenumbers: bytes, largest: float) -> Radiation:
    """Return the series, one per wavenumber of the fluid.

    Only J0 depends on the trace wavenumber, and it is an entire function of its square: a few terms more than half the
    largest argument give all digits, and all wavenumbers of the fluid share the samples of J0.
    """
    n, wavenumber = _n_terms(window, largest), np.frombuffer(wavenumbers)
    x = chebpts1(n)
    trace = largest * np.sqrt(0.5 * (1 + x))
    samples = np.zeros((n, len(wavenumber)), dtype=complex)
    for radius, weight in _nodes(window, float(np.max(wavenumber)) + largest, n + 2 * len(wavenumber)):
        standing = j0(trace[:, None] * radius)
        # a real matrix times a complex one, which NumPy would take for two complex ones
        samples.view(float)[:] += standing @ _motion(window, radius, weight, wavenumber).view(float)
    coefficients = 2 / n * (chebvander(x, n - 1).T @ samples)
    coefficients[0] /= 2
    return _Series(np.array(coefficients.real), np.array(coefficients.imag), largest)


# the layers make no difference: a sweep meets one panel again and again
_kept_series = lru_cache(maxsize=32)(_series)


def _n_terms(window: Window, largest: float) -> int:
    """Return the number of terms for J0(kt r): they are J_n(z)^2, z half the largest argument, and vanish beyond z."""
    z = 0.5 * largest * window.diagonal
    return int(z + 7 * z ** (1 / 3)) + 10


def _integrals(window: Window, wavenumber: RealArray, trace: RealArray) -> ComplexArray:
    """Return the impedance for pairs of wavenumbers one by one."""
    k0, kt = wavenumber.ravel(), trace.ravel()
    impedance = np.zeros(k0.shape, dtype=complex)
    for radius, weight in _nodes(window, float(np.max(k0 + kt, initial=0.0)), impedance.size):
        impedance += np.sum(j0(radius[:, None] * kt) * _motion(window, radius, weight, k0), axis=0)
    return impedance.reshape(wavenumber.shape)


def _motion(window: Window, radius: RealArray, weight: RealArray, wavenumber: RealArray) -> ComplexArray:
    """Return the factor of J0 in the integral, shape (n_nodes, n_wavenumbers)."""
    phase = radius[:, None] * wavenumber
    moved = np.empty(phase.shape, dtype=complex)  # i exp(-i phase)
    np.sin(phase, out=moved.real)
    np.cos(phase, out=moved.imag)
    moved *= (_overlap(window, radius) * weight)[:, None] * wavenumber / (2 * np.pi * window.area)
    return moved


def _nodes(window: Window, fastest: float, n_values: int) -> Iterator[tuple[RealArray, RealArray]]:
    """Return Gauss nodes and weights from 0 to the diagonal, with breaks where the overlap has kinks.

    They come in pieces that bound the memory that an integrand of `n_values` at each node takes.
    """
    across = fastest * window.diagonal
    if not across <= ACROSS_PANEL.most:
        told = str(ACROSS_PANEL.refusal(across, remedy="leave the size out: such a panel is as an infinite one"))
        raise InputError(Problem(told, "finite_size"))
    short, long = sorted((window.width, window.height))
    for low, high in pairwise((0.0, short, long, window.diagonal)):
        n = _LEAST_PANELS + int(2 * fastest * (high - low) / _RADIANS)
        step = max(1, _AT_ONCE // (len(_NODES) * max(n_values, 1)))
        for first in range(0, n, step):
            panels = np.arange(first, min(first + step, n))
            t = ((panels[:, None] + 0.5 * (1 + _NODES)) / n).ravel()
            # squared towards the lower end: the overlap starts there like a power of 3/2
            yield low + (high - low) * t**2, (high - low) * t * np.tile(_WEIGHTS, len(panels)) / n


def _overlap(window: Window, radius: RealArray) -> RealArray:
    """Return the integral of (a - |r cos|)+ (b - |r sin|)+ over all directions."""
    a, b = window.width, window.height
    low, high = np.arccos(np.minimum(1, a / radius)), np.arcsin(np.minimum(1, b / radius))

    def primitive(psi: RealArray) -> RealArray:
        sine = np.sin(psi)
        return np.asarray(a * b * psi + a * radius * np.cos(psi) - b * radius * sine + 0.5 * (radius * sine) ** 2)

    return np.asarray(np.where(high > low, 4 * (primitive(high) - primitive(low)), 0.0))


def half_space_behind(stack: Stack) -> tuple[float, float] | None:
    """Return density and sound speed of the half-space behind, if there is one."""
    gas = stack.ambient.gas
    match stack.termination:
        case "ambient":
            return gas.density, gas.sound_speed
        case FluidHalfSpace() as fluid:
            return fluid.density or gas.density, fluid.sound_speed or gas.sound_speed
    return None


def refuse_other_fluid(stack: Stack) -> None:
    """Refuse a stack with another fluid behind than the ambient gas, whose radiation impedance is taken on both sides.

    Raises
    ------
    InputError
        Where sound behind is faster or slower than in front.
    """
    behind, ambient = half_space_behind(stack), stack.ambient.gas.sound_speed
    if behind is not None and behind[1] != ambient:
        text = f"a panel of finite size has the ambient gas on both sides, of sound speed {ambient:.6g} m/s"
        text += f", and this one a fluid of {behind[1]:.6g} m/s behind it"
        raise InputError(Problem(f"{text}; write 'termination: ambient', or leave the size out", "finite_size"))


def radiation_towards(
    window: Window, frequency: RealArray, angle: ArrayLike, sound_speed: float
) -> tuple[ComplexArray, RealArray]:
    """Return the `radiation_impedance` of plane waves at frequencies, Hz, and angles, degrees, and their cosines."""
    wavenumber, radians = 2 * np.pi * frequency / sound_speed, np.deg2rad(angle)
    return radiation_impedance(window, wavenumber, wavenumber * np.sin(radians)), np.cos(radians)


def finite_transmission(transmission: RealArray, efficiency: RealArray, cosine: RealArray) -> RealArray:
    """Return the power transmission coefficient of a finite panel from that of an infinite one.

    Rhazi & Atalla 2010: ``tau sigma cos``, the window on the receiving side only.
    """
    return np.asarray(transmission * efficiency * cosine)


def finite_loss(loss: RealArray, efficiency: RealArray, cosine: RealArray) -> RealArray:
    """Return the transmission loss of a finite panel from that of an infinite one, dB; see `finite_transmission`."""
    with np.errstate(divide="ignore"):
        return np.asarray(-10 * np.log10(finite_transmission(10 ** (-loss / 10), efficiency, cosine)))


def finite_absorption(reflection: ComplexArray, impedance: ComplexArray, cosine: RealArray) -> RealArray:
    """Return the absorption coefficient of a finite sample from the reflection of an infinite one.

    Thomasson, Acustica 44 (1980) 265-273: ``4 Re(z)/(cos |z + zr|^2)``, z the surface impedance and zr the radiation
    impedance over rho c. It may exceed 1. A half-space behind the sample stays endless in z, so that the absorption of
    one that lets sound through holds power which a panel of that size does not radiate.
    """
    facing = (1 + reflection) + impedance * cosine * (1 - reflection)
    return np.asarray(4 * (1 - np.abs(reflection) ** 2) / np.abs(facing) ** 2)


def finite_absorption_slope(
    reflection: ComplexArray, change: ComplexArray, impedance: ComplexArray, cosine: RealArray
) -> RealArray:
    """Return the change of `finite_absorption` with a small change of the reflection."""
    facing = (1 + reflection) + impedance * cosine * (1 - reflection)
    turned = (1 - impedance * cosine) * change
    size = np.abs(facing) ** 2
    absorbed = 1 - np.abs(reflection) ** 2
    return np.asarray(
        -8 * (np.real(np.conj(reflection) * change) + absorbed * np.real(np.conj(facing) * turned) / size) / size
    )
