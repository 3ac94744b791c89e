"""Places in the channels."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from multilayer.diagnosis.places.base import ComplexArray, Place, Setting


class Reading(Place):
    """The chains of sensors: the logarithm of every reading, amount and phase, changes alike."""

    name = "reading"
    title = "in the reading"
    quantity = "change of ln(top/base)"
    terms: ClassVar = {
        0: ("gain", ""), 1: ("lead", "s"), -1: ("high pass", "rad/s"), "resonance": ("resonance of a sensor", ""),
    }  # fmt: skip

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion times ``exp(law)``."""
        return np.asarray(motion * np.exp(values))


class AddedReading(Place):
    """A share of the base's motion that the top channel shows besides."""

    name = "added_reading"
    title = "added to the reading"
    quantity = "share of the base's motion"
    terms: ClassVar = {
        0: ("constant share", ""), 1: ("share that rises with frequency", "s"), "resonance": ("resonance", ""),
    }  # fmt: skip

    def motion(self, setting: Setting, motion: ComplexArray, values: ComplexArray) -> ComplexArray:
        """Return the motion with a share of the base's."""
        return np.asarray(motion + values)
