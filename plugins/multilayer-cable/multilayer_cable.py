"""The effect `cable_resonance`: the accelerometer's cable swings and takes the motion away about its own frequency."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects import Effect, Setting
from multilayer.diagnosis.effects.base import Values, positive


class CableResonance(Effect):
    """A notch in what the upper accelerometer shows, alike for all configurations."""

    name = "cable_resonance"
    law = "top over base times (f0^2 - f^2 + i (1 - d) eta f0 f)/(f0^2 - f^2 + i eta f0 f)"
    separated_by = "taping the cable down, or another cable"
    source = "free lengths of 5 to 20 cm of thin coaxial cable swing at some 100 Hz and take 1 to 30 % of the motion"
    parameters = (
        positive("frequency", 350.0, 0.7, "Hz"), positive("loss_factor", 0.3, 0.5), positive("depth", 0.05, 1.0),
    )  # fmt: skip
    law_error = size_error = 0.2
    starts = tuple((start, 0.0, 0.0) for start in np.linspace(-2, 2, 9).tolist())  # narrow: fits start all along f

    def motion(self, setting: Setting, motion: ComplexArray, values: Values) -> ComplexArray:
        """Return the motion less what the cable takes away."""
        f, own = setting.frequency, values["frequency"]
        undamped, loss = own**2 - f**2, 1j * values["loss_factor"] * own * f
        return np.asarray(motion * (undamped + (1 - values["depth"]) * loss) / (undamped + loss))
