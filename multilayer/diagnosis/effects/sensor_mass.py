"""The accelerometer's mass on the top plate."""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive
from multilayer.inference.priors import Parameter, Prior


class SensorMass(Effect):
    """Mass in the centre of the top plate, which bends a little under it; see `Setting.at_centre`."""

    name = "sensor_mass"
    place = "top_plate"
    law = "top plate mass + m; reading and m times 1/(1 - b w^2 m C), C the yielding of the plate's centre"
    separated_by = "a second top plate of another mass"
    source = "piezoelectric accelerometers of 0.2 to 10 g; PCB 352C22 of the paper: 0.5 g, with cable about 1 g"
    moves_resonances = True
    # 15 right names of seeds 1008 to 1011: off by noise alone; another solver: 0.4 %
    size_errors: ClassVar[Mapping[str, float]] = {"mass": 0.01}
    parameters = (
        positive("mass", 1e-3, 1.2, "kg"),
        Parameter(name="bending", prior=Prior(normal=(0.5, 0.4))),  # from 0, as wide as the plate, to 1, a point
    )

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """Return the chain with a heavier plate."""
        mass, _ = setting.at_centre(values["mass"], values["bending"])
        return chain.with_(plate_mass=chain.plate_mass + mass)

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion where the mass is mounted."""
        return motion * setting.at_centre(values["mass"], values["bending"])[1]
