"""The gas around and inside a stack."""

from __future__ import annotations

import math
from dataclasses import dataclass

GAS_CONSTANT = 8.314462618  # J/(mol K), CODATA 2018
MOLAR_MASS_DRY_AIR = 28.9647e-3  # kg/mol, ICAO Doc 7488


@dataclass(frozen=True)
class Gas:
    """Properties of a gas at rest.

    Attributes
    ----------
    density : float
        kg/m3.
    sound_speed : float
        Adiabatic, m/s.
    viscosity : float
        Dynamic (shear) viscosity, Pa s.
    prandtl : float
        Prandtl number.
    heat_capacity_ratio : float
        Ratio of the specific heats.
    pressure : float
        Static pressure, Pa.
    temperature : float
        K.
    relative_humidity : float
        Of saturation; it counts for the absorption of free air alone, see `media.humid_air.air_absorption`.
    """

    density: float
    sound_speed: float
    viscosity: float
    prandtl: float
    heat_capacity_ratio: float
    pressure: float
    temperature: float = 293.15
    relative_humidity: float = 0.5

    @property
    def impedance(self) -> float:
        """Characteristic impedance, Pa s/m."""
        return self.density * self.sound_speed


def dry_air(temperature: float = 293.15, pressure: float = 101325.0) -> Gas:
    """Return dry air as an ideal gas.

    Parameters
    ----------
    temperature : float
        K. Sutherland's law holds from about 100 to 1900 K, the constant heat capacity ratio within 0.3 % from
        230 to 330 K.
    pressure : float
        Pa.

    Notes
    -----
    Density and sound speed follow the ideal gas law; viscosity is Sutherland's formula with the constants of the
    U.S. Standard Atmosphere 1976, eq. (51).
    """
    specific = GAS_CONSTANT / MOLAR_MASS_DRY_AIR
    ratio = 1.4
    return Gas(
        density=pressure / (specific * temperature),
        sound_speed=math.sqrt(ratio * specific * temperature),
        viscosity=1.458e-6 * temperature**1.5 / (temperature + 110.4),
        prandtl=0.71,
        heat_capacity_ratio=ratio,
        pressure=pressure,
        temperature=temperature,
    )
