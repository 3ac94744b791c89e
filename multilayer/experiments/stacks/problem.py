"""Measurements of stacks and unknown fields of these as one inverse problem, with effects of a tube or without."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import MultilayerError
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.hypothesis import Hypothesis, Part, values_of
from multilayer.experiments.stacks.effects import Tube, TubeEffect, TubeSetting
from multilayer.experiments.stacks.file import StackFitFile
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.responses import respond
from multilayer.experiments.stacks.unknowns import UnknownFields, placed
from multilayer.inference.derivative import central, forward
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Experiment, GaussianPrior, Points
from multilayer.paths import with_values
from multilayer.simulation.warned import collected_warnings
from multilayer.stack import Stack

E = TypeVar("E", bound=BaseEffect)
_MANY = 4096  # points of one batched solve: of fewer, differences cost less than derivatives
_AT_ONCE = 16_384  # samples times frequencies of one batched solve
_FAR, _ROOM = 8.0, 4.0  # coordinates beyond the first are compressed smoothly to at most so much more
FARTHEST = 40.0  # the same of fits, whose priors may be far off and are then told


@dataclass(frozen=True, eq=False)
class StackExperiment(Experiment):
    """A measurement of a stack.

    Attributes
    ----------
    observation : Observation
    fields : UnknownFields
        Their parameters are the first unknowns.
    earlier : GaussianPrior, optional
        Of these, from an earlier measurement.
    setting : TubeSetting
        The measurement as effects see it.
    effects : tuple of TubeEffect
        Their parameters are the last unknowns.
    far : float
        See `own_coordinates`.
    """

    observation: Observation
    fields: UnknownFields
    earlier: GaussianPrior | None
    setting: TubeSetting
    effects: tuple[TubeEffect, ...] = ()
    far: float = _FAR

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
        """Return the response, shape (m, n), whose kind `Observation.scale` tells; NaN where there is none."""
        samples = points.shared("fields", partial(self.samples, points.z))[self.observation.stack]
        every = zip(self.effects, values_of(self.effects, points), strict=True)
        values = [(effect, parameters) for effect, parameters in every if effect.applies(self.setting)]
        count, step = len(points.z), max(1, _AT_ONCE // self.observation.points)
        stack = self.fields.stacks[self.observation.stack]
        if not samples and not values:
            return np.broadcast_to(response := self.observation.response(stack), (count, *response.shape))
        one_by_one = self.observation.one_by_one or any(effect.changes_gas for effect, _ in values)
        pieces = []
        for first in range(0, count, step):
            piece = np.s_[first : first + step]
            here = {path: column[piece] for path, column in samples.items()}
            acting = rows_of(values, piece)
            size = min(step, count - first)
            pieces.append(respond(partial(self._respond, acting), stack, here, size, one_by_one))
        return np.concatenate(pieces)

    @property
    def is_differentiable(self) -> bool:
        """Whether `linearised` is worth while: the response has derivatives, and differences take many solutions."""
        response, paths = self.observation.response, self._paths
        if self.effects or not paths or not getattr(response, "is_differentiable", False):
            return False
        if not all(path.startswith("layers.") for path in paths):
            return False
        points = (2 * len(self.fields.field_parameters) + 1) * self.observation.points
        return self.observation.one_by_one or points > _MANY

    @cached_property
    def _paths(self) -> tuple[str, ...]:
        targets = (target for unknown in self.fields.unknowns for target in unknown.fields)
        return tuple(path for stack, path in targets if stack == self.observation.stack)

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return whitened residuals, shape (n_data,), and their derivative, (n_data, n), at coordinates, shape (n,).

        Raises
        ------
        MultilayerError
            When the stack has no response there.
        """
        paths = self._paths

        def values(points: RealArray) -> RealArray:
            columns = self.samples(points)[self.observation.stack]
            return np.stack([columns[path] for path in paths], axis=-1)

        here, by_coordinates = central(values, z)
        stack = with_values(self.fields.stacks[self.observation.stack], dict(zip(paths, here.tolist(), strict=True)))
        response, slopes = self.observation.response.linearised(stack, paths)  # type: ignore[attr-defined]
        by_fields = self.observation.scale.slope_of_response(response) * slopes
        residual = self.whiten(self.observation.difference(response))
        return residual, self.whiten(by_coordinates.T @ by_fields).T

    def samples(self, z: RealArray) -> dict[str, dict[str, RealArray]]:
        """Return by stack and path the values, shape (m,), of the unknown fields."""
        return self.fields.samples(own_coordinates(z, len(self.fields.field_parameters), self.earlier, self.far))

    def _respond(self, acting: Sequence[tuple[TubeEffect, Values]], stack: Stack, rows: slice) -> NDArray[Any]:
        """Return the response of some samples, shape (k, n) or (n,) where it is the same for all."""
        if not acting:
            return self.observation.response(stack)
        pairs = rows_of(acting, rows)
        for effect, parameters in pairs:
            stack = effect.stack(self.setting, stack, parameters)
        response = self.observation.response(stack)
        count = max((len(column) for _, parameters in pairs for column in parameters.values()), default=1)
        reflection = np.array(np.broadcast_to(response, (count, response.shape[-1])))  # an effect may write into it
        for effect, parameters in pairs:
            reflection = effect.surface(self.setting, stack, reflection, parameters)
        for effect, parameters in pairs:
            reflection = effect.reading(self.setting, reflection, parameters)
        return np.asarray(reflection)


