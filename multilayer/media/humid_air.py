"""Air by temperature, pressure and humidity.

Density: A. Picard, R. S. Davis, M. Glaser & K. Fujii, Metrologia 45 (2008) 149-155 (CIPM-2007). Sound speed and ratio
of the specific heats: O. Cramer, J. Acoust. Soc. Am. 93 (1993) 2510-2516. Viscosity, conductivity and specific heat:
P. T. Tsilingiris, Energy Conversion and Management 49 (2008) 1098-1110. `t` is in degrees Celsius, `T` in K, pressures
in Pa, `x_v` and `x_c` are mole fractions of water vapour and of carbon dioxide.
"""

from __future__ import annotations

import math

import numpy as np

from multilayer.arrays import ArrayLike, RealArray
from multilayer.media.gas import Gas
from multilayer.media.validity import warn_outside

_R = 8.314472  # J/(mol K), as CIPM-2007 is stated
_M_DRY, _M_VAPOUR = 28.96546e-3, 18.01528e-3  # kg/mol
_CARBON_DIOXIDE = 400e-6
_ZERO_CELSIUS = 273.15


def humid_air(temperature: float = 293.15, pressure: float = 101325.0, relative_humidity: float = 0.5) -> Gas:
    """Return air with water vapour.

    Parameters
    ----------
    temperature : float
        K; Cramer's formulae hold from 273.15 to 303.15 K (CIPM-2007 was made for 288 to 300 K).
    pressure : float
        Pa; from 75 to 102 kPa (Cramer; CIPM-2007 from 60 to 110 kPa).
    relative_humidity : float
        Fraction of saturation over water, 0 to 1.

    Warns
    -----
    ValidityWarning
        Outside the range common to Cramer's formulae.

    Notes
    -----
    Uncertainties their authors state: density 2.2e-5, sound speed 3e-4, ratio of the specific heats 3.2e-4, all
    relative; the transport properties are within about 1 % of reference data.
    """
    t = temperature - _ZERO_CELSIUS
    warn_outside("Cramer's sound speed", "temperatures (degC)", t, -1e-9, 30.0 + 1e-9)
    warn_outside("Cramer's sound speed", "pressures (Pa)", pressure, 75e3, 102e3)
    x_v = _vapour_fraction(t, pressure, relative_humidity)
    viscosity, conductivity = _transport(t, x_v)
    return Gas(
        density=_density(t, pressure, x_v),
        sound_speed=_polynomial(_SOUND_SPEED, t, pressure, x_v),
        viscosity=viscosity,
        prandtl=viscosity * _specific_heat(t, x_v) / conductivity,
        heat_capacity_ratio=_polynomial(_HEAT_RATIO, t, pressure, x_v),
        pressure=pressure,
        temperature=temperature,
        relative_humidity=relative_humidity,
    )


def air_absorption(
    frequency: ArrayLike,
    temperature: ArrayLike = 293.15,
    pressure: ArrayLike = 101325.0,
    relative_humidity: ArrayLike = 0.5,
) -> RealArray:
    """Return what free air takes from a plane wave's pressure, Np/m; arrays broadcast.

    ISO 9613-1:1993, section 6.2 and annex B: thermal and viscous losses, and relaxation of oxygen and nitrogen. 1 Np/m
    is 8.686 dB/m; twice the value is the power attenuation m of reverberation rooms, whose air of volume V absorbs as
    an area of 4 m V.

    Parameters
    ----------
    frequency : array
        Hz, above 0.
    temperature : array
        K; the standard states 10 % from 253 to 323 K.
    pressure : array
        Pa, below 200 kPa.
    relative_humidity : array
        Fraction of saturation, 0 to 1.
    """
    f, t = np.asarray(frequency, dtype=float), np.asarray(temperature, dtype=float)
    p, ratio = np.asarray(pressure, dtype=float) / 101325.0, t / 293.15
    saturation = 10 ** (-6.8346 * (273.16 / t) ** 1.261 + 4.6151)
    vapour = 100 * np.asarray(relative_humidity, dtype=float) * saturation / p  # molar, per cent
    oxygen = p * (24 + 4.04e4 * vapour * (0.02 + vapour) / (0.391 + vapour))
    nitrogen = p * ratio**-0.5 * (9 + 280 * vapour * np.exp(-4.170 * (ratio ** (-1 / 3) - 1)))
    relaxing = 0.01275 * np.exp(-2239.1 / t) / (oxygen + f**2 / oxygen)
    relaxing = relaxing + 0.1068 * np.exp(-3352.0 / t) / (nitrogen + f**2 / nitrogen)
    return np.asarray(f**2 * (1.84e-11 / p * np.sqrt(ratio) + ratio**-2.5 * relaxing))


