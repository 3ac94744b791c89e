"""A relaxation that the nominal law cannot represent.

C. Zener, Elasticity and Anelasticity of Metals, Univ. of Chicago Press 1948.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive


class Dispersion(Effect):
    """A further relaxation, in proportion to the nominal law."""

    name = "dispersion"
    place = "sample"
    law = "E (1 + d i w t/(1 + i w t))"
    separated_by = "another thickness"
    source = "secondary relaxations of polymers: some 10 % of the modulus"
    moves_resonances = True
    parameters = (positive("strength", 0.1, 1.0), positive("relaxation_time", 3e-4, 1.5, "s"))

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the modulus with a Zener element."""
        s = 1j * setting.omega * values["relaxation_time"]
        return np.asarray(modulus * (1 + values["strength"] * s / (1 + s)))
