"""Measured data of stacks: the quantity in which they are compared with predictions, and their covariance.

Each kind is fitted in a quantity in which errors are additive and a model has neither poles nor branches:

- an impedance as the reflection coefficient, which is bounded by 1 for any passive stack, whereas Z (and ln Z) has
  poles wherever a stack reflects as a rigid wall does; also, the errors of a tube are uniform in R;
- transmissibility, modulus and stiffness as complex logarithms: errors of relative amplitude and of phase;
- absorption and transmission loss (dB) as they are.

Noise of the measured quantity is propagated by the derivative, so that it weighs as the file states.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import IndexArray, RealArray, half_turn
from multilayer.errors import InputError
from multilayer.experiments.stacks.columns import MeasuredValues, read_values, zero_noise
from multilayer.experiments.stacks.measurements import (
    Absorption,
    Measurement,
    Reflection,
    SurfaceImpedance,
    TransmissionLoss,
)
from multilayer.experiments.stacks.responses import Response, Selectable, response_of
from multilayer.inference.whitening import CorrelatedError, ValueNoise, Whitening, whitening
from multilayer.simulation.bands import Grid
from multilayer.simulation.measured import Measured
from multilayer.simulation.settings import Bands
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

_MOST_CORRELATED = 2000  # values with a dense covariance
_LEAST_AMOUNT = 0.5  # of a measured value: what a response counts for at least, since near 0 it would outweigh all
_SAME_AMOUNT = 1e-6
_GROUPS = 12  # of frequencies that cross-validation leaves out together


@dataclass(frozen=True)
class Scale:
    """Transformation of a measured quantity to the fitted one: none.

    Attributes
    ----------
    has_phase : bool
        Whether the imaginary part of the fitted quantity is an angle.
    """

    has_phase: ClassVar[bool] = False

    def of_measured(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the fitted quantity of measured values, any shape."""
        return np.asarray(values)

    def slope(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the derivative of the fitted quantity by the measured one."""
        return np.ones_like(values)

    def of_response(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the fitted quantity of the values of a `Response`."""
        return np.asarray(response)

    def slope_of_response(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the derivative of the fitted quantity by the values of a `Response`."""
        return np.ones_like(response)

    def relative_slope(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the derivative of the fitted quantity by the logarithm of the measured one, at a `Response`."""
        return np.asarray(response)

    def shown(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the measured quantity of the values of a `Response`."""
        return np.asarray(response)


class LogScale(Scale):
    """The complex logarithm of the measured quantity."""

    has_phase = True

    def of_measured(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return ln v."""
        return np.asarray(np.log(values))

    def slope(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return 1/v."""
        return np.asarray(1 / values)

    def of_response(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the logarithm of a response."""
        return np.asarray(np.log(response))

    def slope_of_response(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return 1/response."""
        return np.asarray(1 / response)

    def relative_slope(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return 1: the fitted quantity is that logarithm."""
        return np.ones_like(response)


@dataclass(frozen=True)
class ReflectionScale(Scale):
    """The reflection coefficient of a measured impedance, for a medium of impedance `front` before it."""

    front: float

    def of_measured(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return (Z - front)/(Z + front)."""
        return np.asarray((values - self.front) / (values + self.front))

    def slope(self, values: NDArray[Any]) -> NDArray[Any]:
        """Return the derivative by Z."""
        return np.asarray(2 * self.front / (values + self.front) ** 2)

    def relative_slope(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return Z dR/dZ, which is finite where Z is not."""
        return np.asarray((1 - response**2) / 2)

    def shown(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return the impedance of a reflection coefficient; infinite on a rigid wall."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(self.front * (1 + response) / (1 - response))


@dataclass(frozen=True, eq=False)
class Observation:
    """A measurement with its data, ready to be compared with predictions.

    Attributes
    ----------
    name, kind, stack, unit : str
    frequency : array, shape (n,)
        Hz.
    measured : array, shape (n,)
        In `unit`.
    response : callable
        Predicts it from a stack.
    one_by_one : bool
        Whether the response takes a single stack at a time.
    scale : Scale
    noise : ValueNoise
        Of the measured values.
    amounts : array, shape (n,)
        Values that a model error and relative noise are relative to: the measured ones, see `weighed_at`.
    error : CorrelatedError, optional
        Of the model.
    points : int
        Number of frequencies that are solved for a stack.
    burst : array of int, shape (n,)
        Index of the group of neighbouring frequencies; cross-validation leaves out whole groups.
    centres : array, shape (n_groups,)
        Mean frequencies of the groups, Hz.
    angle : float
        Angle of incidence, degrees.
    estimated : float or None
        Standard deviation of the noise of each part of R, where that is estimated.
    relative : float
        Standard deviation of the part of the noise that is a share of `amounts`.
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
    noise: ValueNoise = field(repr=False)
    amounts: NDArray[Any] = field(repr=False)
    error: CorrelatedError | None
    points: int
    burst: IndexArray = field(repr=False)
    centres: RealArray = field(repr=False)
    angle: float = 0.0
    estimated: float | None = None
    relative: float = 0.0

    @property
    def n_data(self) -> int:
        """Number of real values."""
        return len(self.frequency) * (2 if self.is_complex else 1)

    @property
    def is_complex(self) -> bool:
        """Whether amplitude and phase are measured."""
        return bool(np.iscomplexobj(self.measured))

    @cached_property
    def target(self) -> NDArray[Any]:
        """The measured values in the quantity that is fitted, shape (n,)."""
        return np.asarray(self.scale.of_measured(self.measured))

    @cached_property
    def whitening(self) -> Whitening:
        """The map of differences of the fitted quantity to independent numbers of unit variance."""
        return whitening(self.frequency, self.scale.slope(self.measured), self.amounts, self.noise, self.error)

    @cached_property
    def spread(self) -> list[RealArray]:
        """Standard deviations of each part of the fitted quantity, shape (n,) each, of noise and model error."""
        dense = self.whitening.dense
        if dense is None:
            raise ValueError(f"{self.name}: without a model error no spread of it is asked for")
        variance = np.diag(np.linalg.inv(dense.T @ dense))
        return list(np.sqrt(variance).reshape(-1, len(self.frequency)))

    def difference(self, response: NDArray[Any]) -> NDArray[Any]:
        """Return responses minus measured values in the fitted quantity, both of shape (..., n)."""
        with np.errstate(divide="ignore", invalid="ignore"):  # priors may include stacks without any motion
            difference = self.scale.of_response(response) - self.target
        if self.scale.has_phase and np.iscomplexobj(difference):
            difference = difference.real + 1j * half_turn(difference.imag)
        return np.asarray(difference)

    def residual(self, response: NDArray[Any]) -> RealArray:
        """Return whitened differences from the measurement, shape (..., n_data), of responses of shape (..., n)."""
        return self.whitening(self.difference(response))

    def weighed_at(self, response: NDArray[Any]) -> Observation:
        """Return the data with relative noise and model error as shares of a response, shape (n,).

        As shares of the measured values they are smaller for values that happen to be small, which draws a fit down to
        these (Peelle's puzzle: R. Frühwirth, D. Neudecker & H. Leeb, EPJ Web Conf. 27 (2012) 00008). Where nothing
        changes the data themselves are returned.
        """
        if self.unit == "dB" or not (self.relative or self.error):
            return self
        amounts = self.scale.relative_slope(response) / self.scale.slope(self.measured)
        least = _LEAST_AMOUNT * np.abs(self.measured)
        amounts = np.where(np.abs(amounts) >= least, amounts, _LEAST_AMOUNT * self.measured)
        if np.allclose(amounts, self.amounts, rtol=_SAME_AMOUNT, atol=0.0):
            return self
        more = self.relative**2 * (np.abs(amounts) ** 2 - np.abs(self.amounts) ** 2)
        parts = (np.sqrt(np.maximum(part**2 + more, 0.0)) for part in (self.noise.real, self.noise.imaginary))
        return replace(self, amounts=amounts, noise=ValueNoise(*parts))

    def selected(self, index: IndexArray) -> Observation:
        """Return the data at some frequencies, in the same groups, renumbered."""
        groups, burst = np.unique(self.burst[index], return_inverse=True)
        frequency = self.frequency[index]
        return replace(
            self, frequency=frequency, measured=self.measured[index], amounts=self.amounts[index],
            noise=ValueNoise(self.noise.real[index], self.noise.imaginary[index]), points=len(frequency),
            response=_of_some(self.response, index), burst=burst, centres=self.centres[groups],
        )  # fmt: skip

    def part(self, kept: IndexArray) -> Observation:
        """Return the data of some groups, by their indices, and renumbered."""
        return self.selected(np.flatnonzero(np.isin(self.burst, kept)))


def _of_some(response: Response, index: IndexArray) -> Response:
    """Return a response at some of its frequencies."""
    if isinstance(response, Selectable):
        return response.at(index)
    return partial(_selected, response, index)


def _selected(response: Response, index: IndexArray, stack: Stack) -> NDArray[Any]:
    return response(stack)[..., index]


def grouped(frequency: RealArray) -> tuple[IndexArray, RealArray]:
    """Return the group of each frequency, about evenly over ln f and none empty, and the groups' mean frequencies."""
    edges = np.geomspace(frequency[0], frequency[-1], max(min(_GROUPS, len(frequency) // 2), 1) + 1)[1:-1]
    burst = np.unique(np.searchsorted(edges, frequency, side="right"), return_inverse=True)[1]
    return burst, np.array([np.exp(np.mean(np.log(frequency[burst == group]))) for group in range(burst.max() + 1)])


def observe(measurement: Measurement, name: str, stack_name: str, stack: Stack, folder: Path) -> Observation:
    """Return a measurement with its data.

    Parameters
    ----------
    measurement : Measurement
    name, stack_name : str
        Names of the measurement and of its stack.
    stack : Stack
        With nominal values.
    folder : Path
        Folder of the data.

    Raises
    ------
    InputError
        When the data cannot be used, or the stack cannot be measured so.
    """
    values = read_values(measurement, folder)
    grid = _grid(measurement, name, values.frequency)
    response, one_by_one = response_of(measurement, stack, grid, np.iscomplexobj(values.values))
    with collected_warnings():
        response(stack)  # raises for a stack that cannot be measured so
    scale = scale_of(measurement, stack)
    return Observation(
        name, measurement.kind, stack_name, measurement.unit, grid.frequency, values.values, response, one_by_one,
        scale, values.noise, np.ones_like(values.values) if measurement.in_db else values.values,
        _model_error(measurement, name, scale, values), grid.points.size, *grouped(grid.frequency),
        angle=getattr(measurement, "angle", 0.0), relative=measurement.spread.relative,
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
            unit = 1.0 if measurement.normalised else stack.ambient.gas.impedance
            return ReflectionScale(unit / float(np.cos(np.deg2rad(measurement.angle))))
        case Reflection() | Absorption() | TransmissionLoss():
            return Scale()
    return LogScale()


def _model_error(measurement: Measurement, name: str, scale: Scale, values: MeasuredValues) -> CorrelatedError | None:
    """Return the model's error; refuse values without noise, or without a phase that is needed."""
    for f in zero_noise(values):
        raise InputError(f"{name}: the noise is 0 at {f:g} Hz; add an absolute one, as {{absolute: ...}}")
    if scale.has_phase and np.any(values.values == 0):
        raise InputError(f"{name}: a value is 0 and has no phase; leave its frequency out with 'from' and 'to'")
    stated = measurement.model_error
    if stated is None or stated.relative == 0:
        return None
    if values.values.size > _MOST_CORRELATED:
        raise InputError(
            f"{name}: {values.values.size} values are too many for a model_error, which ties all of them; thin them out"
        )
    return CorrelatedError(stated.relative, stated.length)
