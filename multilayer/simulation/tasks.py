"""The smallest piece of a simulation: one stack, or a chunk of samples of it, at all frequencies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.response.diffuse_field import diffuse_field
from multilayer.response.plane_wave import plane_wave
from multilayer.simulation.bands import band_average
from multilayer.simulation.located import with_values
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import DiffuseIncidence, FiniteSize, PlaneIncidence
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Task:
    """What to compute; small, and pickled to wherever it is computed.

    Attributes
    ----------
    stack : Stack
    frequency : array
        Hz; of shape (n_bands, n_points) to be averaged over the last axis.
    incidence : PlaneIncidence or DiffuseIncidence
    size : FiniteSize or None
    reference : Stack or None
        For the insertion loss.
    samples : mapping
        By path, values of fields that take the place of those in `stack`; all of one length. Empty for `stack` as it
        is.
    """

    stack: Stack
    frequency: RealArray
    incidence: PlaneIncidence | DiffuseIncidence
    size: FiniteSize | None = None
    reference: Stack | None = None
    samples: Mapping[str, NDArray[Any]] = field(default_factory=dict)


@dataclass(frozen=True)
class Outcome:
    """Quantities of a task by name, of shape (n_frequency,) or (n_samples, n_frequency), and warnings of validity."""

    quantities: Arrays
    warnings: tuple[str, ...]


def run_task(task: Task) -> Outcome:
    """Return what one stack does, or a chunk of samples of it."""
    with collected_warnings() as warnings:
        quantities = _sampled(task) if task.samples else _respond(task.stack, task)
    return Outcome(quantities, tuple(dict.fromkeys(warnings)))


def _sampled(task: Task) -> Arrays:
    """Return quantities of all samples at once, where the response takes arrays; otherwise of one after the other."""
    n = len(next(iter(task.samples.values())))
    if isinstance(task.incidence, PlaneIncidence) and all(path.startswith("layers.") for path in task.samples):
        # one more axis in front of the frequencies
        values = {path: column[:, None] for path, column in task.samples.items()}
        found = _respond(with_values(task.stack, values), task)
        return {name: np.broadcast_to(value, (n, value.shape[-1])) for name, value in found.items()}
    rows = [{path: column[i].item() for path, column in task.samples.items()} for i in range(n)]
    each = [_respond(with_values(task.stack, row), task) for row in rows]
    return {name: np.stack([one[name] for one in each]) for name in each[0]}


def _respond(stack: Stack, task: Task) -> Arrays:
    """Return quantities over the frequencies of `task`, averaged over its bands if it has some."""
    found = _averaged(stack, task)
    if task.reference is not None:
        bare = _averaged(task.reference, task)
        found["insertion_loss"] = found["transmission_loss"] - bare["transmission_loss"]
    return found


def _averaged(stack: Stack, task: Task) -> Arrays:
    values = _quantities(stack, task.frequency.ravel(), task)
    found = {name: value for name, value in values.items() if value is not None}
    if task.frequency.ndim == 1:
        return found
    kept = {name: value for name, value in found.items() if not QUANTITIES[name].is_complex}
    return {name: band_average(name, value, task.frequency.shape) for name, value in kept.items()}


def _quantities(stack: Stack, frequency: RealArray, task: Task) -> dict[str, NDArray[Any] | None]:
    if isinstance(task.incidence, DiffuseIncidence):
        field = diffuse_field(stack, frequency, task.incidence.diffuse.max_angle)
        return {"absorption": field.absorption, "transmission_loss": field.transmission_loss}
    wave = plane_wave(stack, frequency, task.incidence.angle)
    return {
        "absorption": wave.absorption,
        "transmission_loss": wave.transmission_loss,
        "normalised_impedance": wave.surface_impedance / stack.ambient.gas.impedance,
        "reflection": wave.reflection,
        "transmission": wave.transmission,
    }