def _vapour_fraction(t: float, p: float, relative_humidity: float) -> float:
    """Return the mole fraction of water vapour; CIPM-2007, appendix A."""
    T = t + _ZERO_CELSIUS
    saturation = math.exp(1.2378847e-5 * T**2 - 1.9121316e-2 * T + 33.93711047 - 6.3431645e3 / T)
    enhancement = 1.00062 + 3.14e-8 * p + 5.6e-7 * t**2
    return relative_humidity * enhancement * saturation / p


def _density(t: float, p: float, x_v: float) -> float:
    """Return the density, kg/m3; CIPM-2007, eq. (1) and appendix A, for 400 ppm of carbon dioxide."""
    ratio = p / (t + _ZERO_CELSIUS)
    first = 1.58123e-6 - 2.9331e-8 * t + 1.1043e-10 * t**2
    first += (5.707e-6 - 2.051e-8 * t) * x_v + (1.9898e-4 - 2.376e-6 * t) * x_v**2
    compressibility = 1 - ratio * first + ratio**2 * (1.83e-11 - 0.765e-8 * x_v**2)
    return ratio * _M_DRY / (compressibility * _R) * (1 - x_v * (1 - _M_VAPOUR / _M_DRY))


# a0 ... a15 of the approximate equations of Cramer 1993
_SOUND_SPEED = (
    331.5024, 0.603055, -0.000528, 51.471935, 0.1495874, -0.000782, -1.82e-7, 3.73e-8, -2.93e-10, -85.20931,
    -0.228525, 5.91e-5, -2.835149, -2.15e-13, 29.179762, 0.000486,
)  # fmt: skip
_HEAT_RATIO = (
    1.400822, -1.75e-5, -1.73e-7, -0.0873629, -0.0001665, -3.26e-6, 2.047e-8, -1.26e-10, 5.939e-14, -0.1199717,
    -0.0008693, 1.979e-6, -0.01104, -3.478e-16, 0.0450616, 1.82e-6,
)  # fmt: skip


def _polynomial(a: tuple[float, ...], t: float, p: float, x_v: float) -> float:
    """Return Cramer's polynomial."""
    x_c = _CARBON_DIOXIDE
    quadratics = (a[i] + a[i + 1] * t + a[i + 2] * t**2 for i in (0, 3, 6, 9))
    linear = math.fsum(q * factor for q, factor in zip(quadratics, (1.0, x_v, p, x_c), strict=True))
    return linear + a[12] * x_v**2 + a[13] * p**2 + a[14] * x_c**2 + a[15] * x_v * p * x_c


def _transport(t: float, x_v: float) -> tuple[float, float]:
    """Return viscosity, Pa s, and thermal conductivity, W/(m K), of the mixture; Tsilingiris 2008, section 3."""
    T = t + _ZERO_CELSIUS
    air = 1e-6 * _horner(T, -0.98601, 9.080125e-2, -1.17635575e-4, 1.2349703e-7, -5.7971299e-11)
    vapour = 1e-7 * _horner(t, 80.58131868, 0.4000549451)
    air_conducts = _horner(T, -2.276501e-3, 1.2598485e-4, -1.4815235e-7, 1.73550646e-10, -1.066657e-13, 2.47663035e-17)
    vapour_conducts = _horner(t, 1.761758242e-2, 5.558941059e-5, 1.663336663e-7)
    share_air = (1 - x_v) / (1 - x_v + x_v * _interaction(air / vapour, _M_DRY / _M_VAPOUR))
    share_vapour = x_v / (x_v + (1 - x_v) * _interaction(vapour / air, _M_VAPOUR / _M_DRY))
    return share_air * air + share_vapour * vapour, share_air * air_conducts + share_vapour * vapour_conducts


def _interaction(viscosities: float, masses: float) -> float:
    """Return Wilke's factor Phi of one gas in the other."""
    numerator = (1 + math.sqrt(viscosities / math.sqrt(masses))) ** 2
    return numerator * math.sqrt(2) / 4 / math.sqrt(1 + masses)


def _specific_heat(t: float, x_v: float) -> float:
    """Return the specific heat at constant pressure of the mixture, J/(kg K); Tsilingiris 2008, section 3."""
    T = t + _ZERO_CELSIUS
    air = 1e3 * _horner(T, 1.03409, -0.284887e-3, 0.7816818e-6, -0.4970786e-9, 0.1077024e-12)
    vapour = 1e3 * _horner(t, 1.86910989, -2.578421578e-4, 1.941058941e-5)
    masses = (1 - x_v) * _M_DRY, x_v * _M_VAPOUR
    return (masses[0] * air + masses[1] * vapour) / sum(masses)


def _horner(x: float, *coefficients: float) -> float:
    total = 0.0
    for coefficient in reversed(coefficients):
        total = total * x + coefficient
    return total
