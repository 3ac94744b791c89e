"""A delay between the two measurement channels."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class ChannelDelay(Effect):
    """T exp(-i w tau), beyond the delay that the laboratory states."""

    name = "channel_delay"
    place = "reading"
    law = "T exp(-i w tau)"
    separated_by = "swapped channels"
    source = "multiplexed converters: up to one sampling interval; filters of unlike cut-off: some 10 us"
    parameters = (signed("delay", 3e-5, "s"),)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion with the top channel delayed."""
        return np.asarray(motion * np.exp(-1j * setting.omega * values["delay"]))
