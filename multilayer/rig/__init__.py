"""The virtual two-plate rig: axisymmetric finite elements in place of the shaker."""

from multilayer.rig.reduced import Ranges, ReducedRig
from multilayer.rig.shape_factor import static_shape_factor
from multilayer.rig.two_plate import TwoPlateRig

__all__ = ["Ranges", "ReducedRig", "TwoPlateRig", "static_shape_factor"]
