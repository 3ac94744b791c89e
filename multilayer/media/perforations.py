"""Holes and slits through a plate: their added mass outside, their impedance, what flow and loud sound add to it."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray
from multilayer.media.gas import Gas
from multilayer.media.narrow import narrow_gas

DISCHARGE = 0.76
"""Discharge coefficient of sharp-edged holes: area of the jet over that of the hole (Melling 1973)."""
_ENDS = {"tube": 2 * (1 + 0.82), "slit": 2 * (1 + 2 / np.pi)}  # of both ends, in surface resistances: `end_friction`


def end_length(hole_radius: Numeric, perforation: Numeric) -> Numeric:
    """Return the length, m, by which the air at one end of a hole lengthens it, its neighbours taken into account.

    N. Atalla & F. Sgard, J. Sound Vib. 303 (2007) 195-208: for round holes in a square array, ``0.48 sqrt(pi r^2)
    (1 - 1.13 x - 0.09 x^2 + 0.27 x^3)`` with x = 2 sqrt(perforation / pi), the diameter of a hole over the pitch.
    """
    x = 2 * np.sqrt(perforation / np.pi)
    length: Numeric = 0.48 * np.sqrt(np.pi) * hole_radius * (1 - 1.13 * x - 0.09 * x**2 + 0.27 * x**3)
    return length


def slit_end_length(slit_width: Numeric, perforation: Numeric) -> Numeric:
    """Return the length, m, by which the air at one end of a slit lengthens it, its neighbours taken into account.

    ``-(w / pi) ln sin(pi perforation / 2)``: J. M. A. Smits & C. W. Kosten, Acustica 1 (1951) 114-122; U. R.
    Kristiansen & T. E. Vigran, Appl. Acoust. 43 (1994) 39-48. Exact for a grating of parallel slits in a thin sheet; of
    a thick one, in which the air leaves more evenly, it is up to a tenth of the width more.
    """
    length: Numeric = -slit_width / np.pi * np.log(np.sin(np.pi * perforation / 2))
    return length


def duct_end_length(hole_radius: Numeric, duct_radius: Numeric) -> Numeric:
    """Return the length, m, by which the air at its end lengthens a round hole that opens into a round duct.

    J. Kergomard & A. Garcia, J. Sound Vib. 114 (1987) 465-479: ``0.82 r (1 - 1.35 x + 0.31 x^3)``, x = r / R, on one
    axis; it vanishes near x = 0.9.
    """
    x = hole_radius / duct_radius
    length: Numeric = 0.82 * hole_radius * (1 - 1.35 * x + 0.31 * x**3)
    return length


def hole_pitch(hole_radius: Numeric, perforation: Numeric) -> Numeric:
    """Return the distance, m, between the centres of holes in a square array."""
    return hole_radius * np.sqrt(np.pi / perforation)


def maa_impedance(
    omega: Numeric, thickness: Numeric, hole_radius: Numeric, perforation: Numeric, end_tortuosity: Numeric, gas: Gas
) -> ComplexArray:
    """Return the pressure difference over the mean velocity, Pa s/m, of a micro-perforated plate.

    D.-Y. Maa, J. Acoust. Soc. Am. 104 (1998) 2861-2866: the exact flow in the tube, by Bessel functions, rather than
    the approximation used there for design; at the ends the mass of 0.85 diameters and one `surface_resistance`, both
    for the two ends together, and no interaction of the holes. That resistance is a quarter of what `end_friction` has
    of sharp edges: small beside the friction inside of holes as narrow as Maa's, too little of wide ones.

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
    ends = 0.85 * 2 * hole_radius * end_tortuosity
    friction = surface_resistance(omega, gas)
    return sheet_impedance(omega, "tube", hole_radius, thickness, ends, friction, gas) / perforation


def maa_slit_impedance(
    omega: Numeric, thickness: Numeric, slit_width: Numeric, perforation: Numeric, end_tortuosity: Numeric, gas: Gas
) -> ComplexArray:
    """Return the pressure difference over the mean velocity, Pa s/m, of a plate with narrow slits.

    D.-Y. Maa, Acta Acust. 25 (2000) 481-485 (in Chinese): the exact flow in a slit and the resistance of the ends as of
    `maa_impedance`; the mass of the ends is that of `slit_end_length`, with the interaction of long parallel slits, in
    place of his elliptic integral for single ones. Parameters as of `maa_impedance`.
    """
    ends = 2 * slit_end_length(slit_width, perforation) * end_tortuosity
    friction = surface_resistance(omega, gas)
    return sheet_impedance(omega, "slit", slit_width / 2, thickness, ends, friction, gas) / perforation


