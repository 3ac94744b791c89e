"""Part of the base signal in the top channel."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class Crosstalk(Effect):
    """T + c."""

    name = "crosstalk"
    law = "T + c"
    separated_by = "swapped channels; the base shaken without a sample"
    source = "cables and grounds: -60 to -30 dB"
    parameters = (signed("share", 0.02),)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """The base leaks into the top channel."""
        return np.asarray(motion + values["share"])
