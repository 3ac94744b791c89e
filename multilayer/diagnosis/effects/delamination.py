"""Faces bonded in part."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive, signed

_OPEN, _AT, _POWER = 0.2, 0.033, 0.455  # open share of a face, at that constriction, and how one rises with the other
_WIDEST = 0.9  # open share
_RIM = 0.7  # what a rim hangs on over what it would, if all of its cross-section moved alike


class Delamination(Effect):
    """Bonded area smaller than the face, about the axis: a constriction, as if each face had a piece of sample more.

    Slow compression of finite elements with a bonded share of 0.9, 0.8, 0.65 and 0.5 of each face: c = 0.0076, 0.033,
    0.115 and 0.27, the same within a few per cent for heights from half the radius to twice that.

    The open rim hangs on the bonded core by shear. As two columns of shares b and 1 - b, pulled together by a spring in
    proportion to E, they move apart as exp(-p z) from the face on, ``p^2 = K^2 - q^2`` with ``q^2 = rho w^2/E``; so the
    compliance is ``c R/(E (1 - q^2/K^2)^(1/2))``, and ``K = (1 - b)/(b c R)`` from its static limit. Finite elements of
    rigs with a bonded share of 0.5 to 0.9 call for 0.7 of that.

    Limits: less exact the smaller the share, the thinner the sample and the larger Poisson's ratio. Of a sample of
    little loss (E2/E1 of 0.1 and less) that is thicker than its radius, with 30 % of each face open, its resonance
    comes out no better than with springs at the faces.
    """

    name = "delamination"
    law = "E (1 - (q/K)^2)^(1/2) / (c R) per area at each face, c larger or smaller from first to last configuration"
    separated_by = "another thickness; configurations remounted"
    source = "glue that misses 5 to 50 % of a face: 0.002 to 0.3, by finite elements"
    moves_resonances = True
    law_error = 0.3  # the constriction is as deep as the radius: no layer where the sample is as thin
    parameters = (positive("constriction", 0.03, 1.2), signed("trend", 0.4))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """A massless piece of sample at each face, its length in radii, softer the nearer its rim to resonance."""
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
