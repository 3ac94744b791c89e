"""A gain error between the two measurement channels."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class ChannelGain(Effect):
    """T (1 + g), beyond the uncertainty of gains that the laboratory states."""

    name = "channel_gain"
    place = "reading"
    law = "T (1 + g)"
    separated_by = "swapped channels; T tends to 1 at low frequencies"
    source = "accelerometers of 10 % tolerance without calibration, 2 to 5 % with a handheld one"
    parameters = (signed("gain", 0.05),)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion with the top channel off by a factor."""
        return np.asarray(motion * (1 + values["gain"]))
