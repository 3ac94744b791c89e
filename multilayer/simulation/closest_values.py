"""Which value of a single field of a layer would bring a prediction closest to what was measured.

All other fields stay as they are stated. Along each field a few values are tried, and least squares go on from the best
of them with the exact derivative at every step: first at some of the frequencies, the best fields then at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.bounds import magnitudes
from multilayer.errors import MultilayerError
from multilayer.executors import as_done, call
from multilayer.inference.least_squares import trust_region
from multilayer.paths import locate
from multilayer.response.linearised import real_fields
from multilayer.simulation.linearised import linearised
from multilayer.simulation.settings import DiffuseIncidence
from multilayer.simulation.tasks import Task, is_of_sound, run_task
from multilayer.simulation.tolerances import allowed
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack
from multilayer.units import field_limits

TOLD = 3  # fields of a quantity
_MOST_TIMES = 10.0  # larger or smaller than stated: what is farther off is another layer, not another value
_TRIED = (0.3, 0.6, 1.7, 3.0)  # times the stated value: beyond the next resonances no descent from there leads
_AT_0 = (0.01, 0.1, 0.5)  # of what is usual, of fields that are 0
_ROWS = 40  # frequencies or bands of the first search
_IN_BAND = np.s_[2::4]  # of the frequencies of a band: 5 in a third octave
_ROUGH: dict[str, Any] = {"tolerance_db": 0.05, "tolerance": 1e-3}  # diffuse fields of it
_FIRST, _LAST = (15, 1e-5), (3, 1e-6)  # steps and relative change of the sum of squares, of both searches
_NEAR = 1e-3  # of a coordinate
_ROUNDING = 1e-6  # of an rms difference
_AT_LIMIT = 1e-3  # of the range that is searched
# of a stack, or a plugin's layer, that cannot be computed with a value
_REFUSALS = (MultilayerError, ArithmeticError, TypeError, ValueError)


@dataclass(frozen=True)
class ClosestValue:
    """A field, and its value that brings a quantity closest to what was measured.

    Attributes
    ----------
    case, quantity : str
    field : str
        Its path, without ``layers.`` where the layer has a name.
    unit : str
        SI.
    stated, value : float
    at_limit : bool
        Whether the value is the last one that was searched, or the last one allowed: farther off lies a closer one.
    rms : float
        Of the difference that is left, of its absolute value where it is complex; in the unit of the quantity.
    deviations : float or None
        Standard deviations of what is drawn within the field's tolerance, from the stated value to this one; None
        without a tolerance.
    """

    case: str
    quantity: str
    field: str
    unit: str
    stated: float
    value: float
    at_limit: bool
    rms: float
    deviations: float | None


def fields_sought(task: Task) -> tuple[str, ...]:
    """Return the dotted paths of all fields of a task's layers; none of walls with links or openings."""
    return real_fields(task.stack, None) if is_of_sound(_of_sound(task)) else ()


