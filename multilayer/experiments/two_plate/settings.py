"""What the model of the rig takes into account besides what a campaign describes."""

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
        Of the air above the top plate and in pores.
    pores : Pores, optional
        Air in the sample's pores; the campaign's density and Poisson's ratio are then those of the frame.
    sensor_mass : float
        kg of the accelerometer, which moves with the top plate: in its middle, or spread over it for plane waves.
    """

    ambient: Ambient = Ambient()
    pores: Pores | None = None
    sensor_mass: SensorMass = 0.0
