"""A modulus that falls with dynamic strain.

A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57-63. Response at the tone's frequency: describing functions, A. Gelb &
W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, between, positive

_FIRST, _SECOND = 8 / (3 * np.pi), 3 / 4  # shares of |e| e and of |e|^2 e at the tone's frequency


class AmplitudeSoftening(Effect):
    """The modulus falls with the strain: at once, or as the structure of the sample follows the burst.

    At once: the stress is that of a linear sample of the strain e / (1 + b |e|), with harmonics. The strain's amplitude
    varies within a burst, so that the ratio of stress to strain differs by bin and burst as no linear modulus does. It
    follows from the two channels: with the spectra of the strain e, of ``|e| e`` and of ``|e|^2 e``, the ratio at each
    bin is E times a complex number, which takes the modulus' place in the linear model. That number is a series in b to
    second order, as a Padé approximant of order [1/1].

    With memory: filled rubbers show the softening almost without harmonics, because what the strain breaks up recovers
    in many periods; the modulus of a burst is then ``E / (1 + b e0)``, e0 the amplitude of a steady tone. The memory m
    interpolates between the two, as a weighted geometric mean of both factors.

    Limits: the strain is taken as uniform over the sample's height.
    """

    name = "amplitude_softening"
    place = "sample_strain"
    acts_through_place = False
    law = "E / (1 + b e0), or the stress of a linear sample of strain e / (1 + b |e|)"
    separated_by = "another level; harmonics"
    source = "filled rubbers (Payne) and foams: 1 to 30 % at strains of 1e-3"
    moves_resonances = True
    size_error = 0.3  # the power of the strain may differ from 1
    parameters = (positive("softening", 50.0, 1.5), between("memory", 0.0, 1.0))
    starts = tuple((size, memory) for memory in (-2.0, 2.0) for size in (-2.0, -1.0, 0.0, 1.0, 2.0))
    aside = ("memory",)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return stress over strain at every bin."""
        height = setting.configuration.specimen_thickness
        first, second = (m / height**k for k, m in enumerate(setting.stretch_moments, start=1))
        first, second = _FIRST * first, _SECOND * second
        b, memory = values["softening"], values["memory"]
        at_once = 1 - b * first / (1 + b * second / first)
        with_memory = 1 / (1 + b * setting.burst_strain)
        return np.asarray(modulus * np.exp((1 - memory) * np.log(at_once) + memory * np.log(with_memory)))
