"""Bending of the top plate.

A. W. Leissa, Vibration of Plates, NASA SP-160 (1969), ch. 2: free circular plates.
"""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.base import CENTRED_SENSOR, Effect, Setting, Values, signed


class PlateFlexure(Effect):
    """The reading contains the plate's first bending mode, f1 = 9.003/(2 pi R^2) sqrt(D/(rho h)) of a free disc."""

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
    squared = (setting.frequency / setting.first_bending) ** 2
    return np.asarray(1 + share * squared * setting.bending_gain(setting.frequency))
