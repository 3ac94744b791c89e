"""Fibrous materials by their flow resistivity alone: power laws fitted to impedance-tube data.

Per unit volume of material, time exp(+i w t), as in `media.porous`.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas

VALID = (0.01, 1.0)  # f / sigma, m3/kg: the range of the measurements


def delany_bazley(omega: Numeric, gas: Gas, *, flow_resistivity: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return density, kg/m3, and bulk modulus, Pa, of Delany & Bazley.

    M. E. Delany & E. N. Bazley, Applied Acoustics 3 (1970) 105-116: characteristic impedance and wavenumber of fibrous
    materials of porosity near 1, from measurements at 0.01 <= f / sigma <= 1 (SI, m3/kg). Below that range the
    surface of a layer may even give off power (Miki 1990).
    """
    x = 1e3 * omega / (2 * np.pi) / flow_resistivity
    return _fluid(gas, 1 + 9.08 * x**-0.75 - 11.9j * x**-0.73, 1 + 10.8 * x**-0.70 - 10.3j * x**-0.59)


def miki(omega: Numeric, gas: Gas, *, flow_resistivity: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return density, kg/m3, and bulk modulus, Pa, of Miki.

    Y. Miki, J. Acoust. Soc. Jpn. (E) 11 (1990) 19-24: Delany and Bazley's data, impedance and wavenumber each with one
    exponent as causality wants. Fitted for 0.01 <= f / sigma <= 1 (SI, m3/kg); it goes on smoothly below, where in the
    end it gives off a little power, too.
    """
    x = 1e3 * omega / (2 * np.pi) / flow_resistivity
    return _fluid(gas, 1 + (5.50 - 8.43j) * x**-0.632, 1 + (7.81 - 11.41j) * x**-0.618)


def _fluid(gas: Gas, impedance: Numeric, index: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return density and modulus from impedance and wavenumber relative to those of the free gas."""
    stiffness = gas.density * gas.sound_speed**2
    return np.asarray(gas.density * impedance * index), np.asarray(stiffness * impedance / index)
