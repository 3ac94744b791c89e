"""Gas between rigid, isothermal walls: circular tubes and slits, with viscosity and heat conduction.

C. Zwikker & C. W. Kosten, Sound Absorbing Materials (1949); M. R. Stinson, J. Acoust. Soc. Am. 89 (1991) 550-558, who
derives it from Kirchhoff's theory; Allard & Atalla 2009, sections 4.2-4.5. The low reduced frequency model: pressure is
uniform across the tube or slit. Per unit volume of *gas*; time exp(+i w t).
"""

from __future__ import annotations

import numpy as np
from scipy.special import ive

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas
from multilayer.media.porous import modulus_of_exchange

# Order of a modified Bessel function in the mean of the profile over the section: 0 for a circle, -1/2 for a slit
_ORDER = {"tube": 0.0, "slit": -0.5}


def narrow_gas(omega: Numeric, shape: str, half_width: Numeric, gas: Gas) -> tuple[ComplexArray, ComplexArray]:
    """Return effective density, kg/m3, and bulk modulus, Pa, of the gas in a tube or slit.

    Parameters
    ----------
    omega : array
        rad/s.
    shape : {'tube', 'slit'}
    half_width : float or array
        Radius of the tube, or half the distance between the walls of the slit, m.
    gas : Gas

    Notes
    -----
    For air, Stinson's limits are a half width above 1e-5 m and half_width f^(3/2) below 1e4 m s^(-3/2).
    """
    order = _ORDER[shape]
    shear = half_width * np.sqrt(1j * omega * gas.density / gas.viscosity)
    moving, adiabatic = _core(shear, order), _core(np.sqrt(gas.prandtl) * shear, order)
    return np.asarray(gas.density / moving), modulus_of_exchange(1 / adiabatic, 1.0, gas)


def _core(z: Numeric, order: float) -> ComplexArray:
    """Return the mean over the section of 1 - (boundary layer): I_(n+2)(z) / I_n(z), free of cancellation.

    It equals 1 - 2 J1(s) / (s J0(s)), s = z / sqrt(i), for the tube and 1 - tanh(z) / z for the slit.
    """
    argument = np.asarray(z, dtype=complex)
    return np.asarray(ive(order + 2, argument) / ive(order, argument))
