"""Plates that are stiffer or softer than stated: another critical frequency."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of
from multilayer.experiments.stacks.places import with_factors
from multilayer.stack import Stack


class BoardStiffness(LevelEffect):
    """Young's modulus of all plates, times a factor."""

    name = "board_stiffness"
    place = "boards_stiffness"
    law = "Young's modulus exp(x) of all plates: the critical frequency moves by exp(-x/2)"
    separated_by = "the modulus by a bending resonance of a strip; the dip of a single board"
    source = "moduli of gypsum and wood-based boards: 2 to 5 GPa by product and direction"
    parameters = (signed("log_factor", 0.3),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there is a plate."""
        return super().applies(setting) and bool(plates_of(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with another modulus of its plates."""
        for index in plates_of(stack):
            name = stack.layers[index].name or str(index)
            stack = with_factors(stack, name, young_modulus=np.exp(values["log_factor"]))
        return stack
