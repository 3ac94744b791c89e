"""Air of another temperature than stated."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting
from multilayer.stack import Stack


class Temperature(TubeEffect):
    """The gas in tube and sample is warmer or colder; the evaluation uses the wavenumber at the stated temperature."""

    name = "temperature"
    law = "gas at T + dT in tube and pores; c ~ sqrt(T)"
    separated_by = "a thermometer"
    source = "a room, or a tube warmed by its loudspeaker: some kelvins"
    parameters = (signed("difference", 3.0, "K"),)
    law_error = 0.02
    changes_gas = True

    def applies(self, setting: TubeSetting) -> bool:
        """Tell whether the gas is described by its temperature, rather than by density and sound speed."""
        ambient = setting.stack.ambient
        return all(value is None for value in (ambient.density, ambient.sound_speed, ambient.viscosity))

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Return the stack with the gas at the other temperature; NaN where that is below 0 K."""
        warmer = stack.ambient.temperature + values["difference"].item()
        warmer = warmer if warmer > 0 else np.nan
        return stack.model_copy(update={"ambient": stack.ambient.model_copy(update={"temperature": warmer})})

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Return the reflection from a transfer function in the actual gas, evaluated with the stated temperature."""
        stated = setting.stack.ambient.temperature
        with np.errstate(invalid="ignore", divide="ignore"):
            actual = setting.wavenumber * np.sqrt(stated / (stated + values["difference"]))
        return setting.evaluated(setting.transfer_function(reflection, actual))
