"""Sensitivities of the two microphones that differ."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting


class MicrophoneGain(TubeEffect):
    """Sensitivities differ more than the evaluation knows."""

    name = "microphone_gain"
    law = "H12 (1 + g), the transfer function between the microphones"
    separated_by = "exchanging the microphones"
    source = "0.1 dB of calibrated pairs; ISO 10534-2 corrects what is left by exchanging the microphones"
    parameters = (signed("gain", 0.01),)
    law_error = 0.01

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Back to what the microphones read, and forth again."""
        read = setting.transfer_function(reflection, setting.wavenumber)
        return setting.evaluated(np.asarray(read * (1 + values["gain"])))
