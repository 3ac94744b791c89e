"""Sensitivities of the two microphones that differ."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting


class MicrophoneGain(TubeEffect):
    """A ratio of sensitivities that the evaluation does not take into account."""

    name = "microphone_gain"
    place = "reading"
    law = "H12 (1 + g), the transfer function between the microphones"
    separated_by = "exchanging the microphones"
    source = "0.1 dB of calibrated pairs; ISO 10534-2 corrects what is left by exchanging the microphones"
    parameters = (signed("gain", 0.01),)
    law_error = 0.01

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection evaluated from the transfer function with its error; ISO 10534-2."""
        read = setting.transfer_function(reflection, setting.wavenumber)
        return setting.evaluated(np.asarray(read * (1 + values["gain"])))
