"""Plates that are heavier or lighter than stated, by moisture or tolerance."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of, with_each
from multilayer.stack import Stack

_LEAST = 0.05  # of the density


class BoardMass(LevelEffect):
    """The density of all plates, times a factor; their stiffness stays."""

    name = "board_mass"
    place = "boards_mass"
    law = "density (1 + e) of all plates"
    separated_by = "weighing"
    source = "boards vary by some per cent, more with moisture; a wrong product by more"
    parameters = (signed("relative", 0.1),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there is a plate."""
        return super().applies(setting) and bool(plates_of(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with another density of its plates."""
        return with_each(stack, plates_of(stack), "density", np.maximum(1 + values["relative"], _LEAST))
