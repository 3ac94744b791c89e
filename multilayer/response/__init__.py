"""What one asks of a stack."""

from multilayer.response.base_motion import BaseMotion, base_motion
from multilayer.response.plane_wave import PlaneWave, plane_wave

__all__ = ["BaseMotion", "PlaneWave", "base_motion", "plane_wave"]
