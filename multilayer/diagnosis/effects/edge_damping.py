"""Losses of plates at their edges, which carry sound away into what holds them.

ISO 12354-1:2017, annex C: total loss factor = internal one + m'/(485 sqrt(f)) of heavy walls in laboratories.
"""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of, with_losses
from multilayer.stack import Stack

_REFERENCE = 500.0  # Hz


class EdgeDamping(LevelEffect):
    """A loss factor of all plates that falls as one over the root of frequency, beside their own."""

    name = "edge_damping"
    place = "boards_damping"
    varies = True
    law = "loss factor + e sqrt(500 Hz/f) of all plates"
    separated_by = "the decay of the plates' vibration as mounted; another way to hold their edges"
    source = "ISO 12354-1:2017 annex C: 0.005 to 0.05 at 500 Hz by mass and edges"
    parameters = (positive("loss", 0.02, 1.0),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there is a plate."""
        return super().applies(setting) and bool(plates_of(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with more losses of its plates."""
        return with_losses(stack, plates_of(stack), values["loss"] * np.sqrt(_REFERENCE / setting.frequency))
