"""From measured accelerations to material properties.

The complex modulus of a sample between a shaken plate and a top plate, burst by burst (Bonfiglio & Pompoli 2015).
"""

from multilayer.inverse.fit import fit_campaign
from multilayer.inverse.result import BurstFit, FitResult
from multilayer.inverse.settings import FitSettings

__all__ = ["BurstFit", "FitResult", "FitSettings", "fit_campaign"]
