"""The names that modules of effects on levels import."""

from multilayer.experiments.effects import Values
from multilayer.experiments.levels.effects import LevelEffect, LevelSetting, with_each, with_losses
from multilayer.experiments.levels.sound_field import SoundField, plates_of, surface_density

__all__ = [
    "LevelEffect", "LevelSetting", "SoundField", "Values", "plates_of", "surface_density", "with_each", "with_losses",
]  # fmt: skip
