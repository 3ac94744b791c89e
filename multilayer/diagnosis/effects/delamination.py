"""Faces bonded in part."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive, signed
from multilayer.measurements.description import Campaign


class Delamination(Effect):
    """Bonded area smaller than the face, about the axis: a constriction, as if the sample were longer.

    Slow compression of finite elements with a bonded share of 0.9, 0.8, 0.65 and 0.5 of each face: c = 0.0076, 0.033,
    0.115 and 0.27, the same within a few per cent for heights from half the radius to twice that.
    """

    name = "delamination"
    law = "E -> E / (1 + 2 c R/h), c larger or smaller from the first to the last configuration"
    separated_by = "another thickness; configurations remounted"
    source = "glue that misses 5 to 50 % of a face: 0.002 to 0.3, by finite elements"
    moves_resonances = True
    parameters = (positive("constriction", 0.03, 1.2), signed("trend", 0.4))

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Each constriction is a length of sample, in radii."""
        names = [configuration.name for configuration in setting.campaign.configurations]
        place = 2 * names.index(setting.configuration.name) / max(len(names) - 1, 1) - 1
        slender = setting.configuration.specimen_radius / setting.configuration.specimen_thickness
        length = values["constriction"] * np.exp(place * values["trend"])
        return np.asarray(modulus / (1 + 2 * length * slender))

    def applies(self, campaign: Campaign) -> bool:
        """With one configuration it is a softer sample, nothing else."""
        return len(campaign.configurations) > 1
