"""Unmodelled effects on transmission loss and absorption, and measurements as these see them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import ClassVar, TypeGuard

import numpy as np

from multilayer.arrays import RealArray
from multilayer.experiments.effects import BaseEffect, Values
from multilayer.experiments.levels.response import LevelResponse
from multilayer.experiments.levels.sound_field import Quantity, SoundField, wave_frequencies
from multilayer.experiments.stacks.effects import Tube, TubeEffect, with_layer
from multilayer.layers.base import ElasticLayer, Layer
from multilayer.media.gas import Gas
from multilayer.stack import Stack


@dataclass(frozen=True, eq=False)
class LevelSetting:
    """A measurement of transmission loss or absorption, as effects see it.

    Attributes
    ----------
    name : str
    frequency : array, shape (n,)
        Of the data, Hz; of all waves where an effect varies the stack along frequency.
    stack : Stack
        With nominal values.
    response : LevelResponse
    tube : Tube
        Of absorption in a tube.
    """

    name: str
    frequency: RealArray
    stack: Stack
    response: LevelResponse
    tube: Tube = field(default_factory=Tube)

    @property
    def quantity(self) -> Quantity:
        """What is measured."""
        return self.response.quantity

    @property
    def sound(self) -> SoundField:
        """The sound field as it is stated."""
        return self.response.sound

    @property
    def omega(self) -> RealArray:
        """Angular frequency, rad/s."""
        return 2 * np.pi * self.frequency

    @cached_property
    def gas(self) -> Gas:
        """The ambient gas."""
        return self.stack.ambient.gas

    @cached_property
    def at_waves(self) -> LevelSetting:
        """The same with the frequency of every wave in place of those of the data: for what changes the stack."""
        return replace(self, frequency=wave_frequencies(self.response.nodes, self.sound, self.response.ridges))

    @property
    def nominal_share(self) -> RealArray:
        """The share of the power of the nominal stack, shape (n,)."""
        share = self.response.remembered("nominal", np.zeros((1, 1)), lambda _: self.response.share(self.stack))
        return np.asarray(share[0])


class LevelEffect(BaseEffect):
    """An unmodelled effect on levels; subclass it and override what it changes.

    The model of a datum is computed in this order: the construction (`stack`), the sound field (`sound_field`), the
    share of the incident power that gets through or is absorbed, averaged over field and band (`beside`), and what is
    reported of it (`reading`). Every hook returns its argument where the effect does not act. Values of parameters have
    the shape (m, 1), frequencies (n,); in the hook `stack` of effects that vary along frequency they are those of all
    waves (`LevelSetting.at_waves`).

    Attributes
    ----------
    place : str
        Name of a `places.LevelPlace`.
    quantities : tuple of str
        Measurements in which it can act.
    varies : bool
        Whether `stack` gives fields of shape (m, n_waves), which vary along frequency.
    """

    kind = "levels"
    quantities: ClassVar[tuple[str, ...]] = ("transmission_loss",)
    varies: ClassVar[bool] = False

    @property
    def changes_waves(self) -> bool:
        """Whether it changes the response to plane waves."""
        kind = type(self)
        return kind.stack is not LevelEffect.stack or kind.sound_field is not LevelEffect.sound_field

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether the effect can act in a measurement at all."""
        return setting.quantity in self.quantities

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the effect; fields may hold arrays of shape (m, 1), or (m, n_waves) if it varies."""
        return stack

    def sound_field(self, setting: LevelSetting, sound: SoundField, values: Values) -> SoundField:
        """Return the sound field with the effect."""
        return sound

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: Values) -> RealArray:
        """Return the share of the power, shape (m, n), given that of the construction itself."""
        return share

    def reading(self, setting: LevelSetting, level: RealArray, values: Values) -> RealArray:
        """Return the level, dB, or absorption as it is reported, shape (m, n)."""
        return level


def acts_through_stack(effect: BaseEffect) -> TypeGuard[TubeEffect]:
    """Tell whether an effect of a tube changes nothing but the stack, so that it can act on absorption alike."""
    if not isinstance(effect, TubeEffect):
        return False
    kind = type(effect)
    return (
        not effect.changes_gas
        and not effect.in_tubes_only
        and kind.stack is not TubeEffect.stack
        and kind.surface is TubeEffect.surface
        and kind.reading is TubeEffect.reading
    )


def with_each(stack: Stack, indices: Sequence[int], field: str, factor: RealArray) -> Stack:
    """Return the stack with a field of some layers times a factor."""
    for index in indices:
        layer: Layer = stack.layers[index]
        stack = with_layer(stack, index, layer.model_copy(update={field: getattr(layer, field) * factor}))
    return stack


def with_losses(stack: Stack, indices: Sequence[int], added: RealArray) -> Stack:
    """Return the stack with a loss factor of some plates that is larger by a value."""
    for index in indices:
        layer = stack.layers[index]
        assert isinstance(layer, ElasticLayer)
        stack = with_layer(stack, index, layer.model_copy(update={"loss_factor": layer.loss_factor + added}))
    return stack
