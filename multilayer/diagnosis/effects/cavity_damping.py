"""Losses of sound in an air cavity: at its edges, in studs, in what lies in it."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of
from multilayer.experiments.stacks.effects import with_layer
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack


class CavityDamping(LevelEffect):
    """A complex bulk modulus of the air between plates, with the same loss factor at all frequencies."""

    name = "cavity_damping"
    place = "cavity"
    law = "bulk modulus (1 + i e) of the air between plates"
    separated_by = "a filled cavity; the decay of sound in the cavity"
    source = "an undamped cavity of infinite extent is far too reverberant: loss factors of 0.01 to 0.3 fit"
    parameters = (positive("loss", 0.05, 1.0),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there is air between plates."""
        return super().applies(setting) and bool(air_between(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with losses in its cavities."""
        return with_cavity_losses(stack, values["loss"])


def air_between(stack: Stack) -> list[int]:
    """Return the indices of fluid layers between plates."""
    plates = plates_of(stack)
    inside = range(plates[0], plates[-1]) if plates else range(0)
    return [i for i in inside if isinstance(stack.layers[i], Fluid)]


def with_cavity_losses(stack: Stack, loss: object) -> Stack:
    """Return the stack with a loss factor of the fluids between its plates."""
    for index in air_between(stack):
        layer = stack.layers[index]
        assert isinstance(layer, Fluid)
        speed = stack.ambient.gas.sound_speed if layer.sound_speed is None else layer.sound_speed
        lossy = speed * np.sqrt(1 + 1j * np.asarray(loss))
        stack = with_layer(stack, index, layer.model_copy(update={"sound_speed": lossy}))
    return stack
