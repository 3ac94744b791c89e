"""What a stack makes of sound, in bands where these are asked for, with exact derivatives by fields of its layers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.response.derivatives import diffuse_field_derivatives, plane_wave_derivatives
from multilayer.response.finite_size import (
    Window,
    finite_absorption,
    finite_absorption_slope,
    finite_loss,
    radiation_towards,
)
from multilayer.simulation.quantities import QUANTITIES, normalised
from multilayer.simulation.settings import DiffuseIncidence, PlaneIncidence
from multilayer.stack import Stack


def linearised(
    stack: Stack,
    paths: Sequence[str],
    frequency: RealArray,
    incidence: PlaneIncidence | DiffuseIncidence,
    window: Window | None,
    effort: Mapping[str, Any],
) -> dict[str, tuple[NDArray[Any], NDArray[Any]]]:
    """Return quantities of sound, and their exact slopes by real fields of layers, by their names.

    Absorption, transmission loss, and of a plane wave reflection, transmission and normalised impedance; what is
    transmitted needs a half-space behind. Slopes have the shape (n_fields, ...).

    Parameters
    ----------
    stack : Stack
    paths : sequence of str
    frequency : array, shape (n_bands, n_points) or (n_frequency,)
        In bands, values and slopes are those of the mean over the last axis.
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
    found = {name: (np.asarray(values[name]), slope) for name, slope in slopes.items() if slope is not None}
    if frequency.ndim == 1:
        return found
    # a mean of complex quantities over a band says nothing
    return {name: _in_bands(name, *pair, frequency) for name, pair in found.items() if not QUANTITIES[name].is_complex}


def _in_bands(
    name: str, values: NDArray[Any], slopes: NDArray[Any], frequency: RealArray
) -> tuple[NDArray[Any], NDArray[Any]]:
    quantity, shape = QUANTITIES[name], frequency.shape
    values = values.reshape(shape)
    return quantity.mean(values), quantity.slope_of_mean(values, slopes.reshape(-1, *shape))


def _of_plane_wave(
    stack: Stack, paths: Sequence[str], frequency: RealArray, angle: float, window: Window | None
) -> tuple[dict[str, NDArray[Any] | None], dict[str, NDArray[Any] | None]]:
    found = plane_wave_derivatives(stack, paths, frequency, angle)
    wave, absorption, slope = found.response, found.response.absorption, found.absorption
    loss = wave.transmission_loss
    if window is not None:  # the loss by what does not depend on the stack: its slopes stay
        radiation, cosine = radiation_towards(window, frequency, angle, stack.ambient.gas.sound_speed)
        absorption = finite_absorption(wave.reflection, radiation, cosine)
        slope = finite_absorption_slope(wave.reflection, found.reflection, radiation, cosine)
        loss = None if loss is None else finite_loss(loss, radiation.real, cosine)
    of_gas = stack.ambient.gas.impedance
    values = {
        "absorption": absorption,
        "transmission_loss": loss,
        "reflection": wave.reflection,
        "transmission": wave.transmission,
        "normalised_impedance": normalised(wave.surface_impedance, of_gas),
    }
    slopes = {
        "absorption": slope,
        "transmission_loss": found.transmission_loss,
        "reflection": found.reflection,
        "transmission": found.transmission,
        "normalised_impedance": found.surface_impedance / of_gas,
    }
    return values, slopes
