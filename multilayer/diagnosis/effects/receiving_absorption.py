"""A level that is off by the same amount in all bands: area, absorption or calibration of a room."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values


class ReceivingAbsorption(LevelEffect):
    """The term 10 lg(S/A) of the measurement is off."""

    name = "receiving_absorption"
    place = "reading"
    law = "R + d: 10 lg(S/A), or the calibration, is off"
    separated_by = "the same sample with the rooms exchanged; reverberation time again; calibrating both microphones"
    source = "areas of frames counted or not: 0.2 to 2 dB"
    parameters = (signed("level", 1.5, "dB"),)

    def reading(self, setting: LevelSetting, level: RealArray, values: Values) -> RealArray:
        """Return the level with the difference."""
        return np.asarray(level + values["level"])
