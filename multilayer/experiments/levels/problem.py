"""Measured levels of stacks and unknown fields of these as one inverse problem, with effects or without."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.hypothesis import Part, values_of
from multilayer.experiments.levels.effects import LevelEffect, LevelSetting, acts_through_stack
from multilayer.experiments.levels.response import LevelResponse, level_of
from multilayer.experiments.levels.sound_field import mean_power
from multilayer.experiments.stacks.effects import TubeEffect
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.problem import StackProblem, own_coordinates, rows_of
from multilayer.experiments.stacks.responses import respond
from multilayer.experiments.stacks.unknowns import UnknownFields
from multilayer.inference.problem import Experiment, GaussianPrior, Points
from multilayer.stack import Stack

UNIT = {"transmission_loss": 25.0, "absorption": 1.0}  # dB, and 1: what relative sizes of discrepancies refer to
_AT_ONCE = 8192  # samples times waves of one batched solve


@dataclass(frozen=True, eq=False)
class LevelExperiment(Experiment):
    """A measurement of transmission loss or absorption.

    Attributes
    ----------
    observation : Observation
    fields : UnknownFields
        Their parameters are the first unknowns.
    earlier : GaussianPrior, optional
        Of these, from an earlier measurement.
    setting : LevelSetting
        The measurement as effects see it.
    effects : tuple of LevelEffect
        Or of tubes, if they change nothing but the stack; their parameters are the last unknowns.
    """

    is_differentiable: ClassVar[bool] = False  # by differences, of which what is remembered costs nothing

    observation: Observation
    fields: UnknownFields
    earlier: GaussianPrior | None
    setting: LevelSetting
    effects: tuple[Any, ...] = ()

    @property
    def data(self) -> Observation:
        """The measured values."""
        return self.observation

    def difference(self, points: Points) -> NDArray[Any]:
        """Return predicted minus measured values, shape (m, n)."""
        return self.observation.difference(self.predict(points))

    def whiten(self, difference: NDArray[Any]) -> RealArray:
        """Return differences as independent numbers of unit variance."""
        return self.observation.whitening(np.asarray(difference, dtype=float))

    def predict(self, points: Points) -> NDArray[Any]:
        """Return levels, dB, or absorption coefficients, shape (m, n); NaN where there is no response."""
        every = zip(self.effects, values_of(self.effects, points), strict=True)
        acting = [(effect, values) for effect, values in every if effect.applies(self.setting)]
        before = [pair for pair in acting if isinstance(pair[0], TubeEffect) or pair[0].changes_waves]
        share = self._remembered(points, before)
        stack = self.setting.stack
        behind = [pair for pair in acting if not isinstance(pair[0], TubeEffect)]  # those change the stack only
        for effect, values in behind:
            share = effect.beside(self.setting, stack, share, values)
        level = level_of(self.setting.quantity, share)
        for effect, values in behind:
            level = effect.reading(self.setting, level, values)
        return np.broadcast_to(level, (len(points.z), level.shape[-1]))

    def _remembered(self, points: Points, acting: Sequence[tuple[Any, Values]]) -> RealArray:
        """Return the share of the power of each sample, shape (m, n), of which each is computed once."""
        z, count = points.z[:, : len(self.fields.field_parameters)], len(self.fields.field_parameters)
        # coordinates mean other values beside an earlier measurement
        earlier = None if self.earlier is None else (self.earlier.mean.tobytes(), self.earlier.root.tobytes())
        key = (*(effect.name for effect, _ in acting), earlier)
        columns = [column for _, values in acting for column in values.values()]

        def compute(rows: RealArray) -> RealArray:
            first = count
            changed = []
            for effect, values in acting:
                here = rows[:, first : first + len(values)]
                changed.append((effect, dict(zip(values, here.T[..., None], strict=True))))
                first += len(values)
            return self._shares(rows[:, :count], changed)

        return self.setting.response.remembered(key, np.concatenate([z, *columns], axis=1), compute)

    def _shares(self, z: RealArray, acting: Sequence[tuple[Any, Values]]) -> RealArray:
        """Return the share of the power of each sample, shape (m, n)."""
        own = own_coordinates(z, len(self.fields.field_parameters), self.earlier)
        samples, count = self.fields.samples(own)[self.observation.stack], len(z)
        stack, step = self.fields.stacks[self.observation.stack], max(1, _AT_ONCE // self.setting.response.n_waves)
        pieces = []
        for first in range(0, count, step):
            piece, size = np.s_[first : first + step], min(step, count - first)
            here = {path: column[piece] for path, column in samples.items()}
            pieces.append(respond(partial(self._share, rows_of(acting, piece)), stack, here, size))
        return np.concatenate(pieces)

    def _share(self, acting: Sequence[tuple[Any, Values]], stack: Stack, rows: slice) -> NDArray[Any]:
        """Return the share of some samples, shape (k, n) or (1, n) where it is the same for all."""
        pairs, setting = rows_of(acting, rows), self.setting
        response, sound = setting.response, setting.sound
        for effect, values in pairs:
            if not isinstance(effect, TubeEffect):  # which changes the stack only
                sound = effect.sound_field(setting.at_waves, sound, values)

        along = [pair for pair in pairs if _varies(pair[0])]
        for effect, values in pairs:
            if not _varies(effect):
                stack = effect.stack(setting, stack, values)

        def as_met(stack: Stack) -> Stack:
            for effect, values in along:
                stack = effect.stack(setting.at_waves, stack, values)
            return stack

        return mean_power(setting.quantity, stack, sound, response.nodes, response.ridges, as_met)


def _varies(effect: Any) -> bool:
    """Tell whether an effect gives fields that vary along frequency."""
    return isinstance(effect, LevelEffect) and effect.varies


@dataclass(frozen=True)
class LevelProblem(StackProblem):
    """Measured levels of stacks with unknown fields, and unmodelled effects."""

    kind = LevelEffect.kind

    @property
    def settings(self) -> tuple[LevelSetting, ...]:
        """Every measurement in use, as effects see it."""
        return self._settings

    @cached_property
    def _settings(self) -> tuple[LevelSetting, ...]:
        return tuple(
            LevelSetting(data.name, data.frequency, self.stacks[data.stack], data.response, self.tube)
            for data in self.data
            if isinstance(data.response, LevelResponse)
        )

    @cached_property
    def experiments(self) -> tuple[LevelExperiment, ...]:
        """An experiment for each measurement in use."""
        fields = UnknownFields(self.stacks, self.unknowns)
        return tuple(
            LevelExperiment(data, fields, self.earlier, setting, self.effects)
            for data, setting in zip(self.data, self.settings, strict=True)
        )

    @property
    def quantities(self) -> tuple[str, ...]:
        """Name of the quantity: a level, or absorption."""
        return ("level",) if self.is_loss else ("absorption",)

    @property
    def shown_as(self) -> tuple[Part, ...]:
        """A level in dB, or absorption."""
        return (Part("transmission loss", "dB") if self.is_loss else Part("absorption"),)

    @property
    def is_loss(self) -> bool:
        """Whether levels are transmission losses."""
        return self.settings[0].quantity == "transmission_loss"

    @property
    def unit(self) -> float:
        """25 dB of a loss, 1 of absorption."""
        return UNIT[self.settings[0].quantity]

    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act in some measurement: one of levels, or of a tube's stack alone."""
        if isinstance(effect, LevelEffect):
            return any(effect.applies(setting) for setting in self.settings)
        if self.is_loss or not acts_through_stack(effect):
            return False
        settings: tuple[Any, ...] = self.settings  # such an effect asks for no more than the stack
        return any(effect.applies(setting) for setting in settings)

    def inflated_residual(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals, shape (..., n), each datum having an additional error of `size` units."""
        if not size:
            return self.residual
        widths = [np.hypot(data.spread[0], size * self.unit) for data in self.data]

        def residual(z: RealArray) -> RealArray:
            pairs = zip(self.differences(z), widths, strict=True)
            return np.concatenate([difference / width for difference, width in pairs], axis=-1)

        return residual
