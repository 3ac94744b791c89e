"""Insertion loss: the transmission loss of a stack over that of a reference."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ArrayLike, RealArray
from multilayer.errors import InputError
from multilayer.response.diffuse_field import diffuse_field
from multilayer.response.plane_wave import plane_wave
from multilayer.stack import Stack


def insertion_loss(
    stack: Stack,
    reference: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    max_angle: float | None = None,
    azimuth: ArrayLike = 0.0,
) -> RealArray:
    """Return the transmission loss of `stack` minus that of `reference`, dB.

    Parameters
    ----------
    stack, reference : Stack
        Both with a half-space behind.
    frequency : array
        Hz.
    angle : array
        Degrees, for plane waves.
    max_angle : float, optional
        Take a diffuse field up to this angle in place of plane waves.
    azimuth : array
        Degrees about the normal, for plane waves.

    Raises
    ------
    InputError
        When one of the two has no half-space behind.
    """
    losses = []
    for panel in (stack, reference):
        if max_angle is None:
            loss = plane_wave(panel, frequency, angle, azimuth=azimuth).transmission_loss
        else:
            loss = diffuse_field(panel, frequency, max_angle).transmission_loss
        if loss is None:
            raise InputError("an insertion loss needs a half-space behind both stacks; write 'termination: ambient'")
        losses.append(loss)
    return np.asarray(losses[0] - losses[1])
