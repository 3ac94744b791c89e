"""Paths beside a construction, as shares of the power that comes in: holes, and links between its leaves.

A diffuse field of mean square pressure p^2 brings the intensity p^2/(4 rho c); at a rigid wall, which blocks it, the
mean square pressure is 2 p^2. Shares add up, as paths are not coherent over a band.
"""

from __future__ import annotations

import numpy as np
from scipy.special import j1, struve

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.experiments.levels.sound_field import bending_stiffness, surface_density
from multilayer.layers.base import ElasticLayer, Layer
from multilayer.matrix.wave import Wave
from multilayer.media.gas import Gas
from multilayer.media.narrow import narrow_gas


def hole_transmission(frequency: RealArray, radius: Numeric, depth: Numeric, gas: Gas) -> RealArray:
    """Return the power that a round hole lets through over that which comes onto its area in a diffuse field.

    A tube with viscosity and heat conduction between two openings, each with the radiation impedance z of a piston in a
    baffle: the blocked pressure 2 p^2 drives the velocity ``v = p/(2 z cos kd + i (Z + z^2/Z) sin kd)`` at its far end.
    Holds for holes that are small beside a wavelength, to 2 pi a/lambda of about 1.

    M. C. Gomperts & T. Kihlman, Acustica 18 (1967) 144-150; G. P. Wilson & W. W. Soroka, J. Acoust. Soc. Am. 37 (1965)
    286-297, for the piston at both ends. Losses of the tube: `media.narrow`.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    radius, depth : float or array, shape (m, 1)
        m.
    gas : Gas

    Notes
    -----
    A thin plate's hole has a share of ``9 pi^2/64 = 1.39`` at low frequencies without losses.
    """
    omega = 2 * np.pi * frequency
    density, bulk = narrow_gas(omega, "tube", radius, gas)
    wavenumber, impedance = omega * np.sqrt(density / bulk), np.sqrt(density * bulk)
    end = gas.impedance * _piston(2 * omega / gas.sound_speed * radius)
    phase = wavenumber * depth
    driven = 2 * end * np.cos(phase) + 1j * (impedance + end**2 / impedance) * np.sin(phase)
    return np.asarray(8 * gas.impedance * end.real / np.abs(driven) ** 2)


def _piston(argument: Numeric) -> ComplexArray:
    """Return the radiation impedance of a round piston in a baffle over rho c; its argument is 2 k a."""
    x = np.asarray(argument, dtype=float)
    return np.asarray(1 - 2 * j1(x) / x + 2j * struve(1, x) / x)


def link_transmission(
    frequency: RealArray, front: ElasticLayer, back: ElasticLayer, spacing: Numeric, compliance: Numeric, gas: Gas
) -> RealArray:
    """Return the share of the power that linear links between two leaves carry past the cavity.

    The front leaf moves by mass alone, the links force the back leaf along lines, which radiates from its near field:
    ``tau = 64 rho^2 c^3 / ([g^2 + (4 w^(3/2) m1 m2 c C - g)^2] b w^2)``, ``g = m1 sqrt(wc2) + m2 sqrt(wc1)``; between
    the resonance of the leaves on the air and their critical frequencies.

    J. L. Davy 1991, as in T. E. Vigran, Building Acoustics, Taylor & Francis 2008, eq. (8.27); rigid links: B. H.
    Sharp, Noise Control Eng. 11 (1978) 53-63.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    front, back : ElasticLayer
        The leaves.
    spacing : float or array, shape (m, 1)
        b, from link to link, m.
    compliance : float or array, shape (m, 1)
        C, of a link per length, m2/N; 0 where it is rigid.
    gas : Gas
    """
    omega, c = 2 * np.pi * frequency, gas.sound_speed
    masses = [np.mean(np.asarray(surface_density(leaf)).real) for leaf in (front, back)]
    critical = [_critical(leaf, mass, frequency, gas) for leaf, mass in zip((front, back), masses, strict=True)]
    g = masses[0] * np.sqrt(critical[1]) + masses[1] * np.sqrt(critical[0])
    soft = 4 * omega**1.5 * masses[0] * masses[1] * c * compliance - g
    return np.asarray(64 * gas.density**2 * c**3 / ((g**2 + soft**2) * spacing * omega**2))


def _critical(leaf: ElasticLayer, mass: Numeric, frequency: RealArray, gas: Gas) -> Numeric:
    """Return the critical frequency of a plate, rad/s."""
    middle = np.array([np.sqrt(frequency[0] * frequency[-1])])
    stiffness = np.abs(bending_stiffness(leaf, Wave(middle, np.zeros(1), gas)))
    critical: Numeric = gas.sound_speed**2 * np.sqrt(mass / np.mean(stiffness))
    return critical


def depth_of(layers: tuple[Layer, ...]) -> float:
    """Return the thickness of all layers together, m."""
    return float(sum(np.mean(getattr(layer, "thickness", None) or 0.0) for layer in layers))
