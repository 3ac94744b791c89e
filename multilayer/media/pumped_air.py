"""Air that is pumped through the pores of a disc between sealed faces, and leaves by its rim."""

from __future__ import annotations

import numpy as np
from scipy.special import jve

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas


def pumped_air_stiffness(omega: Numeric, radius: float, pore_density: Numeric, pore_modulus: Numeric) -> ComplexArray:
    """Return the contribution of the gas in the pores to the axial stiffness of a disc in uniform compression, Pa.

    Parameters
    ----------
    omega : array
        rad/s.
    radius : float
        m.
    pore_density, pore_modulus : complex array
        Equivalent fluid per volume of material, kg/m3 and Pa; see `media.porous`.

    Notes
    -----
    The pressure obeys ``p'' + p'/r + k^2 p = -k^2 K e`` (e the dilatation, k^2 = w^2 rho / K) and is zero at the rim;
    its mean is ``-K e (1 - 2 J1(x)/(x J0(x)))``, x = k R. From 0 at low frequencies it rises to K, that of sealed
    pores. The frame's inertia across the disc and its bulging are left out.
    """
    x = omega * radius * np.sqrt(np.asarray(pore_density / pore_modulus, dtype=complex))
    # scaled Bessel functions: their exponentials cancel in the ratio
    return np.asarray(pore_modulus * (1 - 2 * jve(1, x) / (x * jve(0, x))))


def cylindrical_length(porosity: float, flow_resistivity: float, tortuosity: float, gas: Gas) -> float:
    """Return the viscous length, m, of cylindrical pores of this porosity and resistivity (N s/m4): their radius.

    Poiseuille's flow; Allard & Atalla 2009, chapter 5.
    """
    return float(np.sqrt(8 * gas.viscosity * tortuosity / (porosity * flow_resistivity)))
