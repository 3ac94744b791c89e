"""Experiments under a hypothesis: a nominal model, and unmodelled effects that act beside it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, Protocol, Self

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Experiments, Points


class Data(Protocol):
    """Measured complex values of one configuration."""

    @property
    def name(self) -> str:
        """Of the configuration."""

    @property
    def frequency(self) -> RealArray:
        """Hz, shape (n,)."""

    @property
    def burst(self) -> IndexArray:
        """To which group each value belongs, shape (n,): what is left out together."""

    @property
    def centres(self) -> RealArray:
        """Frequencies of the groups, Hz, shape (n_groups,)."""

    def part(self, kept: IndexArray) -> Self:
        """Return the data of some groups only, numbered anew."""


class Hypothesis(Experiments):
    """Experiments whose unknowns are those of a nominal model, then those of some effects; nominal where there is none.

    Attributes
    ----------
    effects : tuple of BaseEffect
    """

    effects: tuple[Any, ...]

    @property
    @abstractmethod
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Those of the nominal model."""

    @property
    @abstractmethod
    def data(self) -> tuple[Any, ...]:
        """What residuals are made of, as `Data`."""

    @property
    @abstractmethod
    def quantities(self) -> tuple[str, str]:
        """What real and imaginary part of `differences` are."""

    @property
    @abstractmethod
    def blocks(self) -> int:
        """In how many pieces the data of a single configuration are left out, one after the other."""

    @property
    @abstractmethod
    def held_out_decides(self) -> bool:
        """Whether errors of left-out data are their own, so that what foretells these tells causes apart."""

    @abstractmethod
    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act here at all."""

    @abstractmethod
    def with_effects(self, *effects: Any) -> Self:
        """Return the hypothesis of other effects."""

    @abstractmethod
    def of(self, data: Sequence[Any]) -> Self:
        """Return the same with residuals of some data only; the unknowns stay."""

    @abstractmethod
    def roughly(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals for a first search, each datum being allowed to be off by `size` more, relative."""

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
    def parameters(self) -> tuple[Parameter, ...]:
        """The nominal model's, then the effects'."""
        return (*self.nominal_parameters, *self.effect_parameters)

    def without(self, index: int, z: RealArray) -> tuple[Self, RealArray]:
        """Return the hypothesis without one of its effects, and the coordinates, shape (..., d), that are left."""
        count = len(self.effects[index].parameters)
        first = len(self.nominal_parameters) + sum(len(effect.parameters) for effect in self.effects[:index])
        others = self.with_effects(*self.effects[:index], *self.effects[index + 1 :])
        return others, np.delete(z, np.s_[first : first + count], axis=-1)

    def law_change(self, index: int, z: RealArray, shown: Sequence[ComplexArray] | None = None) -> list[ComplexArray]:
        """Return what the law of one of the effects, wrong by its whole size, would change in `differences`.

        All that the effect does, unless a kind of hypothesis knows better. Of coordinates of shape (..., d); `shown`
        are the `differences` there where they are known already.
        """
        others, rest = self.without(index, z)
        pairs = zip(self.differences(z) if shown is None else shown, others.differences(rest), strict=True)
        return [full - bare for full, bare in pairs]


def values_of(effects: Sequence[BaseEffect], points: Points) -> list[Values]:
    """Return the parameters of every effect, each of shape (m, 1), at some points."""
    named = points.named
    return [{p.name: named[f"{effect.name}.{p.name}"][:, None] for p in effect.parameters} for effect in effects]
