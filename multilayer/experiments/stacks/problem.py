"""Fields of stacks and measurements of them as one inverse problem, with unmodelled effects of a tube or without."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.hypothesis import Hypothesis, values_of
from multilayer.experiments.stacks.effects import Tube, TubeEffect, TubeSetting
from multilayer.experiments.stacks.file import StackFitFile
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.responses import respond
from multilayer.experiments.stacks.unknowns import UnknownFields, placed
from multilayer.inference.derivative import central, forward
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Experiment, Known, Points
from multilayer.paths import with_values
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

_AT_ONCE = 16_384  # samples times frequencies of one batched solve
_WILD, _WILDEST = 8.0, 12.0  # beyond the first, coordinates of unknowns count less and less, up to the second


@dataclass(frozen=True, eq=False)
class StackExperiment(Experiment):
    """One measurement of a stack.

    Attributes
    ----------
    observation : Observation
    fields : UnknownFields
        Their parameters are the first of the points'.
    known : Known, optional
        What an earlier measurement says of them.
    setting : TubeSetting
        The measurement as effects see it.
    effects : tuple of TubeEffect
        Their parameters are the last of the points'.
    """

    observation: Observation
    fields: UnknownFields
    known: Known | None
    setting: TubeSetting
    effects: tuple[TubeEffect, ...] = ()

    @property
    def data(self) -> Observation:
        """The measured values."""
        return self.observation

    def difference(self, points: Points) -> NDArray[Any]:
        """Return predicted minus measured values, shape (m, n), in the fitted quantity."""
        return self.observation.difference(self.predict(points))

    def whiten(self, difference: NDArray[Any]) -> RealArray:
        """Return differences of the fitted quantity as independent numbers of unit variance."""
        parts = np.asarray(difference, dtype=complex) if self.observation.is_complex else difference
        return self.observation.whitening(parts)

    def predict(self, points: Points) -> NDArray[Any]:
        """Return the response, shape (m, n); see `Observation.scale` for what that is. NaN where there is none."""
        samples = points.shared("fields", partial(self._samples, points.z))[self.observation.stack]
        every = zip(self.effects, values_of(self.effects, points), strict=True)
        values = [(effect, own) for effect, own in every if effect.applies(self.setting)]
        count, step = len(points.z), max(1, _AT_ONCE // self.observation.points)
        stack = self.fields.stacks[self.observation.stack]
        if not samples and not values:
            return np.broadcast_to(response := self.observation.response(stack), (count, *response.shape))
        one_by_one = self.observation.one_by_one or any(effect.changes_gas for effect, _ in values)
        pieces = []
        for first in range(0, count, step):
            piece = np.s_[first : first + step]
            here = {path: column[piece] for path, column in samples.items()}
            acting = [(effect, {name: column[piece] for name, column in own.items()}) for effect, own in values]
            size = min(step, count - first)
            pieces.append(respond(partial(self._respond, acting), stack, here, size, one_by_one))
        return np.concatenate(pieces)

    def _samples(self, z: RealArray) -> dict[str, dict[str, RealArray]]:
        """Return by stack and path the values, shape (m,), of the unknown fields."""
        return self.fields.samples(_own_coordinates(z, len(self.fields.field_parameters), self.known))

    def _respond(self, acting: Sequence[tuple[TubeEffect, Values]], stack: Stack, rows: slice) -> NDArray[Any]:
        """Return the response of some samples, shape (k, n) or (n,) where it is the same for all."""
        if not acting:
            return self.observation.response(stack)
        pairs = [(effect, {name: column[rows] for name, column in own.items()}) for effect, own in acting]
        for effect, own in pairs:
            stack = effect.stack(self.setting, stack, own)
        response = self.observation.response(stack)
        count = max((len(column) for _, own in pairs for column in own.values()), default=1)
        reflection = np.array(np.broadcast_to(response, (count, response.shape[-1])))  # an effect may write into it
        for effect, own in pairs:
            reflection = effect.surface(self.setting, stack, reflection, own)
        for effect, own in pairs:
            reflection = effect.reading(self.setting, reflection, own)
        return np.asarray(reflection)


@dataclass(frozen=True)
class StackProblem(UnknownFields, Hypothesis):
    """Stacks, unknown fields of theirs, and measurements; with unmodelled effects, those of reflection in a tube.

    Attributes
    ----------
    observations : tuple of Observation
    tube : Tube
    effects : tuple of TubeEffect
    known : Known, optional
        What an earlier fit says of the unknowns, in place of their own priors.
    seen : tuple of Observation, optional
        The data that residuals are made of; all when left out.
    """

    observations: tuple[Observation, ...]
    tube: Tube = field(default_factory=Tube)
    effects: tuple[TubeEffect, ...] = ()
    known: Known | None = None
    seen: tuple[Observation, ...] | None = None

    @classmethod
    def of_file(cls, file: StackFitFile) -> StackProblem:
        """Return the problem that a file states."""
        return cls(placed(file.by_name, file.resolved), file.resolved, file.observations)

    @property
    def data(self) -> tuple[Observation, ...]:
        """The measurements in use."""
        return self.observations if self.seen is None else self.seen

    @property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """The unknowns' coordinates, one unknown after the other."""
        return self.field_parameters

    @cached_property
    def start(self) -> RealArray:
        """Coordinates of the unknowns near the nominal values, or at what is known of them."""
        return self.nominal_start if self.known is None else np.zeros(len(self.nominal_parameters))

    def own_coordinates(self, z: RealArray) -> RealArray:
        """Return coordinates of the unknowns in their own priors, shape (..., d), of all coordinates."""
        return _own_coordinates(z, len(self.nominal_parameters), self.known)

    @cached_property
    def settings(self) -> tuple[TubeSetting, ...]:
        """What effects see of every measurement."""
        return tuple(
            TubeSetting(data.name, data.frequency, data.angle, self.stacks[data.stack], self.tube) for data in self.data
        )

    @cached_property
    def experiments(self) -> tuple[StackExperiment, ...]:
        """One of each measurement in use."""
        fields = UnknownFields(self.stacks, self.unknowns)
        return tuple(
            StackExperiment(data, fields, self.known, setting, self.effects)
            for data, setting in zip(self.data, self.settings, strict=True)
        )

    def predict(self, z: RealArray) -> list[NDArray[Any]]:
        """Return the response of every measurement, shape (..., n_frequency), of coordinates of shape (..., n)."""
        points = self.points(z)
        with collected_warnings():  # a search leaves the range of formulae; the solution's warnings are told
            found = [experiment.predict(points) for experiment in self.experiments]
        return [values.reshape(*z.shape[:-1], values.shape[-1]) for values in found]

    def differences(self, z: RealArray) -> list[NDArray[Any]]:
        """Return predicted minus measured values, shape (..., n), of every measurement, in the fitted quantity."""
        with np.errstate(all="ignore"):  # a search leaves the range of formulae, and of numbers
            return [data.difference(response) for data, response in zip(self.data, self.predict(z), strict=True)]

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative from one batched solve per measurement."""
        return (forward if self.effects else central)(self.residual, z)

    def warnings(self, z: RealArray) -> list[str]:
        """Return where the formulae do not hold at one point, shape (n,)."""
        with collected_warnings() as texts:
            for experiment in self.experiments:
                experiment.predict(self.points(z))
        return list(dict.fromkeys(texts))

    @property
    def quantities(self) -> tuple[str, str]:
        """What the parts of R are called."""
        return ("real", "imag")

    @property
    def blocks(self) -> int:
        """A sixth of the band of a single measurement is left out at a time."""
        return 6

    @property
    def held_out_decides(self) -> bool:
        """What tube and mounting do wrong is smooth in frequency, and common to the data kept and left out."""
        return False

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act in some measurement: only one of tubes can."""
        return isinstance(effect, TubeEffect) and any(effect.applies(setting) for setting in self.settings)

    def with_effects(self, *effects: TubeEffect) -> StackProblem:
        """Return the hypothesis of other effects."""
        return replace(self, effects=effects)

    def of(self, data: Sequence[Observation]) -> StackProblem:
        """Return the same with residuals of some data only."""
        return replace(self, seen=tuple(data))

    def roughly(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals, shape (..., n), each part of a reflection coefficient being allowed to be off by `size`."""
        if not size:
            return self.residual
        widths = [np.sqrt(np.stack(data.spread, axis=-1) ** 2 + size**2).reshape(-1) for data in self.data]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self.differences(z), widths, strict=True)
            return np.concatenate([difference.view(float) / width for difference, width in pairs], axis=-1)

        return residual


def _own_coordinates(z: RealArray, count: int, known: Known | None) -> RealArray:
    """Return the first coordinates, shape (..., count), in the unknowns' own priors.

    Those far out are drawn in, for values must not overflow: smoothly, so that minima stay minima. At a bound the
    derivative, and with it the evidence, would hang on the side that rounding chooses.
    """
    u, room = z[..., :count], _WILDEST - _WILD
    far = np.maximum(np.abs(u) - _WILD, 0.0)
    drawn = np.where(far > 0, np.sign(u) * (_WILD + room * np.tanh(far / room)), u)
    return drawn if known is None else known.coordinates(drawn)


def at_values(problem: StackProblem, z: RealArray) -> dict[str, Stack]:
    """Return the stacks by name with the unknowns' values of coordinates of shape (n,) in their fields."""
    return {
        name: with_values(problem.stacks[name], {path: column.item() for path, column in samples.items()})
        for name, samples in problem.samples(problem.own_coordinates(z)[None]).items()
    }
