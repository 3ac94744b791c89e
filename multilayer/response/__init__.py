"""What one asks of a stack."""

from multilayer.response.base_motion import BaseMotion, base_motion
from multilayer.response.diffuse_field import DiffuseField, diffuse_field
from multilayer.response.fields import LayerState, PowerBalance, fields, power_balance
from multilayer.response.plane_wave import PlaneWave, plane_wave

__all__ = [
    "BaseMotion",
    "DiffuseField",
    "LayerState",
    "PlaneWave",
    "PowerBalance",
    "base_motion",
    "diffuse_field",
    "fields",
    "plane_wave",
    "power_balance",
]
