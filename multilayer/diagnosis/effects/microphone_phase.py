"""Phases of the two microphones that differ."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting


class MicrophonePhase(TubeEffect):
    """One channel lags behind the other by an angle that does not depend on frequency."""

    name = "microphone_phase"
    place = "reading"
    law = "H12 exp(i p), the transfer function between the microphones"
    separated_by = "exchanging the microphones"
    source = "0.5 degrees of matched pairs; ISO 10534-2 corrects what is left by exchanging the microphones"
    parameters = (signed("phase", 0.01, "radian"),)
    law_error = 0.01

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection evaluated from the transfer function with its error; ISO 10534-2."""
        read = setting.transfer_function(reflection, setting.wavenumber)
        return setting.evaluated(np.asarray(read * np.exp(1j * values["phase"])))
