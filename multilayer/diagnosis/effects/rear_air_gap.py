"""Air between the sample and the wall behind it."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Values, positive
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, with_layers
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack


class RearAirGap(TubeEffect):
    """A layer of air before the wall."""

    name = "rear_air_gap"
    place = "behind"
    law = "a layer of air of depth d between sample and wall"
    separated_by = "pressing the sample to the wall; a known cavity, to which the depth adds"
    source = "samples cut by hand stand off by 1 to 5 mm, a cavity left on purpose by up to some centimetres"
    parameters = (positive("depth", 0.01, 1.2, "m"),)
    law_error = 0.01  # air is known

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether the stack ends at a rigid wall."""
        return setting.stack.termination == "rigid"

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with a layer of air behind the last layer."""
        air = Fluid(thickness=1.0).model_copy(update={"thickness": values["depth"]})
        return with_layers(stack, (*stack.layers, air))
