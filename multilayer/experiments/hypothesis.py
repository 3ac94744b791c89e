"""Experiments under a hypothesis: a nominal model, and the unmodelled effects that act besides."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, ClassVar, NamedTuple, Protocol, Self

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Experiments, Points
from multilayer.number_text import over_unit


class Data(Protocol):
    """Measured complex values of one configuration."""

    @property
    def name(self) -> str:
        """Name of the configuration."""

    @property
    def frequency(self) -> RealArray:
        """Hz, shape (n,)."""

    @property
    def burst(self) -> IndexArray:
        """Index of the group each value belongs to, shape (n,); cross-validation leaves out whole groups."""

    @property
    def centres(self) -> RealArray:
        """Frequencies of the groups, Hz, shape (n_groups,)."""

    @property
    def target(self) -> ComplexArray | RealArray:
        """The measured values in the quantity that is compared, shape (n,)."""

    def part(self, kept: IndexArray) -> Self:
        """Return the data of some groups only, the groups renumbered."""


class Part(NamedTuple):
    """A real quantity that is compared, as people are shown it: `factor` times a part of `Hypothesis.differences`."""

    title: str
    unit: str = ""
    factor: float = 1.0

    @property
    def label(self) -> str:
        """Title and unit, as an axis has them."""
        return over_unit(self.title, self.unit)


class Hypothesis(Experiments):
    """Experiments whose unknowns are those of a nominal model, then those of effects, if any.

    Attributes
    ----------
    effects : tuple of BaseEffect
    kind : str
        Of effects and places that there are.
    """

    effects: tuple[Any, ...]
    kind: ClassVar[str]

    @property
    @abstractmethod
    def settings(self) -> tuple[Any, ...]:
        """Every configuration in use, as effects see it."""

    def settings_at(self, z: RealArray) -> tuple[Any, ...]:
        """Return the `settings` with what they hold of the nominal model at coordinates of shape (n,)."""
        return self.settings

    def at_rest(self, z: RealArray) -> RealArray:
        """Return coordinates of the nominal model from which a gap has not dragged what is stated off, shape (n,)."""
        is_nuisance = np.array([parameter.nuisance for parameter in self.nominal_parameters], dtype=bool)
        return np.where(is_nuisance, 0.0, z)

    def modulus_scale(self, z: RealArray, frequency: float) -> float:
        """Return the amount of the sample's modulus at a frequency, Hz, in Pa; 1 where that is not modelled."""
        return 1.0

    @property
    def pieces(self) -> dict[str, dict[str, str]]:
        """What several configurations may share, by what it is called: the piece in each configuration."""
        return {}

    @property
    @abstractmethod
    def nominal_parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the nominal model."""

    @property
    @abstractmethod
    def data(self) -> tuple[Any, ...]:
        """The data that residuals are made of, as `Data`."""

    @property
    @abstractmethod
    def quantities(self) -> tuple[str, ...]:
        """Names of the quantities in the real and in the imaginary part of `differences`; one name of real ones."""

    @property
    @abstractmethod
    def shown_as(self) -> tuple[Part, ...]:
        """What each of the `quantities` is for people."""

    @property
    @abstractmethod
    def spreads(self) -> list[list[RealArray]]:
        """Standard deviations of noise and model error of every part of every experiment, in `differences`' unit."""

    @property
    def part_units(self) -> tuple[complex, ...]:
        """What a unit of each of the `quantities` is in `differences`: 1, and i where they are complex."""
        return (1.0, 1j)[: len(self.quantities)]

    @property
    def unit(self) -> float:
        """Size of `differences` that counts as 1 where thresholds and discrepancies are stated as relative ones."""
        return 1.0

    @property
    @abstractmethod
    def blocks(self) -> int:
        """Number of folds in the cross-validation of a single configuration."""

    @property
    @abstractmethod
    def held_out_decides(self) -> bool:
        """Whether errors of left-out data are independent, so that their prediction distinguishes between causes."""

    @abstractmethod
    def admits(self, effect: BaseEffect) -> bool:
        """Tell whether an effect can act here at all."""

    @abstractmethod
    def with_effects(self, *effects: Any) -> Self:
        """Return the hypothesis with these effects instead."""

    @abstractmethod
    def with_data(self, data: Sequence[Any]) -> Self:
        """Return the hypothesis with residuals of these data only; the unknowns stay."""

    @abstractmethod
    def inflated_residual(self, size: float) -> Callable[[RealArray], RealArray]:
        """Return residuals for a first search: every datum has an additional relative error of `size`."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the effects, without what only corrects the law of one of them."""
        return tuple(effect.name for effect in self.effects if not effect.error_of)

    @property
    def law_errors(self) -> tuple[float, ...]:
        """`BaseEffect.law_error` of every effect; 0 where the error is an unknown of the hypothesis itself."""
        drawn = {effect.error_of for effect in self.effects}
        return tuple(0.0 if effect.name in drawn else effect.law_error for effect in self.effects)

    def bare(self, z: RealArray) -> tuple[Self, RealArray]:
        """Return the hypothesis without errors of its effects' laws as unknowns, and the remaining coordinates."""
        errors = {effect.name for effect in self.effects if effect.error_of}
        kept = [parameter.name.partition(".")[0] not in errors for parameter in self.parameters]
        return self.with_effects(*(effect for effect in self.effects if not effect.error_of)), z[..., kept]

    @cached_property
    def effect_parameters(self) -> tuple[Parameter, ...]:
        """The effects' parameters, named as ``sensor_mass.mass``."""
        return parameters_of(self.effects)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the nominal model, then of the effects."""
        return (*self.nominal_parameters, *self.effect_parameters)

    def without(self, index: int, z: RealArray) -> tuple[Self, RealArray]:
        """Return the hypothesis without one of its effects, and the remaining coordinates, shape (..., d)."""
        count = len(self.effects[index].parameters)
        first = len(self.nominal_parameters) + sum(len(effect.parameters) for effect in self.effects[:index])
        if index not in self._without:
            self._without[index] = self.with_effects(*self.effects[:index], *self.effects[index + 1 :])
        return self._without[index], np.delete(z, np.s_[first : first + count], axis=-1)

    @cached_property
    def _without(self) -> dict[int, Self]:
        """The hypotheses without one of the effects, as far as they were asked for."""
        return {}

    def law_change(
        self, index: int, z: RealArray, differences: Sequence[ComplexArray] | None = None
    ) -> list[ComplexArray]:
        """Return the change of `differences` for a relative error of 1 in the law of one of the effects.

        By default this is all that the effect changes.

        Parameters
        ----------
        index : int
            Of the effect.
        z : array, shape (..., d)
        differences : sequence of array, optional
            `differences` at z, where they are computed already.
        """
        others, rest = self.without(index, z)
        pairs = zip(self.differences(z) if differences is None else differences, others.differences(rest), strict=True)
        return [full - bare for full, bare in pairs]


def parameters_of(effects: Sequence[BaseEffect]) -> tuple[Parameter, ...]:
    """Return the parameters of effects, named as ``sensor_mass.mass``."""
    return tuple(
        parameter.model_copy(update={"name": f"{effect.name}.{parameter.name}"})
        for effect in effects
        for parameter in effect.parameters
    )


def values_of(effects: Sequence[BaseEffect], points: Points) -> list[Values]:
    """Return every effect's parameters by name, each of shape (m, 1), at m points."""
    named = points.named
    return [{p.name: named[f"{effect.name}.{p.name}"][:, None] for p in effect.parameters} for effect in effects]
