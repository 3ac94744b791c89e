"""Responses that predict a measurement from a stack, or from many samples of it at once.

A sample is a stack with some values in its unknown fields.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, IndexArray, Numeric, RealArray
from multilayer.bounds import refuse_shape
from multilayer.errors import InputError, MultilayerError, ValidityWarning
from multilayer.experiments.stacks.measurements import (
    Absorption,
    DynamicModulus,
    Measurement,
    Reflection,
    Stiffness,
    SurfaceImpedance,
    TransmissionLoss,
)
from multilayer.layers.base import Layer
from multilayer.media.laws import complex_modulus
from multilayer.paths import with_values
from multilayer.response.base_motion import base_motion
from multilayer.response.derivatives import (
    base_motion_derivatives,
)
from multilayer.response.finite_size import Window
from multilayer.simulation.bands import Grid
from multilayer.simulation.linearised import linearised
from multilayer.simulation.settings import DiffuseIncidence, FiniteSize, PlaneIncidence
from multilayer.simulation.tasks import Task, run_task
from multilayer.stack import Stack

Samples = Mapping[str, RealArray]  # by path, values of shape (n_samples,)
Response = Callable[[Stack], NDArray[Any]]  # shape (..., n_frequency) of a stack with arrays of shape (..., 1)
Linear = tuple[NDArray[Any], NDArray[Any]]  # a response, shape (n_frequency,), and derivatives, (n_fields, n_frequency)


@runtime_checkable
class Selectable(Protocol):
    """A response that is computed at some of its frequencies for less."""

    def __call__(self, stack: Stack) -> NDArray[Any]:
        """Return the response over frequency."""

    def at(self, index: IndexArray) -> Selectable:
        """Return the response at some of its frequencies, by their indices."""


def respond(
    response: Callable[[Stack, slice], NDArray[Any]],
    stack: Stack,
    samples: Samples,
    count: int,
    one_by_one: bool = False,
) -> NDArray[Any]:
    """Return a response of samples of a stack, shape (n_samples, n_frequency); NaN where a sample has none.

    Parameters
    ----------
    response : callable
        Function of a stack, and of the slice of samples that it holds.
    stack : Stack
    samples : mapping
        Values of the fields that vary, if any.
    count : int
        Number of samples.
    one_by_one : bool
        For a response that takes no arrays. Fields that are not of a layer never take arrays.
    """
    if not one_by_one and all(path.startswith("layers.") for path in samples):
        try:
            columns = {path: column[:, None] for path, column in samples.items()}
            value = response(with_values(stack, columns), np.s_[:])
        except MultilayerError:  # a single sample without a response fails the whole batch
            pass
        else:
            return np.broadcast_to(value, (count, value.shape[-1]))
    rows = [
        _or_none(response, with_values(stack, {p: c[i].item() for p, c in samples.items()}), np.s_[i : i + 1])
        for i in range(count)
    ]
    shape = next((row.shape for row in rows if row is not None), (1,))
    return np.stack([np.full(shape, np.nan) if row is None else row for row in rows])


def _or_none(response: Callable[[Stack, slice], NDArray[Any]], stack: Stack, rows: slice) -> NDArray[Any] | None:
    try:
        value = response(stack, rows)
    except MultilayerError:
        return None
    return value.reshape(value.shape[-1])


@dataclass(frozen=True)
class WaveResponse:
    """A quantity as simulations compute it, see `simulation.tasks`."""

    quantity: str
    points: RealArray
    incidence: PlaneIncidence | DiffuseIncidence
    size: FiniteSize | None = None

    def at(self, index: IndexArray) -> WaveResponse:
        """Return the response at some of its frequencies, by their indices."""
        return replace(self, points=self.points[index])

    def __call__(self, stack: Stack) -> NDArray[Any]:
        """Return the quantity over frequencies, or bands."""
        task = Task(stack, self.points, self.incidence, size=self.size, resolves=False)
        result = run_task(task)
        for text in result.warnings:
            warnings.warn(text, ValidityWarning, stacklevel=2)
        if self.quantity not in result.quantities:
            raise InputError(f"this stack has no {self.quantity}; end it with 'termination: ambient'")
        return result.quantities[self.quantity]

    is_differentiable: ClassVar[bool] = True

    def linearised(self, stack: Stack, fields: Sequence[str]) -> Linear:
        """Return the quantity of a single stack, and its derivatives by fields of its layers."""
        window = None if self.size is None else Window(self.size.width, self.size.height)
        return linearised(stack, fields, self.points, self.incidence, window, {})[self.quantity]


@dataclass(frozen=True)
class ImpedanceResponse:
    """Surface impedance, as the reflection coefficient for a front medium of fixed `impedance`, Pa s/m.

    With `impedance` None the front medium is the stack's gas: the impedance is measured relative to that.
    """

    frequency: RealArray
    angle: float
    impedance: float | None

    def __call__(self, stack: Stack) -> ComplexArray:
        """Return the response over frequency."""
        reflection = self._reflection(stack)
        if self.impedance is None:
            return reflection
        ratio = stack.ambient.gas.impedance / self.impedance
        high, low = ratio * (1 + reflection), 1 - reflection  # Z itself is infinite on a rigid surface
        return np.asarray((high - low) / (high + low))

    is_differentiable: ClassVar[bool] = True

    def linearised(self, stack: Stack, fields: Sequence[str]) -> Linear:
        """Return the response of a single stack, and its derivatives by fields of its layers."""
        reflection, slopes = self._reflection.linearised(stack, fields)
        if self.impedance is None:
            return reflection, slopes
        ratio = stack.ambient.gas.impedance / self.impedance
        high, low = ratio * (1 + reflection), 1 - reflection
        return np.asarray((high - low) / (high + low)), 4 * ratio / (high + low) ** 2 * slopes

    @property
    def _reflection(self) -> WaveResponse:
        return WaveResponse("reflection", self.frequency, PlaneIncidence(angle=self.angle))


@dataclass(frozen=True)
class MotionResponse:
    """Motion of the back face over that of the shaken front face."""

    frequency: RealArray

    def __call__(self, stack: Stack) -> ComplexArray:
        """Return the response over frequency."""
        return base_motion(stack, self.frequency).transmissibility

    is_differentiable: ClassVar[bool] = True

    def linearised(self, stack: Stack, fields: Sequence[str]) -> Linear:
        """Return the response of a single stack, and its derivatives by fields of its layers."""
        found = base_motion_derivatives(stack, fields, self.frequency)
        return found.response.transmissibility, found.transmissibility


@dataclass(frozen=True)
class ModulusResponse:
    """Young's modulus of a layer, Pa."""

    frequency: RealArray
    layer: str

    def __call__(self, stack: Stack) -> ComplexArray:
        """Return the response over frequency."""
        layer = stack.layers[stack.index(self.layer)]
        return _modulus(layer, self.frequency)


