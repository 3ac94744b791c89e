"""A thin facing in front of the sample.

J. F. Allard & N. Atalla, Propagation of Sound in Porous Media, 2nd ed., Wiley 2009, ch. 11 (screens).
"""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Values, positive
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, with_layers
from multilayer.layers.screen import Screen
from multilayer.stack import Stack


class Facing(TubeEffect):
    """Flow resistance and mass of a thin sheet in parallel: a scrim or a skin; a film in the limit of no flow."""

    name = "facing"
    place = "in_front"
    law = "Z + 1/(1/r + 1/(i w m)) at the front face"
    separated_by = "taking the facing off; turning the sample round; another thickness"
    source = "non-woven scrims some 30 to 1000 N s/m3 at 0.03 to 0.3 kg/m2; skins of foams alike"
    parameters = (positive("flow_resistance", 150.0, 1.2, "N*s/m^3"), positive("surface_density", 0.1, 0.8, "kg/m^2"))
    law_error = 0.05

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with a screen in front, not glued to it."""
        sheet = Screen(flow_resistance=1.0, surface_density=1.0).model_copy(update=dict(values))
        return with_layers(stack, (sheet, *stack.layers))
