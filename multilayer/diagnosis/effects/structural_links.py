"""Studs and other links between the leaves of a construction.

J. L. Davy 1991, see `levels.paths.link_transmission`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, Values, plates_of
from multilayer.diagnosis.levels.paths import link_transmission
from multilayer.layers.base import ElasticLayer
from multilayer.stack import Stack


class StructuralLinks(LevelEffect):
    """Linear links at regular distances between the first and the last leaf."""

    name = "structural_links"
    place = "links"
    law = "tau + tau_links(b, C): links b apart, of compliance C per length"
    separated_by = "leaves on separate frames; another distance of the studs; velocity of the back leaf along a stud"
    source = "studs 0.3 to 0.6 m apart, C of steel about 1e-6 m2/N (J. L. Davy), of wood next to none"
    parameters = (positive("spacing", 0.5, 0.4, "m"), positive("compliance", 5e-7, 1.5, "m^2/N"))
    absent: ClassVar[Mapping[str, float]] = {"spacing": 1e6}

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether there are two leaves with something between."""
        plates = plates_of(setting.stack)
        return super().applies(setting) and len(plates) > 1 and plates[-1] - plates[0] > 1

    def beside(self, setting: LevelSetting, stack: Stack, share: RealArray, values: Values) -> RealArray:
        """Return the share of the power with that of the links."""
        plates = plates_of(stack)
        front, back = stack.layers[plates[0]], stack.layers[plates[-1]]
        assert isinstance(front, ElasticLayer)
        assert isinstance(back, ElasticLayer)
        added = link_transmission(setting.frequency, front, back, values["spacing"], values["compliance"], setting.gas)
        return np.asarray(share + added)
