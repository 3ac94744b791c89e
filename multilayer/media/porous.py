"""Effective density and bulk modulus of the fluid in rigid pores: Johnson, Champoux, Allard, Lafarge, Pride.

Both are per unit volume of *material* (the porosity is divided out), so that pressure and volume velocity are
continuous across the face of an equivalent fluid. Time exp(+i w t): Im(density) <= 0, Im(modulus) >= 0.
No checks here: the layers validate their fields. They hold while pores are small beside the wavelength.
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
    """Return the effective density, kg/m3, of Johnson, Koplik & Dashen, J. Fluid Mech. 176 (1987) 379-402.

    Allard & Atalla 2009, eq. (5.50) with (5.51), divided by the porosity. `omega` in rad/s; arrays broadcast.
    """
    viscous = flow_resistivity * porosity / (1j * gas.density * tortuosity * omega)
    shape = 4j * tortuosity**2 * gas.viscosity * gas.density / (flow_resistivity * viscous_length * porosity) ** 2
    root = np.sqrt(1 + shape * omega)
    return np.asarray(tortuosity * gas.density / porosity * (1 + viscous * root))


def champoux_allard_modulus(omega: Numeric, porosity: Numeric, thermal_length: Numeric, gas: Gas) -> ComplexArray:
    """Return the effective bulk modulus, Pa, of Champoux & Allard, J. Appl. Phys. 70 (1991) 1975-1979.

    Allard & Atalla 2009, eq. (5.51), divided by the porosity. `omega` in rad/s; arrays broadcast.
    """
    thermal = 1j * gas.density * gas.prandtl * thermal_length**2 / gas.viscosity * omega
    exchange = 1 + 8 / thermal * np.sqrt(1 + thermal / 16)
    return modulus_of_exchange(exchange, porosity, gas)


def lafarge_modulus(
    omega: Numeric, porosity: Numeric, thermal_length: Numeric, thermal_permeability: Numeric, gas: Gas
) -> ComplexArray:
    """Return the effective bulk modulus, Pa, of Lafarge, Lemarinier, Allard & Tarnow (1997).

    J. Acoust. Soc. Am. 102, 1995-2006; Allard & Atalla 2009, section 5.4.2. It is Champoux and Allard's for
    ``thermal_permeability = porosity thermal_length^2 / 8``, m2. `omega` in rad/s; arrays broadcast.
    """
    rate = _thermal_rate(omega, porosity, thermal_permeability, gas)
    shape = 8 * thermal_permeability / (porosity * thermal_length**2)
    return modulus_of_exchange(1 + np.sqrt(1 + shape / 2 * rate) / rate, porosity, gas)


def pride_density(
    omega: Numeric,
    porosity: Numeric,
    flow_resistivity: Numeric,
    tortuosity: Numeric,
    viscous_length: Numeric,
    static_viscous_tortuosity: Numeric,
    gas: Gas,
) -> ComplexArray:
    """Return the effective density, kg/m3, with its exact limit at low frequencies.

    S. R. Pride, F. D. Morgan & A. F. Gangi, Phys. Rev. B 47 (1993) 4964-4978, corrected by Lafarge (Allard &
    Atalla 2009, section 5.4.1): Re(density) tends to `static_viscous_tortuosity` gas density / porosity. It is
    Johnson's for ``static_viscous_tortuosity = tortuosity (1 + M / 4)``, M = 8 tortuosity viscosity / (sigma phi
    Lambda^2).
    """
    rate = 1j * omega * gas.density * tortuosity / (flow_resistivity * porosity)
    shape = 8 * gas.viscosity * tortuosity / (flow_resistivity * porosity * viscous_length**2)
    correction = _pride(rate, shape, static_viscous_tortuosity / tortuosity)
    return np.asarray(tortuosity * gas.density / porosity * (1 + correction / rate))


def pride_lafarge_modulus(
    omega: Numeric,
    porosity: Numeric,
    thermal_length: Numeric,
    thermal_permeability: Numeric,
    static_thermal_tortuosity: Numeric,
    gas: Gas,
) -> ComplexArray:
    """Return the effective bulk modulus, Pa, with its exact limit at low frequencies.

    D. Lafarge, thesis, Universite du Maine (1993); Allard & Atalla 2009, section 5.4.2. It is Lafarge's for
    ``static_thermal_tortuosity = 1 + M' / 4``, M' = 8 k0' / (phi Lambda'^2).
    """
    rate = _thermal_rate(omega, porosity, thermal_permeability, gas)
    shape = 8 * thermal_permeability / (porosity * thermal_length**2)
    return modulus_of_exchange(1 + _pride(rate, shape, static_thermal_tortuosity) / rate, porosity, gas)


def _thermal_rate(omega: Numeric, porosity: Numeric, thermal_permeability: Numeric, gas: Gas) -> Numeric:
    """Return i w over the rate at which heat leaves the pores."""
    return 1j * omega * gas.density * gas.prandtl * thermal_permeability / (gas.viscosity * porosity)


def _pride(rate: Numeric, shape: Numeric, static: Numeric) -> ComplexArray:
    """Return F = 1 - P + P sqrt(1 + M rate / (2 P^2)), P = M / (4 (static - 1))."""
    p = shape / (4 * (static - 1))
    return np.asarray(1 - p + p * np.sqrt(1 + shape / (2 * p**2) * rate))


def modulus_of_exchange(exchange: Numeric, porosity: Numeric, gas: Gas) -> ComplexArray:
    """Return the bulk modulus, Pa, from the thermal counterpart of the dynamic tortuosity.

    `exchange` is infinite for isothermal and 1 for adiabatic compression: Lafarge's alpha'.
    """
    ratio = gas.heat_capacity_ratio
    return np.asarray(ratio * gas.pressure / porosity / (ratio - (ratio - 1) / exchange))


def limp_density(density: Numeric, porosity: Numeric, frame_density: Numeric, gas: Gas) -> ComplexArray:
    """Return the effective density, kg/m3, of pores in a frame without stiffness that moves with the gas.

    R. Panneton, J. Acoust. Soc. Am. 122 (2007) EL217-EL222: `density` is that of the same pores in a rigid
    frame, `frame_density` the mass of the frame per volume of material. The bulk modulus stays as it is.
    """
    total = frame_density + porosity * gas.density
    return np.asarray((total * density - gas.density**2) / (total + density - 2 * gas.density))
