"""Bending of plates that corrugations or ribs make orthotropic: their stiffnesses, smeared over a period.

Axis x runs along corrugations or ribs, the stiff way. Formulae are linear in Young's modulus, which may be complex.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import Numeric, RealArray
from multilayer.media.elastic import flexural_rigidity

_STEPS = 128  # along a period: the trapezoidal rule converges exponentially for smooth profiles


@dataclass(frozen=True)
class Rigidities:
    """Bending stiffnesses of a thin orthotropic plate, N m.

    Attributes
    ----------
    x, y : complex or array
        Along the two axes.
    mixed : complex or array
        H = D_xy + 2 D_66: of the mixed derivative, half of the factor of cos^2 sin^2.
    """

    x: Numeric
    y: Numeric
    mixed: Numeric

    def at(self, angle: Numeric) -> Numeric:
        """Return the stiffness that a wave meets whose way makes an angle, rad, with axis x.

        ``D = Dx cos^4 + 2 H cos^2 sin^2 + Dy sin^4``: S. P. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and
        Shells, 2nd ed. (1959), section 85; M. Heckl, Acustica 10 (1960) 109-115.
        """
        along, across = np.cos(angle) ** 2, np.sin(angle) ** 2
        stiffness: Numeric = self.x * along**2 + 2 * self.mixed * along * across + self.y * across**2
        return stiffness


@dataclass(frozen=True)
class Profile:
    """The middle line of a corrugated sheet.

    Attributes
    ----------
    length : float or array
        Of the sheet over that of its projection.
    square : float or array
        Integral of the squared distance from the centre of gravity along the sheet, over the projection, m2.
    flatness : float or array
        Integral of the squared cosine of the slope along the sheet, over the projection.
    """

    length: Numeric
    square: Numeric
    flatness: Numeric


def sinusoidal(period: Numeric, height: Numeric) -> Profile:
    """Return the profile of a sine, `height` m from lowest to highest."""
    phase = 2 * np.pi * np.arange(_STEPS) / _STEPS
    steepness = np.asarray(np.pi * height / period)[..., None]
    stretch = np.sqrt(1 + (steepness * np.cos(phase)) ** 2)
    square = np.mean(np.sin(phase) ** 2 * stretch, axis=-1) * height**2 / 4
    return Profile(np.mean(stretch, axis=-1), square, np.mean(1 / stretch, axis=-1))


def trapezoidal(period: Numeric, height: Numeric, crest: Numeric, trough: Numeric) -> Profile:
    """Return the profile of flats, crest and trough m wide, and straight flanks between; `crest + trough <= period`."""
    run = (period - crest - trough) / 2
    flank = np.hypot(run, height)
    length = crest + trough + 2 * flank
    centre = (crest - trough) * height / 2 / length
    square = (crest + trough) * height**2 / 4 + flank * height**2 / 6 - centre**2 * length
    return Profile(length / period, square / period, (crest + trough + 2 * run**2 / flank) / period)


def corrugated(young_modulus: Numeric, poisson_ratio: Numeric, thickness: Numeric, profile: Profile) -> Rigidities:
    """Return the stiffnesses of a corrugated sheet, N m.

    Y. Xia, M. I. Friswell & E. I. Saavedra Flores, Int. J. Solids Struct. 49 (2012) 1453-1462, for any profile: across
    the corrugations the sheet's stiffness over its length, along them E times the profile's second moment of area, of a
    shallow sine h height^2 / 8 (D. Briassoulis, Comput. Struct. 23 (1986) 129-138). Across, and mixed, S. P. Timoshenko
    & S. Woinowsky-Krieger 1959, section 86, have the same but for terms in Poisson's ratio; of trapezoids D. A. Bies &
    C. H. Hansen, Engineering Noise Control, 4th ed. (2009), section 8.2, take the same second moment.

    Parameters
    ----------
    young_modulus : complex or array
        Pa.
    poisson_ratio : float or array
    thickness : float or array
        Of the sheet, m.
    profile : Profile
    """
    plane = flexural_rigidity(young_modulus, poisson_ratio, thickness)
    across = plane / profile.length
    moment = thickness * profile.square + thickness**3 / 12 * profile.flatness
    along = young_modulus * moment + poisson_ratio**2 * across
    return Rigidities(along, across, poisson_ratio * across + (1 - poisson_ratio) * plane * profile.length)


def ribbed(
    young_modulus: Numeric, poisson_ratio: Numeric, thickness: Numeric, rib_height: Numeric, rib_width: Numeric,
    rib_spacing: Numeric,
) -> Rigidities:  # fmt: skip
    """Return the stiffnesses of a plate with rectangular ribs of its material on one face, N m.

    S. P. Timoshenko & S. Woinowsky-Krieger 1959, section 86: along the ribs that of T-beams about their neutral axis,
    the plate's own part with E / (1 - nu^2); across them ``D / (1 - w/s + (w/s) (h / (h + H))^3)``; mixed that of the
    plate and half of the ribs' torsional stiffness G J over the spacing. J: W. C. Young & R. G. Budynas, Roark's
    Formulas for Stress and Strain, 7th ed. (2002), table 10.1.

    Parameters
    ----------
    young_modulus : complex or array
        Pa.
    poisson_ratio : float or array
    thickness : float or array
        h, of the plate without ribs, m.
    rib_height, rib_width, rib_spacing : float or array
        H, beyond the plate's face; w; s, between their middles, m.
    """
    plate, area = thickness * rib_spacing / (1 - poisson_ratio**2), rib_width * rib_height
    arm = (thickness + rib_height) / 2
    axis = area * arm / (plate + area)  # from the middle of the plate
    moment = plate * (thickness**2 / 12 + axis**2) + area * (rib_height**2 / 12 + (arm - axis) ** 2)
    alone = flexural_rigidity(young_modulus, poisson_ratio, thickness)
    share = rib_width / rib_spacing
    across = alone / (1 - share + share * (thickness / (thickness + rib_height)) ** 3)
    shear_modulus = young_modulus / (2 * (1 + poisson_ratio))
    twist = shear_modulus * _torsion(rib_height, rib_width) / (2 * rib_spacing)
    return Rigidities(young_modulus * moment / rib_spacing, across, alone + twist)


def _torsion(one: Numeric, other: Numeric) -> Numeric:
    """Return the torsional constant of a rectangle, m4."""
    long, short = np.maximum(one, other), np.minimum(one, other)
    ratio = short / long
    constant: Numeric = long * short**3 * (1 / 3 - 0.21 * ratio * (1 - ratio**4 / 12))
    return constant


def flat_resonance(
    young_modulus: Numeric, poisson_ratio: Numeric, thickness: Numeric, density: Numeric, width: Numeric
) -> Numeric:
    """Return the first resonance, Hz, of a strip of plate whose long edges are hinged: pi / (2 w^2) sqrt(D / m)."""
    modulus: RealArray = np.real(np.asarray(young_modulus))
    stiffness = modulus * thickness**2 / (12 * (1 - poisson_ratio**2) * density)
    resonance: Numeric = np.pi / (2 * width**2) * np.sqrt(stiffness)
    return resonance