def rows_of(acting: Sequence[tuple[E, Values]], rows: slice) -> list[tuple[E, Values]]:
    """Return effects with some rows of their parameters' values."""
    return [(effect, {name: column[rows] for name, column in values.items()}) for effect, values in acting]


@dataclass(frozen=True)
class StackProblem(UnknownFields, Hypothesis):
    """Measurements of stacks with unknown fields; with unmodelled effects, measurements of reflection in a tube.

    Attributes
    ----------
    observations : tuple of Observation
    tube : Tube
    effects : tuple of TubeEffect
    earlier : GaussianPrior, optional
        The posterior of an earlier fit, in place of the unknowns' own priors.
    used : tuple of Observation, optional
        The data that residuals are made of; all when left out.
    far : float
        See `own_coordinates`.
    """

    kind = TubeEffect.kind

    observations: tuple[Observation, ...]
    tube: Tube = field(default_factory=Tube)
    effects: tuple[Any, ...] = ()
    earlier: GaussianPrior | None = None
    used: tuple[Observation, ...] | None = None
    far: float = _FAR

    @classmethod
    def of_file(cls, file: StackFitFile) -> StackProblem:
        """Return the problem that a file states."""
        return cls(placed(file.by_name, file.resolved), file.resolved, file.observations, far=FARTHEST)

    @property
    def data(self) -> tuple[Observation, ...]:
        """The measurements in use."""
        return self.observations if self.used is None else self.used

    @property
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """The unknowns' coordinates, one unknown after the other."""
        return self.field_parameters

    @cached_property
    def start(self) -> RealArray:
        """Coordinates of the unknowns near the nominal values, or at the mean of an earlier posterior."""
        return self.nominal_start if self.earlier is None else np.zeros(len(self.nominal_parameters))

    def own_coordinates(self, z: RealArray) -> RealArray:
        """Return coordinates of the unknowns in their own priors, shape (..., d), of all coordinates."""
        return own_coordinates(z, len(self.nominal_parameters), self.earlier, self.far)

    def at_rest(self, z: RealArray) -> RealArray:
        """Return the nominal values: a gap may have dragged the unknowns far off."""
        return self.start

    @property
    def settings(self) -> tuple[Any, ...]:
        """Every measurement in use, as effects see it."""
        return self._settings

    def settings_at(self, z: RealArray) -> tuple[Any, ...]:
        """Return the `settings` with the stacks at coordinates of shape (n,)."""
        stacks = at_values(self, z)
        pairs = zip(self.settings, self.data, strict=True)
        return tuple(replace(setting, stack=stacks[data.stack]) for setting, data in pairs)

    @cached_property
    def _settings(self) -> tuple[Any, ...]:
        return tuple(
            TubeSetting(data.name, data.frequency, data.angle, self.stacks[data.stack], self.tube) for data in self.data
        )

    @cached_property
    def experiments(self) -> tuple[Any, ...]:
        """An experiment for each measurement in use."""
        fields = UnknownFields(self.stacks, self.unknowns)
        return tuple(
            StackExperiment(data, fields, self.earlier, setting, self.effects, self.far)
            for data, setting in zip(self.data, self.settings, strict=True)
        )

    def predict(self, z: RealArray) -> list[NDArray[Any]]:
        """Return the response of every measurement, shape (..., n_frequency), of coordinates of shape (..., n)."""
        points = self.points(z)
        with collected_warnings():  # a search leaves the range of formulae; the solution's warnings are reported
            responses = [experiment.predict(points) for experiment in self.experiments]
        return [values.reshape(*z.shape[:-1], values.shape[-1]) for values in responses]

    def differences(self, z: RealArray) -> list[NDArray[Any]]:
        """Return predicted minus measured values, shape (..., n), of every measurement, in the fitted quantity."""
        with np.errstate(all="ignore"):  # a search leaves the range of formulae, and of floating-point numbers
            return [data.difference(response) for data, response in zip(self.data, self.predict(z), strict=True)]

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative: exact ones of measurements that differences would solve many times.

        Of all others from one batched solve per measurement.
        """
        if self.effects:
            return forward(self.residual, z)
        if not any(experiment.is_differentiable for experiment in self.experiments):
            return central(self.residual, z)
        parts = [self._part(experiment, z) for experiment in self.experiments]
        residuals, slopes = zip(*parts, strict=True)
        return np.concatenate(residuals), np.concatenate(slopes)

    def _part(self, experiment: StackExperiment, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual and derivative of one measurement."""
        with collected_warnings(), np.errstate(all="ignore"):  # as for `predict` and `differences`
            if experiment.is_differentiable:
                try:
                    return experiment.linearised(z)
                except MultilayerError:  # without a response there, differences tell where there is one
                    pass
            return central(lambda points: experiment.whiten(experiment.difference(self.points(points))), z)

    def warnings(self, z: RealArray) -> list[str]:
        """Return warnings where formulae do not hold at a point, shape (n,)."""
        with collected_warnings() as texts:
            for experiment in self.experiments:
                experiment.predict(self.points(z))
        return list(dict.fromkeys(texts))

    @property
    def quantities(self) -> tuple[str, ...]:
        """Names of the parts of R."""
        return ("real", "imag")

    @property
    def shown_as(self) -> tuple[Part, ...]:
        """Real and imaginary part of R."""
        return Part("Re R"), Part("Im R")

    @property
    def spreads(self) -> list[list[RealArray]]:
        """Standard deviations of every part of every measurement, of noise and model error."""
        return [data.spread for data in self.data]

    @property
    def blocks(self) -> int:
        """Each fold leaves out a sixth of the band of a single measurement."""
        return 6

    @property
    def held_out_decides(self) -> bool:
        """False: errors of tube and mounting are smooth in frequency, and common to the data kept and left out."""
        return False

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act in some measurement: it must be one of tubes."""
        return isinstance(effect, TubeEffect) and any(effect.applies(setting) for setting in self.settings)

    def with_effects(self, *effects: Any) -> Self:
        """Return the hypothesis with these effects instead."""
        return replace(self, effects=effects)

    def with_data(self, data: Sequence[Observation]) -> Self:
        """Return the hypothesis with residuals of these data only."""
        return replace(self, used=tuple(data))

    def weighed_at(self, z: RealArray) -> Self:
        """Return the problem with relative noise and model errors as shares of the responses at z, shape (n,).

        The problem itself where nothing changes.
        """
        pairs = zip(self.observations, self.predict(z), strict=True)
        weighed = tuple(observation.weighed_at(response) for observation, response in pairs)
        if all(new is old for new, old in zip(weighed, self.observations, strict=True)):
            return self
        return replace(self, observations=weighed)

    def inflated_residual(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals, shape (..., n), each part of R having an additional error of `size`."""
        if not size:
            return self.residual
        widths = [np.sqrt(np.stack(data.spread, axis=-1) ** 2 + size**2).reshape(-1) for data in self.data]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self.differences(z), widths, strict=True)
            return np.concatenate([difference.view(float) / width for difference, width in pairs], axis=-1)

        return residual


def own_coordinates(z: RealArray, count: int, earlier: GaussianPrior | None, far: float = _FAR) -> RealArray:
    """Return the first coordinates, shape (..., count), in the unknowns' own priors.

    Coordinates beyond `far` are compressed, since values must not overflow; smoothly, so that minima stay minima. With
    a sharp bound the derivative there, and with it the evidence, would depend on rounding.
    """
    u = z[..., :count]
    beyond = np.maximum(np.abs(u) - far, 0.0)
    compressed = np.where(beyond > 0, np.sign(u) * (far + _ROOM * np.tanh(beyond / _ROOM)), u)
    return compressed if earlier is None else earlier.coordinates(compressed)


def at_values(problem: StackProblem, z: RealArray) -> dict[str, Stack]:
    """Return the stacks by name, with the values of the unknowns at coordinates of shape (n,) in their fields."""
    return {
        name: with_values(problem.stacks[name], {path: column.item() for path, column in samples.items()})
        for name, samples in problem.samples(problem.own_coordinates(z)[None]).items()
    }
