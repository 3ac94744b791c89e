"""A high-pass filter in the top chain."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mounting, Size
from multilayer.units import Unit


class HighPass(Effect):
    """The top chain has a high-pass filter that the base chain lacks: T / (1 - i fc/f).

    Perturbed: the filter to the power 1 + p.
    """

    effect: Literal["high_pass"] = "high_pass"
    cut_off: Annotated[float, Field(ge=0, le=1000), Unit("Hz")] = 5.0

    drawn = Size("cut_off", 0.3, 30.0, parameter="cut_off")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        f = np.asarray(frequency, dtype=complex)
        at_rest = np.full(f.shape, self.cut_off == 0, dtype=complex)  # at 0 Hz, where f / (f - i fc) may be 0 / 0
        passed = np.divide(f, f - 1j * self.cut_off, out=at_rest, where=frequency > 0)
        return np.asarray(ratio * passed ** (1 + self.perturbation))
