"""Holes and slits through a thick rigid wall: what they transmit and take in, with viscosity and heat conduction.

The air at each end moves as a massless piston in a baffle, the fundamental mode runs through the wall: G. P. Wilson &
W. W. Soroka, J. Acoust. Soc. Am. 37 (1965) 286-297, of round holes; M. C. Gomperts & T. Kihlman, Acustica 18 (1967)
144-150, of slits. Inside stands the gas of `media.narrow`, at the ends the friction of `media.perforations`.

What a diffuse field does to a piston follows from what the piston radiates: the squared pressure that it feels when
held still, averaged over directions, is proportional to its radiation resistance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.special import hankel2, j1, sici, struve

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.media.elastic import decaying_root
from multilayer.media.gas import Gas
from multilayer.media.narrow import narrow_gas
from multilayer.media.perforations import end_friction

_ALONG, _WEIGHTS = np.polynomial.legendre.leggauss(32)  # directions along a slit
_ALONG, _WEIGHTS = np.pi / 4 * (_ALONG + 1), np.pi / 4 * _WEIGHTS
_SERIES = 1e-3  # k width below which the slit's integral is taken by its series


@dataclass(frozen=True)
class Passage:
    """What passes through an opening, as shares of the power that meets its area; arrays over frequency.

    Attributes
    ----------
    transmission : array
        Power radiated behind. It may exceed 1: an opening draws in power from around it.
    absorption : array
        Power that goes in at the front.
    """

    transmission: RealArray
    absorption: RealArray


def disc_impedance(x: Numeric) -> ComplexArray:
    """Return the radiation impedance of a round piston in a baffle over rho c, by x = k radius; Rayleigh's."""
    x = np.asarray(x, dtype=float)
    return np.asarray(1 - j1(2 * x) / x + 1j * struve(1, 2 * x) / x)


def strip_impedance(x: Numeric) -> ComplexArray:
    """Return the radiation impedance of an endless strip that moves as one in a baffle, over rho c, by x = k width.

    The mean over the strip of the pressure of its lines, ``(1/x) int_0^x (x - u) H0(u) du``, H0 the Hankel function of
    the second kind; the integral in closed form with Struve's functions. For narrow strips x/2 + i (x/pi) (3/2 - gamma
    - ln(x/2)).
    """
    x = np.asarray(x, dtype=float)
    large = np.maximum(x, _SERIES)
    h0, h1 = hankel2(0, large), hankel2(1, large)
    whole = large * h0 + np.pi * large / 2 * (struve(0, large) * h1 - struve(1, large) * h0)
    moment = large * h1 - 2j / np.pi
    narrow = x / 2 + 1j * x / np.pi * (1.5 - np.euler_gamma - np.log(x / 2))
    return np.asarray(np.where(x < _SERIES, narrow, whole - moment / large))


def line_radiation(x: Numeric) -> RealArray:
    """Return the share of an endless strip's radiation, per length, that a strip of k length = x radiates.

    The squared directivity of a line, ``(2/pi) (Si(x) - (1 - cos x)/x)``; x/pi of a short one, 1 of a long one.
    """
    x = np.asarray(x, dtype=float)
    return np.asarray(2 / np.pi * (sici(x)[0] - (1 - np.cos(x)) / x))


def rectangle_reactance(wavenumber: RealArray, width: Numeric, length: Numeric) -> RealArray:
    """Return the reactance over rho c of a rectangular piston in a baffle, smaller than the waves: that of its mass.

    ``k/(2 pi S)`` times the integral of 1/distance over all pairs of its points, in closed form; of a narrow one
    ``(k width/pi) (ln(2 length/width) + 1/2)``.

    Parameters
    ----------
    wavenumber : array
        rad/m.
    width, length : float
        m.
    """
    diagonal = np.hypot(width, length)
    # (width^3 + length^3 - diagonal^3) / (3 width length), the difference of the large ones by hand
    cubes = (width - (diagonal**2 + diagonal * length + length**2) / (diagonal + length)) * width / (3 * length)
    mean = width * np.arcsinh(length / width) + length * np.arcsinh(width / length) + cubes
    return np.asarray(wavenumber / np.pi * mean)


@dataclass(frozen=True)
class _Ends:
    """An opening between two half-spaces; arrays over frequency and direction.

    Attributes
    ----------
    radiation : complex array
        Radiation impedance of either end, Pa s/m.
    friction : array
        Resistance of either end, Pa s/m.
    """

    radiation: ComplexArray
    friction: RealArray

    def passage(
        self, impedance: ComplexArray, wavenumber: ComplexArray, depth: Numeric, met: Numeric, gas: Gas
    ) -> Passage:
        """Return what passes, from impedance (Pa s/m) and wavenumber of the gas inside.

        `met` is the squared pressure on the opening held still over that of a wave at right angles of the same power.
        """
        end, phase = self.radiation + self.friction, wavenumber * depth
        cosine, sine = np.cos(phase), np.sin(phase)
        # pressure and velocity in front over the velocity behind
        pressure, velocity = cosine * end + 1j * impedance * sine, cosine + 1j * sine / impedance * end
        blocked = pressure + end * velocity
        scale = 4 * gas.impedance * met / np.abs(blocked) ** 2
        taken = np.real((pressure + self.friction * velocity) * np.conj(velocity))
        return Passage(np.asarray(scale * self.radiation.real), np.asarray(scale * taken))


