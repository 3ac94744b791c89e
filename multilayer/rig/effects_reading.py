"""Effects of the two measuring chains and of where the accelerometers sit: the sample knows nothing of them."""
# ruff: noqa: D102 -- the hooks are documented once, on the base class

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import REFERENCE_FREQUENCY, Effect, Mounting, above_zero, power_law
from multilayer.units import DIMENSIONLESS, Unit


class ChannelGain(Effect):
    """The top channel shows too much: T (1 + g).

    Perturbed: g (1 + p ln(f / 500 Hz)), a gain with a slope.
    """

    effect: Literal["channel_gain"] = "channel_gain"
    gain: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.02

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        slope = 1 + self.perturbation * np.log(above_zero(frequency) / REFERENCE_FREQUENCY)
        return np.asarray(ratio * (1 + self.gain * slope))


class ChannelDelay(Effect):
    """The top channel is late: T exp(-i w tau).

    Perturbed: tau (1 + p (f / 500 Hz - 1)), a delay that depends on frequency.
    """

    effect: Literal["channel_delay"] = "channel_delay"
    delay: Annotated[float, Field(ge=-1e-3, le=1e-3), Unit("s")] = 10e-6

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        slope = 1 + self.perturbation * (frequency / REFERENCE_FREQUENCY - 1)
        return np.asarray(ratio * np.exp(-2j * np.pi * frequency * self.delay * slope))


class HighPass(Effect):
    """The top chain has a high-pass filter that the base chain lacks: T / (1 - i fc/f).

    Perturbed: the filter to the power 1 + p.
    """

    effect: Literal["high_pass"] = "high_pass"
    cut_off: Annotated[float, Field(ge=0, le=1000), Unit("Hz")] = 5.0

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        f = np.asarray(frequency, dtype=complex)
        at_rest = np.full(f.shape, self.cut_off == 0, dtype=complex)  # at 0 Hz, where f / (f - i fc) may be 0 / 0
        passed = np.divide(f, f - 1j * self.cut_off, out=at_rest, where=frequency > 0)
        return np.asarray(ratio * passed ** (1 + self.perturbation))


class Crosstalk(Effect):
    """Part of the base signal shows in the top channel: T + c exp(-i w tau).

    Perturbed: c (i f / 500 Hz)^p, through a capacitance for p = 1.
    """

    effect: Literal["crosstalk"] = "crosstalk"
    share: Annotated[float, Field(ge=-0.5, le=0.5), Unit(DIMENSIONLESS)] = 0.01
    delay: Annotated[float, Field(ge=0, le=1e-3), Unit("s")] = 0.0

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        late = np.exp(-2j * np.pi * frequency * self.delay)
        return np.asarray(ratio + self.share * power_law(frequency, self.perturbation) * late)


class SensorMount(Effect):
    """The top accelerometer resonates on its mount: T / (1 - (f/fm)^2 + i eta f/fm).

    Perturbed: the exponent 2 becomes 2 (1 + p), an accelerometer on more than one spring.
    """

    effect: Literal["sensor_mount"] = "sensor_mount"
    frequency: Annotated[float, Field(ge=500, le=100e3), Unit("Hz")] = 6000.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        x = frequency / self.frequency
        return np.asarray(ratio / (1 - x ** (2 * (1 + self.perturbation)) + 1j * self.loss_factor * x))


class Rocking(Effect):
    """A share of a rocking mode that the base drives is in the reading: T + s f^2 / (fr^2 - f^2 + i eta fr f).

    Perturbed: s (f / fr)^p, a mode that the base drives the more the faster it moves.
    """

    effect: Literal["rocking"] = "rocking"
    share: Annotated[float, Field(ge=-1, le=1), Unit(DIMENSIONLESS)] = 0.02
    frequency: Annotated[float, Field(ge=10, le=20e3), Unit("Hz")] = 700.0
    loss_factor: Annotated[float, Field(gt=0, le=2), Unit(DIMENSIONLESS)] = 0.1

    def apply_to_response(self, frequency: RealArray, ratio: ComplexArray, mounting: Mounting) -> ComplexArray:
        share = self.share * (above_zero(frequency) / self.frequency) ** self.perturbation
        return np.asarray(ratio + share * resonance(frequency, self.frequency, self.loss_factor))


def resonance(frequency: RealArray, own: float, loss_factor: float) -> ComplexArray:
    """Return f^2 / (f0^2 - f^2 + i eta f0 f): motion of an oscillator relative to the base that carries it."""
    return np.asarray(frequency**2 / (own**2 - frequency**2 + 1j * loss_factor * own * frequency))
