"""Checks of what layers, modulus laws, effects and inverse methods keep, for tests of plugins in any test framework."""

from multilayer.testing.effects import check_effect
from multilayer.testing.laws import check_law
from multilayer.testing.layers import check_layer
from multilayer.testing.methods import check_method
from multilayer.testing.modules import use_module
from multilayer.testing.places import check_place
from multilayer.testing.rig_effects import check_rig_effect

__all__ = ["check_effect", "check_law", "check_layer", "check_method", "check_place", "check_rig_effect", "use_module"]
