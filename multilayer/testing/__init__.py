"""The laws that layers and effects keep, to be run by whoever writes one; nothing here needs a test framework."""

from multilayer.testing.effects import check_effect
from multilayer.testing.layers import check_layer

__all__ = ["check_effect", "check_layer"]