def hole_passage(
    frequency: RealArray, radius: Numeric, depth: Numeric, gas: Gas, angle: float | None = None
) -> Passage:
    """Return what passes a round hole in a rigid wall.

    Parameters
    ----------
    frequency : array
        Hz.
    radius, depth : float or array
        Of the hole, and of the wall, m.
    gas : Gas
    angle : float, optional
        Of a plane wave, degrees from the normal; a diffuse field when left out.

    Notes
    -----
    Wide holes carry more modes than this one: where that one would take less than its area does, it takes as much.
    """
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)
    k = omega / gas.sound_speed
    radiation = disc_impedance(k * radius)
    density, bulk = narrow_gas(omega, "tube", radius, gas)
    if angle is None:
        met: Numeric = np.maximum(1.0, 4 * radiation.real / (k * radius) ** 2)
    else:
        met = _directivity(k * radius * np.sin(np.deg2rad(angle))) / np.cos(np.deg2rad(angle))
    ends = _Ends(gas.impedance * radiation, end_friction(omega, "tube", gas) / 2)
    return ends.passage(np.sqrt(density * bulk), np.asarray(omega * np.sqrt(density / bulk)), depth, met, gas)


def _directivity(x: Numeric) -> RealArray:
    """Return the squared mean over a disc of a wave that runs along it, (2 J1(x) / x)^2."""
    argument = np.maximum(np.asarray(x, dtype=float), 1e-6)
    return np.asarray((2 * j1(argument) / argument) ** 2)


def slit_passage(
    frequency: RealArray, width: Numeric, length: Numeric, depth: Numeric, gas: Gas, angle: float | None = None, *,
    at_edge: bool = False,
) -> Passage:  # fmt: skip
    """Return what passes a slit in a rigid wall.

    Parameters
    ----------
    frequency : array, shape (n_frequency,)
        Hz.
    width, length, depth : float
        Of the slit, and of the wall, m; the width is much below the length.
    gas : Gas
    angle : float, optional
        Of a plane wave, degrees from the normal, its plane of incidence across the slit; a diffuse field when left out.
    at_edge : bool
        Whether the slit lies along the edge of two rigid planes on both sides, as that under a door: mirrored there, it
        radiates as one of twice the width, of which it is half.

    Notes
    -----
    Waves of a diffuse field that run along the slit at an angle leave ``k cos`` for the plane across it; Gauss' rule
    gives their mean over that angle. Long narrow slits get 8 Re(z) / abs(z total)^2, Gomperts & Kihlman's factor for a
    diffuse field. A slit shorter than half a wavelength radiates less, by `line_radiation`, and moves less air outside:
    no more than a rectangle does, `rectangle_reactance`. Wide ones take no less than their area does, as in
    `hole_passage`.
    """
    omega = 2 * np.pi * np.asarray(frequency, dtype=float)[..., None]
    k0, across = omega / gas.sound_speed, np.ones(1) if angle is not None else np.cos(_ALONG)
    k = k0 * across
    radiating = width * (2 if at_edge else 1)
    strip = strip_impedance(k * radiating)
    resistance = strip.real * line_radiation(k0 * length)
    reactance = np.minimum(strip.imag, rectangle_reactance(k, radiating, length))
    density, bulk = narrow_gas(omega, "slit", width / 2, gas)
    inside = decaying_root(omega**2 * density / bulk - k0**2 * (1 - across**2))
    if angle is None:
        # cos of the solid angle; the mean of cos over the half-plane across the slit is 2 / pi, over all directions 1/2
        met: Numeric = np.maximum(strip.real / (k * width / 2), 2 / np.pi) * 2 * across * _WEIGHTS
    else:
        sine, cosine = np.sin(np.deg2rad(angle)), np.cos(np.deg2rad(angle))
        doubled = np.maximum(1.0, strip.real / (k * width / 2))  # the squared pressure in an edge, of long waves
        met = np.sinc(k * width * sine / (2 * np.pi)) ** 2 / cosine * doubled
    radiation = gas.impedance / across * (resistance + 1j * reactance)
    ends = _Ends(radiation, end_friction(omega, "slit", gas) / 2)
    passed = ends.passage(omega * density / inside, inside, depth, met, gas)
    return Passage(passed.transmission.sum(axis=-1), passed.absorption.sum(axis=-1))
