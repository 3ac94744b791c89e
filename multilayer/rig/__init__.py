"""The virtual two-plate rig: axisymmetric finite elements in place of the shaker."""

from multilayer.rig.reduced import Ranges, ReducedRig
from multilayer.rig.shape_factor import dynamic_shape_factor, static_shape_factor
from multilayer.rig.two_plate import TwoPlateRig

__all__ = ["Ranges", "ReducedRig", "TwoPlateRig", "dynamic_shape_factor", "static_shape_factor"]
