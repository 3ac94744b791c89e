"""A delay of the top channel."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import REFERENCE_FREQUENCY, Effect, Mounting, Size
from multilayer.units import Unit


class ChannelDelay(Effect):
    """The top channel is late: T exp(-i w tau).

    Perturbed: tau (1 + p (f / 500 Hz - 1)), a delay that depends on frequency.
    """

    effect: Literal["channel_delay"] = "channel_delay"
    delay: Annotated[float, Field(ge=-1e-3, le=1e-3), Unit("s")] = 10e-6

    drawn = Size("delay", 1e-6, 6e-5, signed=True, parameter="delay")

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        slope = 1 + self.perturbation * (frequency / REFERENCE_FREQUENCY - 1)
        return np.asarray(ratio * np.exp(-2j * np.pi * frequency * self.delay * slope))
