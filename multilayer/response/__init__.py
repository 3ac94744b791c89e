"""Responses of a stack: to plane waves, diffuse fields, forces and base motion, inside it, in bands and as ratings."""

from multilayer.response.bands import band_centres, band_edges, band_levels, band_means
from multilayer.response.base_motion import BaseMotion, base_motion
from multilayer.response.derivatives import (
    BaseMotionDerivatives,
    Derivatives,
    DiffuseFieldDerivatives,
    PlaneWaveDerivatives,
    base_motion_derivatives,
    diffuse_field_derivatives,
    plane_wave_derivatives,
)
from multilayer.response.diffuse_field import DiffuseField, diffuse_field
from multilayer.response.driven import Driven, driven, input_mobility
from multilayer.response.duct import DuctMode, duct_mode
from multilayer.response.excitations import Excitation, PointForce, Rain, TappingMachine, TurbulentFlow
from multilayer.response.fields import LayerState, PowerBalance, fields, power_balance
from multilayer.response.finite_size import Window, radiation_impedance
from multilayer.response.free_waves import FreeWaves, free_waves
from multilayer.response.insertion_loss import insertion_loss
from multilayer.response.plane_wave import PlaneWave, plane_wave
from multilayer.response.ports import (
    admittance_matrix,
    impedance_matrix,
    surface_admittance,
    surface_impedance,
    transfer_matrix,
)

__all__ = [
    "BaseMotion",
    "BaseMotionDerivatives",
    "Derivatives",
    "DiffuseField",
    "DiffuseFieldDerivatives",
    "Driven",
    "DuctMode",
    "Excitation",
    "FreeWaves",
    "LayerState",
    "PlaneWave",
    "PlaneWaveDerivatives",
    "PointForce",
    "PowerBalance",
    "Rain",
    "TappingMachine",
    "TurbulentFlow",
    "Window",
    "admittance_matrix",
    "band_centres",
    "band_edges",
    "band_levels",
    "band_means",
    "base_motion",
    "base_motion_derivatives",
    "diffuse_field",
    "diffuse_field_derivatives",
    "driven",
    "duct_mode",
    "fields",
    "free_waves",
    "impedance_matrix",
    "input_mobility",
    "insertion_loss",
    "plane_wave",
    "plane_wave_derivatives",
    "power_balance",
    "radiation_impedance",
    "surface_admittance",
    "surface_impedance",
    "transfer_matrix",
]
