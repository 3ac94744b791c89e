"""Faces bonded in part."""

from __future__ import annotations

import numpy as np

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive, signed


class Delamination(Effect):
    """Bonded area smaller than the face, about the axis: a constriction, as if each face had a piece of sample more.

    Slow compression of finite elements with a bonded share of 0.9, 0.8, 0.65 and 0.5 of each face: c = 0.0076, 0.033,
    0.115 and 0.27, the same within a few per cent for heights from half the radius to twice that.
    """

    name = "delamination"
    law = "a spring per area E / (c R) at each face, c larger or smaller from the first to the last configuration"
    separated_by = "another thickness; configurations remounted"
    source = "glue that misses 5 to 50 % of a face: 0.002 to 0.3, by finite elements"
    moves_resonances = True
    law_error = 0.3  # the constriction is as deep as the radius: no spring where the sample is as thin
    parameters = (positive("constriction", 0.03, 1.2), signed("trend", 0.4))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """A massless piece of sample at each face, its length in radii."""
        names = [configuration.name for configuration in setting.campaign.configurations]
        place = 2 * names.index(setting.configuration.name) / (len(names) - 1) - 1 if len(names) > 1 else 0.0
        length = values["constriction"] * np.exp(place * values["trend"]) * setting.configuration.specimen_radius
        return chain.glued(chain.modulus / length)
