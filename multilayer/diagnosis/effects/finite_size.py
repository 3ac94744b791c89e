"""The sample's free rim: finite elements in place of plane waves."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive, signed
from multilayer.measurements.description import Campaign
from multilayer.rig.shape_factor import relative_shape_factor


class FiniteSize(Effect):
    """The stated Poisson's ratio acts with a free rim: a disc is softer than a laterally constrained layer.

    Finite elements have the stated ratio nu. Another ratio, nu (1 + error), and a sample that is stiffer along its
    radius by t = E_r/E_z, change the modulus by the factor of slow compression, g(nu (1 + error), t^(-1/4) S)/g(nu, S),
    and beyond that the motion, waves along the radius included, as finite elements of such samples have it
    (`finite_elements.SolidSteps`). Where there are none of those, as for a first fit, the factor alone acts: with 15 %
    of nu, or t = 1.3, it misses 2 to 8 % of the motion below the first waves along the radius, and most of it above.
    Shape factor g: A. N. Gent & P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111-122; here by finite elements
    (`rig.shape_factor`, where the exponent is derived).
    """

    name = "finite_size"
    place = "sample_shape"
    acts_through_place = False
    law = "free rim: E -> E g(nu, S) in slow compression, S = R/2h; finite elements"
    separated_by = "another thickness or radius"
    source = "campaign.yaml: Poisson's ratio, known to 15 %, and radius; foams: stiffer along the rise by 10 to 100 %"
    moves_resonances = True
    needs_finite_elements = True
    size_error = 0.01  # of E_r/E_z, as other finite elements have it: 0.3 %
    parameters = (signed("poisson_error", 0.15), positive("radial_stiffness", 1.0, 0.3, bounds=(0.4, 2.5)))
    starts = ((0.0, 0.0),)
    absent: ClassVar = {"radial_stiffness": 1.0}
    aside = ("poisson_error", "radial_stiffness")

    def applies(self, campaign: Campaign) -> bool:
        """Tell whether the rim matters: without lateral contraction it does not."""
        return abs(campaign.specimen.poisson_ratio) > 0.01

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the modulus with the change by another Poisson's ratio and another stiffness along the radius."""
        stated = setting.campaign.specimen.poisson_ratio
        return np.asarray(
            modulus * relative_shape_factor(stated, setting.shape, values["poisson_error"], values["radial_stiffness"])
        )

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with the sample that its finite elements are to have."""
        return chain.with_(solid=(values["poisson_error"], values["radial_stiffness"]))