def closest_values(
    task: Task,
    quantity: str,
    measured: NDArray[Any],
    executor: Executor | None = None,
    progress: Callable[[str], None] | None = None,
) -> tuple[list[ClosestValue], list[str]]:
    """Return values of single fields of layers that bring a quantity closest to a measurement, the best first.

    Each lies within a factor of ten of what is stated and within the bounds of the field; of fields that are 0, up to
    what is usual.

    Parameters
    ----------
    task : Task
        Of a case, at the measured frequencies.
    quantity : str
        That the task predicts of sound: no level of an excitation, no free wave.
    measured : array, shape (n_frequency,)
        NaN where nothing was.
    executor : Executor, optional
        Where fields are searched; this process when left out.
    progress : callable, optional
        Called with each field that was searched.

    Returns
    -------
    list of ClosestValue
        At most `TOLD`, each closer than what is stated.
    list of str
        Fields that were left out, since no response or derivative can be computed, as of some layers of plugins.

    Notes
    -----
    All other fields are taken as they are stated: the value is where this field would have to be, not what it probably
    is. A fit tells that, with its uncertainty.
    """
    there = ~np.isnan(measured)
    whole, measured = replace(_of_sound(task), frequency=task.frequency[there]), measured[there]
    paths = [path for path in fields_sought(task) if _Axis(task.stack, path).is_free]
    rows = np.unique(np.linspace(0, len(measured) - 1, _ROWS).round().astype(int))
    effort = _ROUGH if isinstance(task.incidence, DiffuseIncidence) else {}
    points = whole.frequency[rows]
    points = points[:, _IN_BAND] if points.ndim > 1 else points
    some = replace(whole, frequency=points, effort={**whole.effort, **effort})
    first = _all_done([_Search(some, quantity, measured[rows], path, *_FIRST) for path in paths], executor, progress)
    near = sorted((found for found in first if found is not None), key=lambda found: found.rms)[:TOLD]
    searches = [_Search(whole, quantity, measured, found.path, *_LAST, start=found.value) for found in near]
    last = sorted(filter(None, _all_done(searches, executor, progress)), key=lambda found: found.rms)
    left_out = [_shown(path) for path, found in zip(paths, first, strict=True) if found is None]
    stated = _rms(run_task(whole).quantities[quantity] - measured)
    return [_closest(task, quantity, found) for found in last if found.rms < (1 - _ROUNDING) * stated], left_out


def _of_sound(task: Task) -> Task:
    """Return the task without what is asked for beside sound, on which that does not depend."""
    return replace(task, excitation=None, free_waves=False, layer_losses=False, duct=None, deviations={}, samples={})


def _all_done(
    searches: Sequence[_Search], executor: Executor | None, progress: Callable[[str], None] | None
) -> list[_Found | None]:
    found: list[_Found | None] = [None] * len(searches)
    for index, one in as_done(call, searches, executor):
        found[index] = one
        if progress is not None:
            progress(_shown(searches[index].path))
    return found


def _closest(task: Task, quantity: str, found: _Found) -> ClosestValue:
    field = locate(task.stack, found.path)
    same = [
        deviation
        for path, deviation in task.deviations.items()
        if (other := locate(task.stack, path)).owner is field.owner and other.field == field.field
    ]
    deviations = abs(found.value - field.value) / same[0] if same and same[0] else None
    return ClosestValue(
        task.label, quantity, _shown(found.path), field.unit or "", float(field.value), found.value, found.at_limit,
        found.rms, deviations,
    )  # fmt: skip


def _shown(path: str) -> str:
    short = path.removeprefix("layers.")
    return path if short[:1].isdigit() else short  # of a layer without a name


def _rms(difference: NDArray[Any]) -> float:
    return math.sqrt(float(np.mean(np.abs(difference) ** 2)))


class _Found(NamedTuple):
    path: str
    value: float
    at_limit: bool
    rms: float


