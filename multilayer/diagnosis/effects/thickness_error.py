"""A sample of another thickness than stated."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting, sample_index, with_layer
from multilayer.stack import Stack


class ThicknessError(TubeEffect):
    """The thickest porous layer is thicker or thinner, its material the same."""

    name = "thickness_error"
    law = "h (1 + e) of the sample"
    separated_by = "a calliper; another thickness, if the error is not proportional"
    source = "soft samples are measured to 1 mm or some per cent"
    parameters = (signed("relative", 0.05),)
    law_error = 0.01

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether there is a sample."""
        return sample_index(setting.stack) is not None

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the sample's thickness changed."""
        index = sample_index(stack)
        assert index is not None
        layer = stack.layers[index]
        thickness = getattr(layer, "thickness") * (1 + values["relative"])  # noqa: B009
        return with_layer(stack, index, layer.model_copy(update={"thickness": thickness}))
