"""Links between the leaves of a construction, as a share of the power that comes in.

A formula that takes arrays of samples; `response.links` solves the stack with its links, for one of them.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import Numeric, RealArray
from multilayer.experiments.levels.sound_field import bending_stiffness, surface_density
from multilayer.layers.base import ElasticLayer
from multilayer.matrix.wave import Wave
from multilayer.media.gas import Gas


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
