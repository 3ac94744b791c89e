"""A porous layer of another flow resistivity than stated."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, with_each
from multilayer.layers.pores import PoreLayer
from multilayer.stack import Stack


class FlowResistivity(LevelEffect):
    """The flow resistivity of all porous layers, times a factor."""

    name = "flow_resistivity"
    place = "filling"
    quantities = ("transmission_loss", "absorption")
    law = "flow resistivity exp(x) of all porous layers"
    separated_by = "ISO 9053"
    source = "laboratories differ by 20 % and more, pieces of one product by as much"
    parameters = (signed("log_factor", 0.4),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether a layer has a flow resistivity."""
        return super().applies(setting) and bool(resistive(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with another flow resistivity."""
        return with_each(stack, resistive(stack), "flow_resistivity", np.exp(values["log_factor"]))


def resistive(stack: Stack) -> list[int]:
    """Return the indices of porous layers that state a flow resistivity."""
    return [
        i
        for i, layer in enumerate(stack.layers)
        if isinstance(layer, PoreLayer) and getattr(layer, "flow_resistivity", None) is not None
    ]