def sheet_impedance(
    omega: Numeric, shape: str, half_width: Numeric, thickness: Numeric, ends: Numeric, friction: Numeric, gas: Gas
) -> ComplexArray:
    """Return the pressure difference over the mean velocity in a hole, Pa s/m.

    Parameters
    ----------
    omega : array
        rad/s.
    shape : {'tube', 'slit'}
    half_width : float or array
        Radius, or half of the slit's width, m.
    thickness : float or array
        Length of the hole, m.
    ends : float or array
        What the air outside adds to it at both ends together, m.
    friction : array
        Resistance of both ends together, Pa s/m.
    gas : Gas
    """
    inside = 1j * omega * narrow_gas(omega, shape, half_width, gas)[0] * thickness
    outside = 1j * omega * gas.density * ends
    return np.asarray(inside + outside + friction)


def end_friction(omega: Numeric, shape: str, gas: Gas) -> RealArray:
    """Return the resistance, Pa s/m, that both ends of a hole or slit have by friction on the walls near their edges.

    Where the boundary layer is thin beside the opening, friction takes the surface resistance times the squared
    velocity along all walls. That integral is the change of the inertance, ``density (h + 2 end) / area``, by a step of
    all walls into the gas (J. Hadamard's formula for a domain's energy): the plate gets thicker at both faces and the
    opening narrower. Of the mass at the ends that is, in surface resistances, ``2 (1 + 0.82)`` of a round hole, 0.82
    its end over its radius, and ``2 (1 + 2 / pi)`` of a slit by `slit_end_length`, both without neighbours, by which it
    hardly changes. U. Ingard, J. Acoust. Soc. Am. 25 (1953) 1037-1061, estimates 4 of holes; the lengthened pore of
    Atalla & Sgard 2007 has 3.4. Holds for right-angled edges; round ones have less, burrs more.

    Parameters
    ----------
    omega : array
        rad/s.
    shape : {'tube', 'slit'}
    gas : Gas
    """
    return np.asarray(_ENDS[shape] * surface_resistance(omega, gas))


def surface_resistance(omega: Numeric, gas: Gas) -> RealArray:
    """Return twice the power over area that a gas loses sliding along a wall, over its squared velocity, Pa s/m."""
    return np.asarray(np.sqrt(2 * omega * gas.density * gas.viscosity) / 2)


def jet_resistance(
    hole_velocity: Numeric, bias_velocity: Numeric, perforation: Numeric, discharge: Numeric, gas: Gas
) -> Numeric:
    """Return the pressure difference over the velocity in a hole, Pa s/m, that jets out of the holes add.

    A quasi-steady jet takes the pressure ``density (1 - perforation^2) u abs(u) / (2 discharge^2)``. T. H. Melling, J.
    Sound Vib. 29 (1973) 1-65: of a tone the fundamental of this is 8 / (3 pi) times the peak velocity, 1.2 times the
    rms, in place of abs(u). Beside a steady flow U faster than the sound, the same law gives 2 U in that place. A. B.
    Bauer, J. Aircraft 14 (1977) 720-728, found 1.15 where 1 / discharge^2 stands of a steady flow: `discharge` 0.93.

    Parameters
    ----------
    hole_velocity : float or array
        Rms velocity of the sound in the holes, m/s, without a steady flow; 0 where there is one.
    bias_velocity : float or array
        Mean velocity of a steady flow in the holes, m/s.
    perforation, discharge : float or array
    gas : Gas
    """
    slope = 8 * np.sqrt(2) / (3 * np.pi) * hole_velocity + 2 * bias_velocity
    resistance: Numeric = gas.density * (1 - perforation**2) / (2 * discharge**2) * slope
    return resistance


def grazing_resistance(mach: Numeric, perforation: Numeric, gas: Gas) -> Numeric:
    """Return the pressure difference over the velocity in a hole, Pa s/m, that a flow along the plate adds.

    A. W. Guess, J. Sound Vib. 40 (1975) 119-137: ``0.3 (1 - perforation^2) M`` times the gas's impedance.
    """
    resistance: Numeric = 0.3 * (1 - perforation**2) * mach * gas.impedance
    return resistance


def grazing_mass(mach: Numeric) -> Numeric:
    """Return the share of the mass outside the holes that a flow along the plate leaves; Guess 1975."""
    share: Numeric = 1 / (1 + 305 * mach**3)
    return share
