"""Pores with a log-normal distribution of sizes: Horoshenkov and Swift's Pade approximation, three parameters.

Per unit volume of material, time exp(+i w t), as in `media.porous`.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas
from multilayer.media.porous import modulus_of_exchange


def horoshenkov_swift(
    omega: Numeric, gas: Gas, *, porosity: Numeric, median_pore_size: Numeric, pore_size_deviation: Numeric
) -> tuple[ComplexArray, ComplexArray]:
    """Return density, kg/m3, and bulk modulus, Pa, of pores whose radius varies along them log-normally.

    K. V. Horoshenkov & M. J. Swift, J. Acoust. Soc. Am. 110 (2001) 2371-2378, for the approximation; K. V. Horoshenkov,
    A. Hurrell & J.-P. Groby, J. Acoust. Soc. Am. 145 (2019) 2512-2517, for its coefficients, which supersede those of
    2001: flow resistivity and tortuosity follow from the distribution.

    Parameters
    ----------
    omega : array
        rad/s.
    gas : Gas
    porosity : float or array
    median_pore_size : float or array
        Median radius, m.
    pore_size_deviation : float or array
        Standard deviation of the radius in phi units, that is of its logarithm to base 2. At 0 the pores are straight
        tubes.
    """
    spread = (pore_size_deviation * np.log(2)) ** 2
    # squares of w times the low-frequency time constants of flow and of heat
    flow = 1j * omega * gas.density * median_pore_size**2 / (8 * gas.viscosity)
    viscous = flow * np.exp(-6 * spread)
    thermal = flow * gas.prandtl * np.exp(6 * spread)
    tortuosity = np.exp(4 * spread)
    density = tortuosity * gas.density / porosity * (1 + _pade(viscous, -spread / 2) / viscous)
    return np.asarray(density), modulus_of_exchange(1 + _pade(thermal, 1.5 * spread) / thermal, porosity, gas)


def flow_resistivity(porosity: Numeric, median_pore_size: Numeric, pore_size_deviation: Numeric, gas: Gas) -> Numeric:
    """Return the flow resistivity, N s/m4, of such pores; Horoshenkov et al. 2019."""
    spread = (pore_size_deviation * np.log(2)) ** 2
    resistivity: Numeric = 8 * gas.viscosity * np.exp(10 * spread) / (porosity * median_pore_size**2)
    return resistivity


def _pade(square: Numeric, exponent: Numeric) -> ComplexArray:
    """Return (1 + t3 e + t1 e^2) / (1 + t3 e), e^2 = square, t1 = 1/3, t2 = exp(exponent) / sqrt 2, t3 = t1 / t2."""
    root = np.sqrt(square)
    slope = np.sqrt(2) / 3 * np.exp(-exponent) * root
    return np.asarray((1 + slope + square / 3) / (1 + slope))
