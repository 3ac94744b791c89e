"""Faces that are bonded in part.

Both relations are fitted to finite elements of this project; the attachment by shear is a shear-lag model: H. L. Cox,
Br. J. Appl. Phys. 3 (1952) 72-79.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive, signed

_OPEN, _AT, _POWER = 0.2, 0.033, 0.455  # open share of a face at a constriction, and the power of its rise with it
_WIDEST = 0.9  # largest open share
_RIM = 0.7  # attachment of the open rim, relative to that of a rim whose cross-section moves uniformly


class Delamination(Effect):
    """Bonded areas smaller than the faces, about the axis: a constriction, as if the sample were longer at each face.

    The additional length at each face is c R. Finite elements in slow compression with a bonded share of 0.9, 0.8, 0.65
    and 0.5 of each face give c = 0.0076, 0.033, 0.115 and 0.27, within a few per cent for heights from half the radius
    to the diameter.

    The open rim is attached to the bonded core by shear. As two columns of shares b and 1 - b, coupled by a spring in
    proportion to E, their difference falls as exp(-p z) from the face, ``p^2 = K^2 - q^2`` with ``q^2 = rho w^2/E``; so
    the compliance is ``c R/(E (1 - q^2/K^2)^(1/2))``, and ``K = (1 - b)/(b c R)`` from its static limit. Finite
    elements of rigs with a bonded share of 0.5 to 0.9 give 0.7 of that.

    Limits: less exact the smaller the share, the thinner the sample and the larger Poisson's ratio. Of a sample of
    little loss (E2/E1 of 0.1 and less) that is thicker than its radius, with 30 % of each face open, the resonance is
    no more exact than with springs at the faces.
    """

    name = "delamination"
    place = "faces"
    acts_through_place = False
    law = "E (1 - (q/K)^2)^(1/2) / (c R) per area at each face, c larger or smaller from first to last configuration"
    separated_by = "another thickness; configurations remounted"
    source = "glue that misses 5 to 50 % of a face: 0.002 to 0.3, by finite elements"
    moves_resonances = True
    law_error = 0.3  # the constriction reaches as deep as the radius, which in a thin sample is no layer
    parameters = (positive("constriction", 0.03, 1.2), signed("trend", 0.4))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with a massless layer at each face, which softens towards the resonance of its rim."""
        names = [configuration.name for configuration in setting.campaign.configurations]
        place = 2 * names.index(setting.configuration.name) / (len(names) - 1) - 1 if len(names) > 1 else 0.0
        constriction = values["constriction"] * np.exp(place * values["trend"])
        length = constriction * setting.configuration.specimen_radius
        rim = _RIM * _open_over_bonded(constriction) / length
        waves = setting.omega**2 * chain.density / chain.modulus
        return chain.glued(chain.modulus / length * np.sqrt(1 - waves / rim**2 + 0j))


def _open_over_bonded(constriction: RealArray) -> RealArray:
    """Return (1 - b)/b of a face with a constriction."""
    share = np.minimum(_OPEN * (constriction / _AT) ** _POWER, _WIDEST)
    return np.asarray(share / (1 - share))
