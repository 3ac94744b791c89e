"""A modulus that falls with dynamic strain."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive

_FIRST, _SECOND = 8 / (3 * np.pi), 3 / 4  # shares of |e| e and of |e|^2 e that are at the tone's own frequency


class AmplitudeSoftening(Effect):
    """The stress is that of a linear sample of the strain e / (1 + b |e|).

    The strain's amplitude rises and falls within a burst, so stress over strain differs from bin to bin and from burst
    to burst as no modulus does. Both are known from the two channels: with the strain's own spectrum and those of
    ``|e| e`` and ``|e|^2 e``, stress over strain at each bin is E times a complex number, and a linear model of that
    modulus answers for the burst. That number is a series in b to the second order, made rational.

    Limits: the strain is taken as the same all over the sample's height.
    """

    name = "amplitude_softening"
    law = "stress of a linear sample of strain e / (1 + b |e|): E falls by 0.85 b times the strain's amplitude"
    separated_by = "another level; harmonics"
    source = "filled rubbers (Payne) and foams: 1 to 30 % at strains of 1e-3"
    moves_resonances = True
    size_error = 0.3  # the power of the strain may differ from 1
    parameters = (positive("softening", 50.0, 1.2),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Stress over strain at every bin, from the burst's own envelope where the channels tell it."""
        height = setting.configuration.specimen_thickness
        first, second = (m / height**k for k, m in enumerate(setting.stretch_moments, start=1))
        first, second = _FIRST * first, _SECOND * second
        b = values["softening"]
        return np.asarray(modulus * (1 - b * first / (1 + b * second / first)))