@dataclass(frozen=True)
class _Search:
    """The search along one field; small, because it is pickled for other processes.

    Attributes
    ----------
    most, ftol : int, float
        Steps, and relative change of the sum of squares at which it ends.
    start : float or None
        The value it begins from; the best of a few when None.
    """

    task: Task
    quantity: str
    measured: NDArray[Any]
    path: str
    most: int
    ftol: float
    start: float | None = None

    def __call__(self) -> _Found | None:
        """Return the value that was found; None where the field has no derivative, or the stack no response."""
        with collected_warnings(), np.errstate(all="ignore"):
            try:
                return self._found()
            except _REFUSALS:
                return None

    def _found(self) -> _Found | None:
        axis = _Axis(self.task.stack, self.path)
        start = self._best_tried(axis) if self.start is None else axis.coordinate(self.start)

        def residual(x: RealArray) -> tuple[RealArray, RealArray]:
            value, slope = axis.at(float(x[0]))
            if axis.allows(value):
                with suppress(*_REFUSALS):
                    missed, slopes = self._missed(self.task.stack.replaced({self.path: value}))
                    return missed, slope * slopes.T
            nothing = _real(self.measured) * np.nan  # a shorter step is taken
            return nothing, nothing[:, None]

        low, high = axis.bounds
        minimum = trust_region(
            residual, np.array([start]), bounds=(np.array([low]), np.array([high])), scale="jac", most=self.most,
            ftol=self.ftol, xtol=self.ftol,
        )  # fmt: skip
        if not minimum.is_finite:
            return None
        x = float(minimum.z[0])
        at_limit = min(x - low, high - x) < _AT_LIMIT * (high - low)
        rms = math.sqrt(minimum.misfit / self.measured.size)  # of the absolute value where it is complex
        return _Found(self.path, axis.at(x)[0], at_limit, rms)

    def _best_tried(self, axis: _Axis) -> float:
        """Return the coordinate from which the search begins: that of the stated value or of one tried beside it."""
        x = np.array([x for x in axis.tried if axis.allows(axis.at(x)[0])])
        if not x.size:
            return 0.0
        samples = {self.path: np.array([axis.at(value)[0] for value in (0.0, *x)])}
        try:
            predicted = run_task(replace(self.task, samples=samples)).quantities[self.quantity]
        except _REFUSALS:
            return 0.0
        missed = np.sum(np.abs(predicted - self.measured) ** 2, axis=-1)
        return float((0.0, *x)[int(np.argmin(np.where(np.isfinite(missed), missed, np.inf)))])

    def _missed(self, stack: Stack) -> tuple[RealArray, RealArray]:
        """Return what a stack misses, shape (n,), real and imaginary parts apart, and the slope, shape (1, n)."""
        values, slopes = self._linearised(stack, [self.path])
        return _real(values - self._target), _real(slopes)

    @cached_property
    def _target(self) -> NDArray[Any]:
        if self.quantity != "insertion_loss":
            return self.measured
        return np.asarray(self.measured + self._linearised(self.task.bare(self.task.stack), [])[0])

    def _linearised(self, stack: Stack, paths: Sequence[str]) -> tuple[NDArray[Any], NDArray[Any]]:
        task, name = self.task, "transmission_loss" if self.quantity == "insertion_loss" else self.quantity
        return linearised(stack, paths, task.frequency, task.incidence, task.window, task.effort)[name]


class _Axis:
    """A coordinate along which a field is sought, 0 where it is stated: the logarithm of its ratio to that value.

    Of a field that is 0, a share of what is usual.
    """

    def __init__(self, stack: Stack, path: str) -> None:
        self.stack, self.path, self.field = stack, path, (field := locate(stack, path))
        self.stated = float(field.value)
        self.usual = magnitudes(field.unit or "").usual
        least, largest = field_limits(type(field.owner).model_fields[field.field])
        ends = (-self.usual, self.usual) if self.stated == 0 else (self.stated / _MOST_TIMES, self.stated * _MOST_TIMES)
        inside = (min(max(end, least), largest) for end in ends)
        self.bounds = (*sorted(self.coordinate(end) for end in inside),)
        tried = [sign * share for share in _AT_0 for sign in (1, -1)] if self.stated == 0 else map(math.log, _TRIED)
        self.tried = [x for x in tried if self.bounds[0] < x < self.bounds[1]]

    @property
    def is_free(self) -> bool:
        """Whether the field may have another value: no share of a pattern, no loss where another field states it."""
        near = [x for x in (-_NEAR, _NEAR) if self.bounds[0] <= x <= self.bounds[1]]
        return any(self.allows(self.at(x)[0]) for x in near)

    def at(self, x: float) -> tuple[float, float]:
        """Return the value at a coordinate, and its derivative."""
        if self.stated == 0:
            return x * self.usual, self.usual
        value = self.stated * math.exp(x)
        return value, value

    def coordinate(self, value: float) -> float:
        """Return the coordinate of a value."""
        return value / self.usual if self.stated == 0 else math.log(value / self.stated)

    def allows(self, value: float) -> bool:
        """Tell whether the models that hold the field take the value."""
        return bool(allowed({self.path: self.field}, {self.path: np.array([value])}, self.stack)[0])


def _real(values: NDArray[Any]) -> RealArray:
    """Return real and imaginary parts of values one behind the other along the last axis."""
    return np.concatenate([values.real, values.imag], axis=-1) if np.iscomplexobj(values) else np.asarray(values)
