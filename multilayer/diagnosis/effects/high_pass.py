"""High-pass filters of unlike cut-off."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class HighPass(Effect):
    """A first-order high-pass filter, 1/(1 - i fc/f), by which the two channels differ."""

    name = "high_pass"
    place = "reading"
    law = "T / (1 - i fc/f)"
    separated_by = "phase at low frequencies; swapped channels"
    source = "AC coupling of 0.1 to 10 Hz with components of 10 to 20 %; a fault reaches 50 Hz"
    parameters = (signed("cut_off", 15.0, "Hz"),)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion with the top channel high-passed; the base channel for a negative cut-off."""
        cut = values["cut_off"]
        factor = 1 / (1 - 1j * np.abs(cut) / setting.frequency)
        return np.asarray(motion * np.where(cut >= 0, factor, 1 / factor))
