"""Holes and open joints beside or in a construction.

M. C. Gomperts & T. Kihlman, Acustica 18 (1967) 144-150; see `media.openings.hole_passage`.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values
from multilayer.media.openings import hole_passage
from multilayer.stack import Stack


class Leak(LevelEffect):
    """Sound that passes through holes as deep as the construction."""

    name = "leak"
    place = "beside"
    law = "tau + s tau_hole(a), s of the area open in holes of radius a as deep as the construction"
    separated_by = "sealing all joints; a second area of the sample, with which a leak along its edge falls"
    source = "joints not sealed: 1e-5 to 1e-3 of the area; M. C. Gomperts & T. Kihlman, Acustica 18 (1967) 144-150"
    parameters = (positive("share", 1e-4, 1.5), positive("radius", 2e-3, 0.6, "m"))

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: Values) -> RealArray:
        """Return the share of the power with that of the holes."""
        depth = float(sum(np.mean(layer.depth) for layer in stack.layers))
        hole = hole_passage(setting.frequency, values["radius"], depth, setting.gas).transmission
        return np.asarray(share + values["share"] * hole)
