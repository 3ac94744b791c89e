"""The sample's free rim: finite elements in place of plane waves."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import ClassVar

import numpy as np
from numpy.polynomial import Chebyshev

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import Effect, Setting, Values, positive, signed
from multilayer.measurements.description import Campaign
from multilayer.media.elastic import p_wave_modulus
from multilayer.rig.shape_factor import interpolated_shape_factor, static_shape_factor

_REACH, _HIGHEST = 0.6, 0.49  # of Poisson's ratio: range relative to the stated one, and upper end of the table
_DEGREE, _SHAPE_DEGREE, _STIFFEST = 6, 3, 2.5
_RESOLUTION = 0.5  # of the mesh of a static shape factor: exact to 2e-4 up to nu = 0.48 and S = 1.8


class FiniteSize(Effect):
    """The stated Poisson's ratio acts with a free rim: a disc is softer than a laterally constrained layer.

    Finite elements have the stated ratio nu. Another ratio, nu (1 + error), and a sample that is stiffer along its
    radius by t = E_r/E_z, change the modulus by the factor of slow compression,
    g(nu (1 + error), t^(-1/4) S)/g(nu, S). Shape factor g: A. N. Gent & P. B. Lindley, Proc. Inst. Mech. Eng. 173
    (1959) 111-122; here by finite elements (`rig.shape_factor`, where the exponent is derived).
    """

    name = "finite_size"
    place = "sample_shape"
    acts_through_place = False
    law = "free rim: E -> E g(nu, S) in slow compression, S = R/2h; finite elements"
    separated_by = "another thickness or radius"
    source = "campaign.yaml: Poisson's ratio, known to 15 %, and radius; foams: stiffer along the rise by 10 to 100 %"
    moves_resonances = True
    needs_finite_elements = True
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
        shape = setting.configuration.specimen_radius / (2 * setting.configuration.specimen_thickness)
        return np.asarray(
            modulus * _stiffer(stated, round(shape, 6), values["poisson_error"], values["radial_stiffness"])
        )


def _stiffer(stated: float, shape: float, error: RealArray, radial_stiffness: RealArray) -> RealArray:
    """Return g(nu (1 + error), t^(-1/4) S)/g(nu, S).

    g lies between 1, a free rod, and M/E, a disc without a rim. How far on that way it moves by t is that of the stated
    ratio: right to 0.1 % for nu up to 0.3, or S up to 0.5, where t is a half or two and the error 15 %; to 1 % of flat
    discs with nu = 0.4.
    """
    if stated <= 0:  # g is known from 0 on, where it is 1
        return np.ones_like(error)
    lowest, highest = stated * (1 - _REACH), max(stated, min(stated * (1 + _REACH), _HIGHEST))
    factor = interpolated_shape_factor(shape, lowest, highest, degree=_DEGREE, resolution=_RESOLUTION)
    ratio = np.clip(stated * (1 + error), lowest, highest)
    held = _held(ratio)
    odds = _odds(factor(ratio), held) * np.exp(_by_shape(stated, shape)(radial_stiffness))
    return np.asarray((1 + odds * held) / (1 + odds) / factor(stated))


def _held(poisson_ratio: RealArray) -> RealArray:
    """Return M/E, the factor of a disc without a rim."""
    return np.real(p_wave_modulus(1.0, poisson_ratio))


def _odds(factor: RealArray, held: RealArray) -> RealArray:
    """Return the way from a free rod, over that to a disc without a rim."""
    return (factor - 1) / (held - factor)


@lru_cache(maxsize=64)
def _by_shape(poisson_ratio: float, shape: float) -> Callable[[RealArray], RealArray]:
    """Return the change of ln of the odds by t, constant beyond `_STIFFEST`."""
    held = _held(np.asarray(poisson_ratio))

    def logarithms(x: RealArray) -> RealArray:
        factors = [
            static_shape_factor(poisson_ratio, shape, resolution=_RESOLUTION, radial_stiffness=t) for t in np.exp(x)
        ]
        return np.log(_odds(np.array(factors), held))

    ends = np.log(_STIFFEST)
    polynomial = Chebyshev.interpolate(logarithms, _SHAPE_DEGREE, domain=[-ends, ends])
    return lambda t: np.asarray(polynomial(np.clip(np.log(t), -ends, ends)) - polynomial(0.0))
