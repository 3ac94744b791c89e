"""The largest angle of incidence, which no room is asked for."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from multilayer.diagnosis.effects.base import signed
from multilayer.diagnosis.effects.levels import LevelEffect, LevelSetting, SoundField, Values

_LEAST, _MOST = 30.0, 89.9  # degrees


class LimitAngle(LevelEffect):
    """A field whose waves come from up to another angle than the model's."""

    name = "limit_angle"
    place = "field"
    acts_through_place = False
    quantities = ("transmission_loss", "absorption")
    law = "largest angle of incidence + d"
    separated_by = "an opening that is less deep, or a second pair of rooms; 'finite_size', which needs no limit"
    source = "70 to 85 degrees fit measured walls, 78 by custom; H. J. Kang et al., J. Acoust. Soc. Am. 107 (2000) 1413"
    parameters = (signed("difference", 6.0, "degree"),)

    def applies(self, setting: LevelSetting) -> bool:
        """Tell whether the field is a diffuse one."""
        return super().applies(setting) and setting.sound.is_diffuse

    def sound_field(self, setting: LevelSetting, sound: SoundField, values: Values) -> SoundField:
        """Return the sound field with another largest angle."""
        return replace(sound, angle=np.clip(sound.angle + values["difference"], _LEAST, _MOST))
