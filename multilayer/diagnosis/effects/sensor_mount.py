"""Resonance of the accelerometer's mount."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, between, positive


class SensorMount(Effect):
    """The mount as an oscillator of one degree of freedom: T / (1 - (f/fm)^2 + i eta f/fm)."""

    name = "sensor_mount"
    place = "reading"
    law = "T / (1 - (f/fm)^2 + i eta f/fm)"
    separated_by = "swapped channels, remounting"
    source = "wax, tape and magnets: 2 to 10 kHz; stud: above 20 kHz"
    parameters = (positive("frequency", 5e3, 0.5, "Hz"), between("loss_factor", 0.0, 0.5))
    absent: ClassVar[Mapping[str, float]] = {"frequency": 1e6}

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion of the sensor on its mount."""
        ratio = setting.frequency / values["frequency"]
        return np.asarray(motion / (1 - ratio**2 + 1j * values["loss_factor"] * ratio))
