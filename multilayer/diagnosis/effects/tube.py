"""The names that modules of effects of impedance tubes import."""

from multilayer.experiments.effects import Values
from multilayer.experiments.stacks.effects import (
    Tube,
    TubeEffect,
    TubeSetting,
    sample_index,
    thickness_of,
    with_layer,
    with_layers,
)

__all__ = ["Tube", "TubeEffect", "TubeSetting", "Values", "sample_index", "thickness_of", "with_layer", "with_layers"]
