"""Settings of the rig's model beyond what a campaign describes: air, pores, sensor."""

from __future__ import annotations

from typing import Annotated

from multilayer.experiments.two_plate.pores import Pores
from multilayer.models import Model
from multilayer.stack import Ambient
from multilayer.units import NonNegative, Unit

SensorMass = Annotated[float, NonNegative, Unit("kg")]


class RigSettings(Model):
    """Air, pores and sensor of a rig's model; part of a fit file.

    Attributes
    ----------
    ambient : Ambient
        Air above the top plate and in pores.
    pores : Pores, optional
        Air in the sample's pores; the campaign's density and Poisson's ratio are then those of the frame.
    sensor_mass : float
        Mass of the accelerometer, kg: in the middle of the top plate, or spread over it for plane waves.
    """

    ambient: Ambient = Ambient()
    pores: Pores | None = None
    sensor_mass: SensorMass = 0.0
