"""Measured data beside what a stack predicts of them: in which quantity they are compared, and how they are weighed.

Each kind is fitted in a quantity in which errors are additive and a model has neither poles nor branches:

- an impedance as the reflection coefficient: bounded by 1 for any passive stack, where Z has poles (and ln Z with it)
  wherever a stack reflects as a rigid wall does; what a tube measures with errors alike is R, too;
- transmissibility, modulus and stiffness as complex logarithms: relative errors of the amount and of the phase;
- absorption and transmission loss (dB) as they are.

Noise of the measured quantity is carried over by the derivative, so that it weighs as the file says.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray, half_turn
from multilayer.errors import InputError
from multilayer.experiments.stacks.columns import MeasuredValues, read_values, zero_noise
from multilayer.experiments.stacks.measurements import (
    Absorption,
    Measurement,
    Reflection,
    SurfaceImpedance,
    TransmissionLoss,
)
from multilayer.experiments.stacks.responses import Response, Samples, respond, response_of
from multilayer.inference.whitening import CorrelatedError, Whitening, whitening
from multilayer.simulation.bands import Grid
from multilayer.simulation.measured import Measured
from multilayer.simulation.settings import Bands
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

_MOST_CORRELATED = 2000  # values whose covariance is taken in full
Function = Callable[[NDArray[Any]], NDArray[Any]]


@dataclass(frozen=True)
class Scale:
    """The quantity that is fitted.

    Attributes
    ----------
    of_measured, slope : callable
        It, and its derivative, from the measured quantity.
    of_response, shown : callable
        It, and the measured quantity, from what a `Response` gives.
    has_phase : bool
        Whether its imaginary part is an angle.
    """

    of_measured: Function
    slope: Function
    of_response: Function
    shown: Function
    has_phase: bool = False


_AS_IT_IS = Scale(lambda v: v, np.ones_like, lambda v: v, lambda v: v)
_LOGARITHM = Scale(np.log, lambda v: 1 / v, np.log, lambda v: v, has_phase=True)


def _impedance(front: float) -> Scale:
    """Return the reflection coefficient of an impedance, for a medium of impedance `front` before it."""
    return Scale(
        lambda z: (z - front) / (z + front),
        lambda z: 2 * front / (z + front) ** 2,
        lambda r: r,
        _impedance_of(front),
    )


def _impedance_of(front: float) -> Function:
    def impedance(reflection: NDArray[Any]) -> NDArray[Any]:
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(front * (1 + reflection) / (1 - reflection))

    return impedance


@dataclass(frozen=True)
class Observation:
    """One measurement, ready to be compared.

    Attributes
    ----------
    name, kind, stack, unit : str
    frequency : array, shape (n,)
        Hz.
    measured : array, shape (n,)
        In `unit`.
    response : callable
        What predicts it.
    one_by_one : bool
        Whether that takes one stack at a time.
    scale : Scale
    whitening : Whitening
        Of the fitted quantity.
    points : int
        Frequencies that are solved for one stack.
    """

    name: str
    kind: str
    stack: str
    unit: str
    frequency: RealArray
    measured: NDArray[Any]
    response: Response = field(repr=False)
    one_by_one: bool
    scale: Scale = field(repr=False)
    whitening: Whitening = field(repr=False)
    points: int

    @property
    def n_data(self) -> int:
        """Number of real values."""
        return len(self.frequency) * (2 if np.iscomplexobj(self.measured) else 1)

    def predict(self, stack: Stack, samples: Samples, count: int) -> NDArray[Any]:
        """Return what samples of the stack respond, shape (count, n); see `scale` for what that is."""
        return respond(self.response, stack, samples, count, self.one_by_one)

    def residual(self, response: NDArray[Any]) -> RealArray:
        """Return whitened differences from the measurement, shape (..., n_data), of responses of shape (..., n)."""
        with np.errstate(divide="ignore", invalid="ignore"):  # a prior may reach where nothing moves
            difference = self.scale.of_response(response) - self.scale.of_measured(self.measured)
        if self.scale.has_phase and np.iscomplexobj(difference):
            difference = difference.real + 1j * half_turn(difference.imag)
        return self.whitening(difference)


def observe(measurement: Measurement, name: str, stack_name: str, stack: Stack, folder: Path) -> Observation:
    """Return a measurement with its data.

    Parameters
    ----------
    measurement : Measurement
    name, stack_name : str
        What it and its stack are called.
    stack : Stack
        With nominal values.
    folder : Path
        Where the data lie.

    Raises
    ------
    InputError
        When the data cannot be used, or the stack cannot have been measured so.
    """
    values = read_values(measurement, folder)
    grid = _grid(measurement, name, values.frequency)
    response, one_by_one = response_of(measurement, stack, grid, np.iscomplexobj(values.values))
    with collected_warnings():
        response(stack)  # refuses a stack that cannot have been measured so
    scale = scale_of(measurement, stack)
    return Observation(
        name, measurement.kind, stack_name, measurement.unit, grid.frequency, values.values, response, one_by_one,
        scale, _whitening(measurement, name, scale, values), grid.points.size,
    )  # fmt: skip


def _grid(measurement: Measurement, name: str, frequency: RealArray) -> Grid:
    bands = getattr(measurement, "bands", None)
    if bands is None:
        return Grid(frequency, frequency)
    ends = (float(frequency[0]), float(frequency[-1]))
    wanted = Bands.model_validate({bands.replace(" ", "_"): ends})
    return Measured(name, frequency, {}).grid(wanted)


def scale_of(measurement: Measurement, stack: Stack) -> Scale:
    """Return the quantity in which a measurement of a stack is compared."""
    match measurement:
        case SurfaceImpedance():
            own = 1.0 if measurement.normalised else stack.ambient.gas.impedance
            return _impedance(own / float(np.cos(np.deg2rad(measurement.angle))))
        case Reflection() | Absorption() | TransmissionLoss():
            return _AS_IT_IS
    return _LOGARITHM


def _whitening(measurement: Measurement, name: str, scale: Scale, values: MeasuredValues) -> Whitening:
    for f in zero_noise(values):
        raise InputError(f"{name}: the noise is 0 at {f:g} Hz; add an absolute one, as {{absolute: ...}}")
    if scale.has_phase and np.any(values.values == 0):
        raise InputError(f"{name}: a value is 0 and has no phase; leave its frequency out with 'from' and 'to'")
    error = measurement.model_error
    own = None if error is None or error.relative == 0 else CorrelatedError(error.relative, error.length)
    if own is not None and values.values.size > _MOST_CORRELATED:
        raise InputError(
            f"{name}: {values.values.size} values are too many for a model_error, which ties all of them; thin them out"
        )
    amounts = np.ones_like(values.values) if measurement.in_db else values.values
    return whitening(values.frequency, scale.slope(values.values), amounts, values.noise, own)
