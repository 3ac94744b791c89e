"""A modulus that changes in the course of the campaign."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed


class TemperatureDrift(Effect):
    """E exp(d u), u from 0 at the first to 1 at the last burst."""

    name = "temperature_drift"
    place = "sample_order"
    law = "E exp(d u), u the share of the campaign that is over"
    separated_by = "repeats, reversed order"
    source = "polyurethane near room temperature: 1 to 5 % per kelvin, some kelvins in a day"
    moves_resonances = True
    parameters = (signed("total", 0.1),)

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the modulus at the time of each burst, in the order of campaign.yaml."""
        return np.asarray(modulus * np.exp(values["total"] * setting.order))
