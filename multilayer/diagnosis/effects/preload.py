"""Stiffening by the static weight of the top plate.

J. Cortazar-Noguerol, F. Cortés, I. Sarría & M. J. Elejabarrieta, Polymers 16 (2024) 1844.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive


class Preload(Effect):
    """E (1 + b sigma_static), the loss factor unchanged."""

    name = "preload"
    place = "sample_load"
    law = "E (1 + b s), s the static stress"
    separated_by = "a second top plate only"
    source = "2 to 12 N on a polyurethane foam: E1 +58 %, loss factor unchanged (Cortazar-Noguerol 2024)"
    moves_resonances = True
    size_error = 0.25  # the power of the stress may differ from 1; 15 right names of seeds 1012 to 1017: 0.26
    parameters = (positive("stiffening", 5e-4, 1.2, "1/Pa"),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the modulus under the plate's weight; the law is that without a plate."""
        return np.asarray(modulus * (1 + values["stiffening"] * setting.static_stress))
