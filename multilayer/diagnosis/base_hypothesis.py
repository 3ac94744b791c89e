"""What hypotheses of the rig and of tubes share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cached_property
from typing import Generic, Self, TypeVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import BaseEffect, Values
from multilayer.inference.derivative import forward
from multilayer.inference.priors import Parameter, Priors

E = TypeVar("E", bound=BaseEffect)


class BaseHypothesis(ABC, Generic[E]):
    """A `Problem`: a nominal model with effects, whose parameters follow those of the model; see `AnyHypothesis`."""

    effects: tuple[E, ...]

    @property
    @abstractmethod
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Those of the nominal model."""

    @abstractmethod
    def log_ratios(self, z: RealArray) -> list[ComplexArray]:
        """Return modelled minus measured, shape (..., n), of every configuration."""

    @abstractmethod
    def whitened(self, index: int, difference: ComplexArray) -> RealArray:
        """Return a difference of one configuration as independent unit normal numbers."""

    @abstractmethod
    def with_effects(self, *effects: E) -> Self:
        """Return the hypothesis of other effects."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects."""
        return tuple(effect.name for effect in self.effects)

    @cached_property
    def effect_parameters(self) -> tuple[Parameter, ...]:
        """The effects' parameters, as ``sensor_mass.mass``."""
        return tuple(
            parameter.model_copy(update={"name": f"{effect.name}.{parameter.name}"})
            for effect in self.effects
            for parameter in effect.parameters
        )

    @cached_property
    def _effect_priors(self) -> Priors:
        return Priors.of(self.effect_parameters)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The nominal model's, then the effects'."""
        return (*self.nominal_parameters, *self.effect_parameters)

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data); NaN where there is no response."""
        parts = [self.whitened(i, d) for i, d in enumerate(self.log_ratios(z))]
        return np.concatenate(parts, axis=-1)

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative, from one batch."""
        return forward(self.residual, z)

    def law_change(self, index: int, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return what the law of one of the effects, wrong by its whole size, would change: all that it does."""
        others, rest = self.without(index, z)
        pairs = zip(self.log_ratios(z) if shown is None else shown, others.log_ratios(rest), strict=True)
        return [full - bare for full, bare in pairs]

    def without(self, index: int, z: RealArray) -> tuple[Self, RealArray]:
        """Return the hypothesis without one of its effects, and the coordinates, shape (..., d), that are left."""
        own = len(self.effects[index].parameters)
        first = len(self.nominal_parameters) + sum(len(effect.parameters) for effect in self.effects[:index])
        others = self.with_effects(*self.effects[:index], *self.effects[index + 1 :])
        return others, np.delete(z, np.s_[first : first + own], axis=-1)

    def effect_values(self, z: RealArray) -> Sequence[Values]:
        """Return the parameters of every effect, each of shape (..., 1), of coordinates of all shape (..., d)."""
        flat = self._effect_priors.named(z[..., len(self.nominal_parameters) :])
        return [
            {p.name: flat[f"{effect.name}.{p.name}"][..., None] for p in effect.parameters} for effect in self.effects
        ]
