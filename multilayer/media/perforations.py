"""Round holes through a plate: their added mass outside the plate, and the impedance of a hole after Maa."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas
from multilayer.media.narrow import narrow_gas


def end_length(hole_radius: Numeric, perforation: Numeric) -> Numeric:
    """Return the length, m, by which the air at one end of a hole lengthens it, its neighbours taken into account.

    N. Atalla & F. Sgard, J. Sound Vib. 303 (2007) 195-208: for round holes in a square array, ``0.48 sqrt(pi r^2)
    (1 - 1.13 x - 0.09 x^2 + 0.27 x^3)`` with x = 2 sqrt(perforation / pi), the diameter of a hole over the pitch.
    """
    x = 2 * np.sqrt(perforation / np.pi)
    length: Numeric = 0.48 * np.sqrt(np.pi) * hole_radius * (1 - 1.13 * x - 0.09 * x**2 + 0.27 * x**3)
    return length


def hole_pitch(hole_radius: Numeric, perforation: Numeric) -> Numeric:
    """Return the distance, m, between the centres of holes in a square array."""
    return hole_radius * np.sqrt(np.pi / perforation)


def maa_impedance(
    omega: Numeric, thickness: Numeric, hole_radius: Numeric, perforation: Numeric, end_tortuosity: Numeric, gas: Gas
) -> ComplexArray:
    """Return the pressure difference over the mean velocity, Pa s/m, of a micro-perforated plate.

    D.-Y. Maa, J. Acoust. Soc. Am. 104 (1998) 2861-2866: the exact flow in the tube, by Bessel functions, rather than
    the approximation used there for design; at the ends the mass of 0.85 diameters and the resistance
    sqrt(2 w density viscosity) / 2, both for the two ends together, and no interaction of the holes.

    Parameters
    ----------
    omega : array
        rad/s.
    thickness, hole_radius : float or array
        m.
    perforation : float or array
        Area of the holes over area of the plate.
    end_tortuosity : float or array
        Mean of the tortuosities of what the two faces touch, 1 for free air: factor of the mass at the ends.
    gas : Gas
    """
    inside = 1j * omega * narrow_gas(omega, "tube", hole_radius, gas)[0] * thickness
    outside = 1j * omega * gas.density * 0.85 * 2 * hole_radius * end_tortuosity
    friction = np.sqrt(2 * omega * gas.density * gas.viscosity) / 2
    return np.asarray((inside + outside + friction) / perforation)
