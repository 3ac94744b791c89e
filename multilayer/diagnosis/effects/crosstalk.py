"""Part of the base signal in the top channel."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class Crosstalk(Effect):
    """T + c + i d f/(1 kHz): crosstalk by shared grounds is constant, by capacitances proportional to frequency.

    H. W. Ott, Electromagnetic Compatibility Engineering, Wiley 2009, ch. 2.
    """

    name = "crosstalk"
    place = "added_reading"
    law = "T + c + i d f/(1 kHz): shared grounds, and capacitances"
    separated_by = "swapped channels; the base shaken without a sample"
    source = "cables and grounds: -60 to -30 dB, a fault -20 dB"
    size_error = 0.3  # the path is unknown
    # 21 right names of seeds 1012 to 1017: off by 2.9 % in the median, noise included; another solver: 0.2 %
    size_errors: ClassVar[Mapping[str, float]] = {"share": 0.05}
    is_shape_known = False
    parameters = (signed("share", 0.03), signed("capacitive", 0.01))

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion with a part of the base's added."""
        return np.asarray(motion + values["share"] + 1j * values["capacitive"] * setting.frequency / 1000.0)
