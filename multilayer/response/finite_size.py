"""What a panel of finite size radiates and receives, against an infinite one."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.polynomial.legendre import leggauss
from scipy.special import j0

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError

_NODES, _WEIGHTS = leggauss(24)
_RADIANS = 16.0  # of phase that a panel of nodes resolves to many digits
_LEAST_PANELS = 2


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

    Notes
    -----
    Spatial windowing, Villot, Guigou & Gagliardini, J. Sound Vib. 245 (2001) 433-455, and Rhazi & Atalla, J. Acoust.
    Soc. Am. 127 (2010) EL30-EL36. In space rather than in wavenumbers, the mean over the azimuth turns the double
    integral into a single one,

        Z/(rho c) = i k0/(2 pi S) int_0^D C(r) J0(kt r) exp(-i k0 r) dr,

    C(r) the overlap of the panel with itself displaced by r, summed over all directions: a closed form for rectangles.
    """
    k0, kt = np.broadcast_arrays(np.asarray(wavenumber, dtype=float), np.asarray(trace, dtype=float))
    radius, weight = _nodes(window, float(np.max(k0 + kt)))
    shape = _overlap(window, radius) * weight
    oscillation = j0(kt[..., None] * radius) * np.exp(-1j * k0[..., None] * radius)
    return np.asarray(1j * k0 / (2 * np.pi * window.area) * (oscillation @ shape))


def _nodes(window: Window, fastest: float) -> tuple[RealArray, RealArray]:
    """Return Gauss nodes and weights from 0 to the diagonal, with breaks where the overlap has kinks."""
    short, long = sorted((window.width, window.height))
    ends = [0.0, short, long, float(np.hypot(short, long))]
    points, weights = [], []
    for low, high in pairwise(ends):
        if high <= low:
            continue
        n = _LEAST_PANELS + int(2 * fastest * (high - low) / _RADIANS)
        t = ((np.arange(n)[:, None] + 0.5 * (1 + _NODES)) / n).ravel()
        # squared towards the lower end: the overlap starts there like a power of 3/2
        points.append(low + (high - low) * t**2)
        weights.append((high - low) * t * np.tile(_WEIGHTS, n) / n)
    return np.concatenate(points), np.concatenate(weights)


def _overlap(window: Window, radius: RealArray) -> RealArray:
    """Return the integral of (a - |r cos|)+ (b - |r sin|)+ over all directions."""
    a, b = window.width, window.height
    low, high = np.arccos(np.minimum(1, a / radius)), np.arcsin(np.minimum(1, b / radius))

    def primitive(psi: RealArray) -> RealArray:
        sine = np.sin(psi)
        return np.asarray(a * b * psi + a * radius * np.cos(psi) - b * radius * sine + 0.5 * (radius * sine) ** 2)

    return np.asarray(np.where(high > low, 4 * (primitive(high) - primitive(low)), 0.0))


def finite_transmission(transmission: RealArray, impedance: ComplexArray, cosine: RealArray) -> RealArray:
    """Return the power transmission coefficient of a finite panel from that of an infinite one.

    Rhazi & Atalla 2010: ``tau sigma cos``, the window on the receiving side only.
    """
    return np.asarray(transmission * impedance.real * cosine)


def finite_absorption(reflection: ComplexArray, impedance: ComplexArray, cosine: RealArray) -> RealArray:
    """Return the absorption coefficient of a finite sample from the reflection of an infinite one.

    Thomasson, Acustica 44 (1980) 265-273: ``4 Re(z)/(cos |z + zr|^2)``, z the surface impedance and zr the radiation
    impedance over rho c. It may exceed 1.
    """
    facing = (1 + reflection) + impedance * cosine * (1 - reflection)
    return np.asarray(4 * (1 - np.abs(reflection) ** 2) / np.abs(facing) ** 2)
