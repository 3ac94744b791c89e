"""What each tolerance makes results scatter by: slopes at the nominal stack times the standard deviation of the draws.

To first order: contributions of fields that scatter independently add up by their squares. Slopes are exact
(`response.derivatives`) by real fields of layers, of plane waves and diffuse fields on a stack alone; all others are
differences of the whole response.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.paths import locate, with_values
from multilayer.response.derivatives import diffuse_field_derivatives, plane_wave_derivatives
from multilayer.response.finite_size import Window, finite_absorption, finite_absorption_slope, radiation_impedance
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import DiffuseIncidence, PlaneIncidence
from multilayer.simulation.tolerances import allowed
from multilayer.stack import Stack

Slopes = dict[str, RealArray]  # by quantity
_STEP = 0.5  # of the standard deviation; a diffuse field is known to 1e-4 only
_HALVINGS = 10  # of a step that leads where a field is not allowed


def standard_deviation(drawn: NDArray[Any]) -> float:
    """Return that of what was drawn; of complex values, whose phase does not scatter, that of the absolute value."""
    return float(np.std(np.abs(drawn) if np.iscomplexobj(drawn) else drawn))


def by_derivatives(
    stack: Stack,
    paths: Sequence[str],
    frequency: RealArray,
    incidence: PlaneIncidence | DiffuseIncidence,
    window: Window | None,
    effort: Mapping[str, Any],
) -> Slopes:
    """Return the exact slopes of absorption and transmission loss by real fields of layers, shape (n_fields, ...).

    Parameters
    ----------
    stack : Stack
    paths : sequence of str
    frequency : array, shape (n_bands, n_points) or (n_frequency,)
        In bands, slopes are those of the mean over the last axis.
    incidence, window, effort
        As in `simulation.tasks.Task`.
    """
    if isinstance(incidence, PlaneIncidence):
        values, slopes = _of_plane_wave(stack, paths, frequency.ravel(), incidence.angle, window)
    else:
        asked = incidence.diffuse
        field = diffuse_field_derivatives(
            stack, paths, frequency.ravel(), asked.max_angle, weighting=asked.weighting, window=window, **effort
        )
        values = {"absorption": field.response.absorption, "transmission_loss": field.response.transmission_loss}
        slopes = {"absorption": field.absorption, "transmission_loss": field.transmission_loss}
    known = {name: slope for name, slope in slopes.items() if slope is not None}
    if frequency.ndim == 1:
        return known
    return {
        name: QUANTITIES[name].slope_of_mean(
            np.asarray(values[name]).reshape(frequency.shape), slope.reshape(-1, *frequency.shape)
        )
        for name, slope in known.items()
    }


def _of_plane_wave(
    stack: Stack, paths: Sequence[str], frequency: RealArray, angle: float, window: Window | None
) -> tuple[dict[str, RealArray | None], dict[str, RealArray | None]]:
    found = plane_wave_derivatives(stack, paths, frequency, angle)
    wave, absorption, slope = found.response, found.response.absorption, found.absorption
    if window is not None:  # the loss changes by what does not depend on the stack
        wavenumber, radians = 2 * np.pi * frequency / stack.ambient.gas.sound_speed, np.deg2rad(angle)
        radiation = radiation_impedance(window, wavenumber, wavenumber * np.sin(radians))
        absorption = finite_absorption(wave.reflection, radiation, np.cos(radians))
        slope = finite_absorption_slope(wave.reflection, found.reflection, radiation, np.cos(radians))
    values = {"absorption": absorption, "transmission_loss": wave.transmission_loss}
    return values, {"absorption": slope, "transmission_loss": found.transmission_loss}


def by_differences(
    stack: Stack, path: str, deviation: float, respond: Callable[[Stack], Mapping[str, NDArray[Any]]]
) -> Slopes:
    """Return slopes of all real quantities by one field, central where its bounds leave room; none without any room.

    Parameters
    ----------
    stack : Stack
    path : str
    deviation : float
        Standard deviation of its draws.
    respond : callable
        Returns the quantities of a stack.
    """
    field = locate(stack, path)
    along = field.value / abs(field.value) if isinstance(field.value, complex) else 1.0
    step = _STEP * deviation
    for _ in range(_HALVINGS):
        steps = step * np.array([1.0, 0.0, -1.0])
        inside = steps[allowed({path: field}, {path: field.value + along * steps})]
        if len(inside) > 1:  # at a bound, to one side
            ends = inside[[0, -1]]
            above, below = (respond(with_values(stack, {path: field.value + along * float(end)})) for end in ends)
            real = [name for name in above if name in QUANTITIES and not QUANTITIES[name].is_complex]
            return {name: (above[name] - below[name]) / (ends[0] - ends[1]) for name in real}
        step /= 2
    return {}
