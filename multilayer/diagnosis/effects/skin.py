"""Stiffer layers of the sample near its faces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive


class Skin(Effect):
    """Layers of another modulus at both faces, the same for all thicknesses of the sample."""

    name = "skin"
    place = "faces"
    acts_through_place = False
    law = "modulus times k within t of each face"
    separated_by = "another thickness"
    source = "moulded foams: skins of 0.3 to 3 mm, 2 to 20 times as stiff"
    moves_resonances = True
    parameters = (positive("thickness", 1e-3, 0.6, "m"), positive("ratio", 3.0, 0.7, bounds=(1.0, 100.0)))
    absent: ClassVar[Mapping[str, float]] = {"ratio": 1.0}

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with the sample divided into skin, core and skin."""
        thickness = np.minimum(values["thickness"], 0.45 * setting.configuration.specimen_thickness)
        return chain.with_(skin=(thickness, values["ratio"]))
