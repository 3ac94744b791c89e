"""Bending of the top plate.

A. W. Leissa, Vibration of Plates, NASA SP-160 (1969), ch. 2: free circular plates.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import CENTRED_SENSOR, Effect, Setting, Values, signed
from multilayer.media.elastic import FIRST_BENDING


class PlateFlexure(Effect):
    """The reading contains the plate's first bending mode, f1 = 9.08/(2 pi R^2) sqrt(D/(rho h)) of a free disc."""

    name = "plate_flexure"
    place = "plate"
    law = "T (1 + a f^2/(f1^2 - f^2)), f1 of the free disc"
    separated_by = "another place of the sensor, another plate thickness"
    source = "first axisymmetric mode of a free disc; a is the mode's share where it is read, below 1"
    absent_in = CENTRED_SENSOR
    parameters = (signed("share", 0.3),)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion with the bending mode's share."""
        return motion * bending(setting, values["share"])


def bending(setting: Setting, share: RealArray) -> ComplexArray:
    """Return the factor on the reading by the top plate's first bending mode; 1 for a share of 0."""
    plate, configuration = setting.campaign.top_plate, setting.configuration
    h = configuration.top_plate_thickness
    stiffness = plate.young_modulus * h**3 / (12 * (1 - plate.poisson_ratio**2))
    first = FIRST_BENDING / (2 * np.pi * configuration.specimen_radius**2) * np.sqrt(stiffness / (plate.density * h))
    ratio = (setting.frequency / first) ** 2
    return np.asarray(1 + share * ratio / (1 - ratio + 0.01j))


def share_of_open_rim(rim: RealArray, poisson_ratio: float) -> RealArray:
    """Return the share of a plate's first mode in its centre where a rim of the sample does not hold it.

    The plate's inertia is spread over its area, the pressure that drives it over the inner part, b of its radius. The
    deflection of the free disc under both, as classical plate theory has it, is that of the centre over the mean, in
    units of ``m w^2 R^4 / D``; see S. P. Timoshenko & S. Woinowsky-Krieger, Theory of Plates and Shells, 2nd ed. 1959,
    ch. 3.

    Parameters
    ----------
    rim : array
        ``1 - b``, 0 to below 1.
    poisson_ratio : float
        Of the plate.
    """
    b = 1 - np.asarray(rim, dtype=float)
    # slopes W' = (1 - 1/b^2) r^3/16 + c r/2 within b, r^3/16 - r ln r/4 + (1/4 + d) r/2 - b^2/(16 r) beyond; W over its
    # mean is minus the integral of (1 - r^2) W'
    d = ((1 - poisson_ratio) * (3 - b**2) - 4) / (8 * (1 + poisson_ratio))  # no moment at the rim
    c = d + 0.25 - np.log(b) / 2
    within = (1 - 1 / b**2) * (b**4 / 64 - b**6 / 96) + c * (b**2 / 4 - b**4 / 8)
    return np.asarray(-(FIRST_BENDING**2) * (within + _beyond(1.0, b, d) - _beyond(b, b, d)))


def _beyond(r: RealArray | float, b: RealArray, d: RealArray) -> RealArray:
    """Return the integral of ``(1 - r^2) W'`` beyond b."""
    log = np.log(r)
    return np.asarray(
        (r**4 / 4 - r**6 / 6) / 16
        - (r**2 * log / 2 - r**2 / 4 - r**4 * log / 4 + r**4 / 16) / 4
        + (1 / 8 + d / 2) * (r**2 / 2 - r**4 / 4)
        - b**2 / 16 * (log - r**2 / 2)
    )
