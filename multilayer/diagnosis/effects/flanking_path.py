"""Sound that goes round a construction, through what it stands in."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import Values
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting
from multilayer.inference.priors import Parameter, Prior
from multilayer.stack import Stack

_REFERENCE = 500.0  # Hz


class FlankingPath(LevelEffect):
    """A parallel path whose loss is a straight line over the logarithm of frequency."""

    name = "flanking_path"
    place = "beside"
    law = "tau + 10^(-(R + d log2(f/500 Hz))/10)"
    separated_by = "intensity close to the sample; a sample of far higher loss in the same opening"
    source = "ISO 10140-5 asks laboratories for the largest loss that they can measure; 45 to 75 dB by it, rising"
    parameters = (
        Parameter(name="loss", prior=Prior(normal=(58.0, 9.0)), unit="dB"),
        Parameter(name="slope", prior=Prior(normal=(3.0, 2.0)), unit="dB"),
    )
    absent: ClassVar[Mapping[str, float]] = {"loss": 200.0}

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: Values) -> RealArray:
        """Return the share of the power with that of the path."""
        loss = values["loss"] + values["slope"] * np.log2(setting.frequency / _REFERENCE)
        return np.asarray(share + 10 ** (-loss / 10))
