"""Warnings where a formula is used outside the range it was made for; the computation goes on."""

from __future__ import annotations

import warnings

import numpy as np

from multilayer.arrays import ArrayLike, Numeric, RealArray
from multilayer.errors import ValidityWarning
from multilayer.media.gas import Gas

_LONG_WAVE = 1.0  # largest wavenumber of the free gas times the size of a pore
_THIN = 6.0  # least wavelength of bending over the thickness of a thin plate
_BENDS = 0.5  # trace wavenumber over that of bending, below which a sixteenth of a plate's impedance is its stiffness


def warn_outside(
    model: str, quantity: str, value: Numeric, low: float, high: float, frequency: ArrayLike | None = None
) -> None:
    """Warn once when `value` leaves [low, high].

    Parameters
    ----------
    model, quantity : str
        The model, and the quantity whose range is limited, for the message.
    value : float or array
    low, high : float
    frequency : array, optional
        Hz, broadcasts against `value`; the message names the frequencies concerned.
    """
    values = np.asarray(value, dtype=float)
    outside = (values < low) | (values > high)
    if not np.any(outside):
        return
    actual = _range(values[outside])
    at = "" if frequency is None else f" ({_range(np.broadcast_arrays(frequency, outside)[0], outside)} Hz)"
    warnings.warn(
        f"{model} holds for {quantity} {_interval(low, high)}; here it is {actual}{at}", ValidityWarning, stacklevel=3
    )


def _interval(low: float, high: float) -> str:
    if np.isinf(low):
        return f"up to {high:g}"
    return f"from {low:g}" if np.isinf(high) else f"from {low:g} to {high:g}"


def _range(values: RealArray, where: ArrayLike = True) -> str:
    chosen = values[np.broadcast_to(where, values.shape)]
    low, high = f"{chosen.min():.4g}", f"{chosen.max():.4g}"
    return low if low == high else f"{low} to {high}"


def warn_short_waves(model: str, pore_size: Numeric, omega: Numeric, gas: Gas) -> None:
    """Warn where pores are no longer small beside the wavelength, 2 pi size / wavelength > 1.

    Homogenised pores presuppose that the gas in a pore moves as if incompressible (Johnson, Koplik & Dashen, J. Fluid
    Mech. 176 (1987) 379-402, section 2); the limit of 1 is the end of that, not its safe side.

    Parameters
    ----------
    model : str
    pore_size : float or array
        m.
    omega : array
        rad/s.
    gas : Gas
    """
    frequency = np.asarray(omega) / (2 * np.pi)
    size = omega / gas.sound_speed * pore_size
    warn_outside(model, "2 pi pore size / wavelength", size, -np.inf, _LONG_WAVE, frequency)


def warn_thick_plate(
    model: str, thickness: Numeric, stiffness: Numeric, surface_density: Numeric, wavenumber: Numeric, omega: Numeric
) -> None:
    """Warn where a plate is not thin: it bends, and its bending waves are shorter than six thicknesses.

    Shear and the rotation of its sections slow them down: at six thicknesses by 8 % (R. D. Mindlin, J. Appl. Mech. 18
    (1951) 31-38; Poisson's ratio 0.2).

    Parameters
    ----------
    model : str
    thickness : float or array
        m.
    stiffness : complex or array
        N m.
    surface_density : float or array
        kg/m2.
    wavenumber, omega : array
        Trace wavenumber, rad/m, and rad/s.
    """
    bending = np.sqrt(np.asarray(omega) * np.sqrt(surface_density / np.abs(stiffness)))
    length = 2 * np.pi / (bending * thickness)
    if np.all(length >= _THIN):
        return
    met = np.where(np.abs(wavenumber) > _BENDS * bending, length, np.inf)
    frequency = np.asarray(omega) / (2 * np.pi)
    warn_outside(model, "bending wavelength / thickness", met, _THIN, np.inf, frequency)
