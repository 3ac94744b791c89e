"""The accelerometer's mass on the top plate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive, signed
from multilayer.diagnosis.effects.plate_flexure import bending


class SensorMass(Effect):
    """Mass added on the top plate, which bends a little under it; see `plate_flexure` for the bending."""

    name = "sensor_mass"
    place = "top_plate"
    law = "top plate mass + m; T (1 + a f^2/(f1^2 - f^2)), f1 of the free disc"
    separated_by = "a second top plate of another mass"
    source = "piezoelectric accelerometers of 0.2 to 10 g; PCB 352C22 of the paper: 0.5 g, with cable about 1 g"
    moves_resonances = True
    # 15 right names of seeds 1008 to 1011: off by noise alone; another solver: 0.4 %
    size_errors: ClassVar[Mapping[str, float]] = {"mass": 0.01}
    parameters = (positive("mass", 1e-3, 1.2, "kg"), signed("bending", 0.3))

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with a heavier plate."""
        return chain.with_(plate_mass=chain.plate_mass + values["mass"])

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion where the mass is mounted."""
        return motion * bending(setting, values["bending"])