def _modulus(layer: Layer, frequency: RealArray) -> ComplexArray:
    young, loss = (getattr(layer, name) for name in ("young_modulus", "loss_factor"))
    return np.asarray(complex_modulus(young, loss, frequency) + 0j * frequency)


@dataclass(frozen=True)
class StiffnessResponse:
    """Stiffness of a glued disc in slow compression, N/m: ``E g(nu, S) pi R^2 / h``, S = R/2h.

    Shape factor g: A. N. Gent & P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111-122; here by `rig.shape_factor`.
    """

    frequency: RealArray
    layer: str
    radius: float
    thickness: float
    is_complex: bool

    def __call__(self, stack: Stack) -> NDArray[Any]:
        """Return the response over frequency."""
        layer = stack.layers[stack.index(self.layer)]
        factor = shape_factor(getattr(layer, "poisson_ratio"), self.radius / (2 * self.thickness))  # noqa: B009
        stiffness = _modulus(layer, self.frequency) * factor * np.pi * self.radius**2 / self.thickness
        return stiffness if self.is_complex else stiffness.real


def shape_factor(poisson_ratio: Numeric, shape: float) -> Numeric:
    """Return `rig.static_shape_factor`, interpolated for arrays of Poisson's ratio, as finite elements are slow."""
    from multilayer.rig.shape_factor import interpolated_shape_factor, static_shape_factor  # heavy: finite elements

    if np.ndim(poisson_ratio) == 0:
        return static_shape_factor(float(np.asarray(poisson_ratio).real), shape)
    return interpolated_shape_factor(shape)(np.asarray(poisson_ratio).real)


def response_of(measurement: Measurement, stack: Stack, grid: Grid, is_complex: bool) -> tuple[Response, bool]:
    """Return the response that predicts a measurement, and whether it takes a single stack at a time.

    Raises
    ------
    InputError
        When the stack has no such quantity.
    """
    f = grid.points
    match measurement:
        case SurfaceImpedance():
            fixed = None if measurement.normalised else stack.ambient.gas.impedance
            return ImpedanceResponse(f, measurement.angle, fixed), False
        case Reflection():
            return WaveResponse("reflection", f, measurement.incidence), False
        case Absorption() | TransmissionLoss():
            diffuse = isinstance(measurement.incidence, DiffuseIncidence)
            return WaveResponse(measurement.quantity, f, measurement.incidence, measurement.finite_size), diffuse
        case DynamicModulus():
            return ModulusResponse(f, _elastic(stack, measurement.layer)[0]), False
        case Stiffness():
            name, layer = _elastic(stack, measurement.layer)
            thickness = measurement.thickness or layer.thickness
            refuse_shape(measurement.radius / (2 * thickness))
            return StiffnessResponse(f, name, measurement.radius, thickness, is_complex), False
    return MotionResponse(f), False


def _elastic(stack: Stack, name: str) -> tuple[str, Any]:
    layer = stack.layers[stack.index(name)]
    if not {"young_modulus", "poisson_ratio", "loss_factor"} <= set(type(layer).model_fields):
        raise InputError(f"layer '{name}' is of type {layer.type}, which has no Young's modulus")
    return name, layer
