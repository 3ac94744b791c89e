"""Which value of a single field of a layer would bring a prediction closest to what was measured.

All other fields stay as they are stated. Derivatives by all fields rank them; the best are then sought by least
squares, with the exact derivative at every step.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.bounds import magnitudes
from multilayer.errors import MultilayerError
from multilayer.inference.least_squares import trust_region
from multilayer.paths import Located, locate
from multilayer.response.linearised import real_fields
from multilayer.simulation.linearised import linearised
from multilayer.simulation.tasks import Task, is_of_sound
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack
from multilayer.units import field_bounds

_MOST_TIMES = 10.0  # larger or smaller than stated: what is farther off is another layer, not another value
SOUGHT = 5  # fields; to first order the others bring the prediction less close
_TOLERANCE = 1e-8
_MOST_STEPS = 50


@dataclass(frozen=True)
class ClosestValue:
    """A field, and its value that brings a quantity closest to what was measured.

    Attributes
    ----------
    case, quantity : str
    field : str
        Its path without ``layers.``.
    unit : str
        SI.
    stated, value : float
    rms : float
        Of the difference that is left, of its absolute value where it is complex; in the unit of the quantity.
    deviations : float or None
        Standard deviations of the field's tolerance from the stated value to this one; None without a tolerance.
    """

    case: str
    quantity: str
    field: str
    unit: str
    stated: float
    value: float
    rms: float
    deviations: float | None


def closest_values(
    task: Task, quantity: str, measured: NDArray[Any], progress: Callable[[str], None] | None = None
) -> list[ClosestValue]:
    """Return values of single fields of layers that bring a quantity closest to a measurement, the best first.

    Each is the minimum that a descent from the stated value finds, within a factor of ten of that and within the bounds
    of the field; of fields that are 0, up to what is usual. There are at most `SOUGHT`, and none where the task has no
    exact derivatives, as of walls with links, or the stack has no response.

    Parameters
    ----------
    task : Task
        Of a case, at the measured frequencies.
    quantity : str
        That the task predicts.
    measured : array, shape (n_frequency,)
        Finite.
    progress : callable, optional
        Called with each field that is sought.

    Notes
    -----
    All other fields are taken as they are stated: the value is where this field would have to be, not what it probably
    is. A fit tells that, with its uncertainty.
    """
    paths = real_fields(task.stack, None) if is_of_sound(task) else ()
    if not paths:
        return []
    found = []
    with collected_warnings(), np.errstate(all="ignore"):  # what has no response is no step
        try:
            search = _Search(task, quantity, measured)
            for path in search.ranked(paths)[:SOUGHT]:
                if progress is not None:
                    progress(path)
                found.append(search.closest(path))
        except (MultilayerError, ArithmeticError):  # of the stack as it is stated
            return []
    return sorted(found, key=lambda item: item.rms)


class _Search:
    """The differences between a prediction and a measurement, and their slopes."""

    def __init__(self, task: Task, quantity: str, measured: NDArray[Any]) -> None:
        self.task, self.quantity, self.target = task, quantity, measured
        self.name = quantity
        if quantity == "insertion_loss":  # beside a reference, which stays as it is
            assert task.reference is not None
            self.name = "transmission_loss"
            self.target = measured + self._linearised(task.reference, [])[0]

    def _linearised(self, stack: Stack, paths: Sequence[str]) -> tuple[NDArray[Any], NDArray[Any]]:
        task = self.task
        return linearised(stack, paths, task.frequency, task.incidence, task.window, task.effort)[self.name]

    def _missed(self, stack: Stack, paths: Sequence[str]) -> tuple[RealArray, RealArray]:
        """Return what a stack misses, shape (n,), real and imaginary parts apart, and slopes, (n_fields, n)."""
        values, slopes = self._linearised(stack, paths)
        return _real(values - self.target), _real(slopes)

    def ranked(self, paths: Sequence[str]) -> list[str]:
        """Return the fields that lessen the difference at all, to first order, by how far they do."""
        missed, slopes = self._missed(self.task.stack, paths)
        with np.errstate(invalid="ignore", divide="ignore"):
            shares = (slopes @ missed) ** 2 / (np.sum(slopes**2, axis=-1) * np.sum(missed**2))
        order = np.argsort(-np.nan_to_num(shares), kind="stable")
        return [paths[i] for i in order if shares[i] > 0]

    def closest(self, path: str) -> ClosestValue:
        """Return the value of a field that brings the prediction closest."""
        stack, field = self.task.stack, locate(self.task.stack, path)
        axis = _Axis(field)

        def residual(x: RealArray) -> tuple[RealArray, RealArray]:
            value, slope = axis.at(float(x[0]))
            try:
                missed, slopes = self._missed(stack.replaced({path: value}), [path])
            except (MultilayerError, ArithmeticError):  # not allowed, or without a response: a shorter step is taken
                return np.full(n, np.nan), np.zeros((n, 1))
            return missed, slope * slopes.T

        n = len(_real(self.target))
        minimum = trust_region(
            residual, np.zeros(1), bounds=axis.bounds, scale="jac", most=_MOST_STEPS, ftol=_TOLERANCE, xtol=_TOLERANCE
        )
        value, _ = axis.at(float(minimum.z[0]))
        # of complex differences the rms of the absolute value
        rms = math.sqrt(float(np.sum(minimum.residual**2)) / self.target.size)
        deviation = self.task.deviations.get(path)
        return ClosestValue(
            self.task.label, self.quantity, path.removeprefix("layers."), field.unit or "", field.value, value, rms,
            abs(value - field.value) / deviation if deviation else None,
        )  # fmt: skip


class _Axis:
    """A coordinate along which a field is sought, 0 where it is stated: the logarithm of its ratio to that value.

    Of a field that is 0, a share of what is usual.
    """

    def __init__(self, field: Located) -> None:
        self.stated = float(field.value)
        self.usual = magnitudes(field.unit or "").usual
        sides = field_bounds(type(field.owner).model_fields[field.field])
        reach = 1.0 if self.stated == 0 else math.log(_MOST_TIMES)
        is_one_sided = self.stated == 0 and any(side in ("gt", "ge") and end >= 0 for side, end in sides)
        self.bounds = np.array([0.0 if is_one_sided else -reach]), np.array([reach])

    def at(self, x: float) -> tuple[float, float]:
        """Return the value at a coordinate, and its derivative."""
        if self.stated == 0:
            return x * self.usual, self.usual
        value = self.stated * math.exp(x)
        return value, value


def _real(values: NDArray[Any]) -> RealArray:
    """Return real and imaginary parts of values one behind the other along the last axis."""
    return np.concatenate([values.real, values.imag], axis=-1) if np.iscomplexobj(values) else np.asarray(values)
