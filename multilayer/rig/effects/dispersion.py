"""A law that varies with frequency, by name."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.effect_base import Effect, Mistake, Moment, Surroundings, power_law


class Dispersion(Effect):
    """The modulus varies within the band of a burst more than the nominal law says: no change of the data.

    It names what a law such as ``fractional_zener`` does to a model of constant modulus. Perturbed: E (i f / 500 Hz)^p,
    p at most a tenth of what is written.
    """

    effect: Literal["dispersion"] = "dispersion"

    def mistakes(self, around: Surroundings) -> Iterator[Mistake]:
        f = np.array([frequency for mounting in around.mountings for frequency in mounting.frequencies])
        size = np.abs(around.specimen.modulus(np.array([f.min() / 2, f.max()])))
        if self.perturbation == 0 and size[1] < 1.01 * size[0]:
            text = "dispersion needs a young_modulus that varies with frequency, such as {law: fractional_zener, ...}"
            yield (), text, None

    def apply_to_modulus(self, frequency: RealArray, modulus: ComplexArray, moment: Moment) -> ComplexArray:
        return np.asarray(modulus * power_law(frequency, 0.1 * abs(self.perturbation)))
