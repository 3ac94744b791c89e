"""A gain of the top channel that is not known."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import REFERENCE_FREQUENCY, Effect, Mounting, Size, above_zero
from multilayer.units import DIMENSIONLESS, Unit


class ChannelGain(Effect):
    """The top channel shows too much: T (1 + g).

    Perturbed: g (1 + p ln(f / 500 Hz)), a gain with a slope.
    """

    effect: Literal["channel_gain"] = "channel_gain"
    gain: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.02

    drawn = Size("gain", 2e-3, 0.1, signed=True, parameter="gain")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        slope = 1 + self.perturbation * np.log(above_zero(frequency) / REFERENCE_FREQUENCY)
        return np.asarray(ratio * (1 + self.gain * slope))
