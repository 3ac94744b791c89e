"""The accelerometer's mass on the top plate."""

from __future__ import annotations

from multilayer.diagnosis.effects.base import Chain, Effect, Setting, Values, positive


class SensorMass(Effect):
    """Mass added on the top plate."""

    name = "sensor_mass"
    law = "top plate mass + m"
    separated_by = "a second top plate of another mass"
    source = "piezoelectric accelerometers of 0.2 to 10 g; PCB 352C22 of the paper: 0.5 g, with cable about 1 g"
    moves_resonances = True
    parameters = (positive("mass", 1e-3, 1.2, "kg"),)

    def chain(self, setting: Setting, chain: Chain, values: Values) -> Chain:
        """The plate is heavier."""
        return chain.with_(plate_mass=chain.plate_mass + values["mass"])
