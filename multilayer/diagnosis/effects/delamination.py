"""Faces bonded in part, not alike in every configuration."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive
from multilayer.measurements.description import Campaign


class Delamination(Effect):
    """The bonded share of the faces falls (or rises) from the first to the last configuration."""

    name = "delamination"
    law = "E (1 - d), d differs between configurations"
    separated_by = "configurations remounted"
    source = "glue that misses 5 to 40 % of a face"
    moves_resonances = True
    law_error = 0.3  # the missing area acts on shear as well, and not in proportion
    parameters = (positive("first", 0.05, 1.0), positive("last", 0.05, 1.0))

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Less area carries; the missing share goes linearly from the first to the last configuration."""
        names = [configuration.name for configuration in setting.campaign.configurations]
        share = names.index(setting.configuration.name) / max(len(names) - 1, 1)
        missing = (1 - share) * values["first"] + share * values["last"]
        return np.asarray(modulus * np.exp(-missing))

    def applies(self, campaign: Campaign) -> bool:
        """With one configuration it is a softer sample, nothing else."""
        return len(campaign.configurations) > 1
