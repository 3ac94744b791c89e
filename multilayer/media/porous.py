"""Effective density and bulk modulus of the fluid in rigid pores.

Both are per unit volume of *material* (the porosity is divided out), so that pressure and volume velocity are
continuous across the face of an equivalent fluid. Time exp(+i w t): Im(density) <= 0, Im(modulus) >= 0.
No checks here: the layers validate their fields.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.media.gas import Gas


def johnson_density(
    omega: Numeric,
    porosity: Numeric,
    flow_resistivity: Numeric,
    tortuosity: Numeric,
    viscous_length: Numeric,
    gas: Gas,
) -> ComplexArray:
    """Return the effective density, kg/m3, of Johnson, Koplik & Dashen (1987).

    Allard & Atalla 2009, eq. (5.50) with (5.51), divided by the porosity. `omega` in rad/s; arrays broadcast.
    """
    viscous = flow_resistivity * porosity / (1j * omega * gas.density * tortuosity)
    shape = 4j * tortuosity**2 * gas.viscosity * gas.density * omega
    root = np.sqrt(1 + shape / (flow_resistivity * viscous_length * porosity) ** 2)
    return np.asarray(tortuosity * gas.density / porosity * (1 + viscous * root))


def champoux_allard_modulus(omega: Numeric, porosity: Numeric, thermal_length: Numeric, gas: Gas) -> ComplexArray:
    """Return the effective bulk modulus, Pa, of Champoux & Allard (1991).

    Allard & Atalla 2009, eq. (5.51), divided by the porosity. `omega` in rad/s; arrays broadcast.
    """
    thermal = 1j * omega * gas.density * gas.prandtl * thermal_length**2 / gas.viscosity
    exchange = 1 + 8 / thermal * np.sqrt(1 + thermal / 16)
    ratio = gas.heat_capacity_ratio
    return np.asarray(ratio * gas.pressure / porosity / (ratio - (ratio - 1) / exchange))
