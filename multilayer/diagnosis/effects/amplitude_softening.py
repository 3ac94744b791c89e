"""A modulus that falls with dynamic strain.

A. R. Payne, J. Appl. Polym. Sci. 6 (1962) 57-63. Response at the tone's frequency: describing functions, A. Gelb &
W. E. Vander Velde, Multiple-Input Describing Functions and Nonlinear System Design, McGraw-Hill 1968.
"""

from __future__ import annotations

import numpy as np
from scipy.special import gammaln

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, between, positive

_POWERS = (0.4, 2.0)
_USUAL_STRAIN = 1e-3  # of a foam of 25 mm near its resonance on a shaker of 5 m/s2


class AmplitudeSoftening(Effect):
    """The modulus falls with the strain: at once, or as the structure of the sample follows the burst.

    At once: the stress is that of a linear sample of the strain ``e / (1 + n y)^(1/n)``, with harmonics, where ``y = b
    |e| (|e| / 1e-3)^(n-1)``. The power n is 1 where the modulus falls in proportion to the strain: ``e / (1 + b |e|)``.
    The strain's amplitude varies within a burst, so that the ratio of stress to strain differs by bin and burst as no
    linear modulus does. It follows from the two channels: with the spectra of the strain e, of ``|e|^n e`` and of
    ``|e|^(2n) e``, the ratio at each bin is E times a complex number, which takes the modulus' place in the linear
    model. That number is a series in b to second order, as a Padé approximant of order [1/1].

    With memory: filled rubbers show the softening almost without harmonics, because what the strain breaks up recovers
    in many periods; the modulus of a burst is then ``E / (1 + n y)^(1/n)`` at the amplitude of a steady tone. The
    memory m interpolates between the two, as a weighted geometric mean of both factors.

    Limits: the strain is taken as uniform over the sample's height. Beside a rod solved in time that costs 5e-4 of the
    modulus under a light plate of 3 kg/m2 with b |e| = 0.1, and less under heavier ones; the series 1e-4 there.
    """

    name = "amplitude_softening"
    place = "sample_strain"
    acts_through_place = False
    law = "E / (1 + n y)^(1/n), y = b e0 (e0 / 1e-3)^(n-1); or the same of every instant's strain, with harmonics"
    separated_by = "another level; harmonics"
    source = "filled rubbers (Payne) and foams: 1 to 30 % at strains of 1e-3"
    moves_resonances = True
    # powers of the strain: 1.2 of filled rubbers (G. Kraus, J. Appl. Polym. Sci. Appl. Polym. Symp. 39 (1984) 75-92)
    parameters = (
        positive("softening", 50.0, 1.5),
        between("memory", 0.0, 1.0),
        positive("power", 1.0, 0.3, "", _POWERS),
    )
    starts = tuple((size, memory, 0.0) for memory in (-2.0, 2.0) for size in (-2.0, -1.0, 0.0, 1.0, 2.0))
    aside = ("memory", "power")

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return stress over strain at every bin."""
        b, memory, n = values["softening"], values["memory"], values["power"]
        unit = b * _USUAL_STRAIN ** (1 - n)
        first = unit * _share(n) * setting.strain_moment(n)
        second = unit**2 * (1 + n) / 2 * _share(2 * n) * setting.strain_moment(2 * n)
        at_once = 1 - first / (1 + second / first)
        with_memory = (1 + n * unit * setting.burst_strain**n) ** (-1 / n)
        return np.asarray(modulus * np.exp((1 - memory) * np.log(at_once) + memory * np.log(with_memory)))


def _share(power: RealArray) -> RealArray:
    """Return the amplitude of the first harmonic of ``|sin|^k sin``."""
    return np.asarray(2 / np.sqrt(np.pi) * np.exp(gammaln((power + 3) / 2) - gammaln((power + 4) / 2)))
