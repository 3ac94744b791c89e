"""A loss factor of plates that is another one than stated."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of, with_each
from multilayer.stack import Stack


class PlateLosses(LevelEffect):
    """The loss factor of all plates, times the same factor at all frequencies."""

    name = "plate_losses"
    place = "boards_damping"
    law = "loss factor exp(x) of all plates"
    separated_by = "the decay of the plates' vibration; a panel far above its critical frequency"
    source = "loss factors of boards and glass are known within a factor of about two"
    parameters = (signed("log_factor", 0.7),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there is a plate with a loss factor."""
        return super().applies(setting) and bool(_lossy(setting.stack))

    def stack(self, setting: LevelSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with other losses of its plates."""
        return with_each(stack, _lossy(stack), "loss_factor", np.exp(values["log_factor"]))


def _lossy(stack: Stack) -> list[int]:
    return [i for i in plates_of(stack) if np.any(getattr(stack.layers[i], "loss_factor"))]  # noqa: B009
