"""A modulus that falls with dynamic strain."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive

_CREST = (16 / 3) ** 0.5  # of a Hann burst over its rms


class AmplitudeSoftening(Effect):
    """E/(1 + b e), e the amplitude of the strain."""

    name = "amplitude_softening"
    law = "E / (1 + b e), e the strain's amplitude in the burst"
    separated_by = "another level; harmonics"
    source = "filled rubbers (Payne) and foams: 1 to 30 % at strains of 1e-3"
    moves_resonances = True
    parameters = (positive("softening", 50.0, 1.2),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """The strain from the measured motion itself: |T - 1| u0/h at the burst's crest."""
        centre = setting.data.centres[setting.data.burst]
        crest = setting.campaign.burst.level_rms * _CREST
        moved = np.abs(setting.data.ratio - 1) * crest / (2 * np.pi * centre) ** 2
        strain = moved / setting.configuration.specimen_thickness
        return np.asarray(modulus / (1 + values["softening"] * strain))
