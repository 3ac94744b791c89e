"""The sample's free rim: finite elements in place of plane waves."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, signed
from multilayer.measurements.description import Campaign
from multilayer.rig.shape_factor import interpolated_shape_factor

_REACH, _HIGHEST = 0.6, 0.49  # of Poisson's ratio: range relative to the stated one, and upper end of the table
_DEGREE = 6
_RESOLUTION = 0.5  # of the mesh of a static shape factor: exact to 2e-4 up to nu = 0.48 and S = 1.8


class FiniteSize(Effect):
    """The stated Poisson's ratio acts with a free rim: a disc is softer than a laterally constrained layer.

    Finite elements have the stated ratio nu. Another ratio, nu (1 + error), or a sample that is stiffer along its
    radius, changes the modulus by the factor of slow compression, g(nu (1 + error), S)/g(nu, S). Shape factor g: A. N.
    Gent & P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111-122; here by finite elements (`rig.shape_factor`).
    """

    name = "finite_size"
    place = "sample_shape"
    acts_through_place = False
    law = "free rim: E -> E g(nu, S) in slow compression, S = R/2h; finite elements"
    separated_by = "another thickness or radius"
    source = "campaign.yaml: Poisson's ratio, known to 15 %, and radius"
    moves_resonances = True
    needs_finite_elements = True
    parameters = (signed("poisson_error", 0.15),)
    starts = ((0.0,),)
    aside = ("poisson_error",)

    def applies(self, campaign: Campaign) -> bool:
        """Tell whether the rim matters: without lateral contraction it does not."""
        return abs(campaign.specimen.poisson_ratio) > 0.01

    def modulus(self, setting: Setting, modulus: ComplexArray, values: Values) -> ComplexArray:
        """Return the modulus with the change by another Poisson's ratio in slow compression."""
        stated = setting.campaign.specimen.poisson_ratio
        shape = setting.configuration.specimen_radius / (2 * setting.configuration.specimen_thickness)
        return np.asarray(modulus * _stiffer(stated, round(shape, 6), values["poisson_error"]))


def _stiffer(stated: float, shape: float, error: RealArray) -> RealArray:
    """Return g(nu (1 + error), S)/g(nu, S)."""
    if stated <= 0:  # g is known from 0 on, where it is 1
        return np.ones_like(error)
    lowest, highest = stated * (1 - _REACH), max(stated, min(stated * (1 + _REACH), _HIGHEST))
    factor = interpolated_shape_factor(shape, lowest, highest, degree=_DEGREE, resolution=_RESOLUTION)
    return np.asarray(factor(stated * (1 + error)) / factor(stated))
