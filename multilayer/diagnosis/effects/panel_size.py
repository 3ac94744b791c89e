"""The size of a panel or sample that the model takes for infinite.

M. Villot, C. Guigou & L. Gagliardini, J. Sound Vib. 245 (2001) 433-455; S.-I. Thomasson, Acustica 44 (1980) 265-273.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar

from multilayer.diagnosis.effects.base import positive
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, SoundField, Values


class PanelSize(LevelEffect):
    """Radiation of a square panel: more loss at low frequencies; of an absorber the edge effect, above 1."""

    name = "panel_size"
    place = "field"
    acts_through_place = False
    quantities = ("transmission_loss", "absorption")
    law = "radiation impedance of a square panel of side a in place of 1/cos"
    separated_by = "a sample of another size; 'finite_size' of the measurement, which says it"
    source = "openings of ISO 10140 are 1.25 m by 1.5 m and 10 m2, samples of ISO 354 10 to 12 m2"
    parameters = (positive("side", 1.6, 0.5, "m"),)
    absent: ClassVar[Mapping[str, float]] = {"side": 64.0}

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether the measurement is that of a diffuse field, without a stated size."""
        return super().applies(setting) and setting.sound.is_diffuse and setting.sound.window is None

    def sound_field(self, setting: LevelSetting, sound: SoundField, values: Values) -> SoundField:
        """Return the sound field with the size."""
        return replace(sound, side=values["side"])
