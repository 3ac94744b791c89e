"""Air of another temperature than stated."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import Values, signed
from multilayer.diagnosis.effects.tube import TubeEffect, TubeSetting
from multilayer.stack import Stack


class Temperature(TubeEffect):
    """The gas in tube and sample is warmer or colder; the evaluation goes on with the wavenumber of the stated one."""

    name = "temperature"
    law = "gas at T + dT in tube and pores; c ~ sqrt(T)"
    separated_by = "a thermometer"
    source = "a room, or a tube warmed by its loudspeaker: some kelvins"
    parameters = (signed("difference", 3.0, "K"),)
    law_error = 0.02
    changes_gas = True

    def applies(self, setting: TubeSetting) -> bool:
        """A gas described by its density and sound speed has no temperature to be wrong."""
        ambient = setting.stack.ambient
        return all(value is None for value in (ambient.density, ambient.sound_speed, ambient.viscosity))

    def stack(self, setting: TubeSetting, stack: Stack, values: Values) -> Stack:
        """Another gas in the pores."""
        warmer = stack.ambient.temperature + values["difference"].item()
        return stack.model_copy(update={"ambient": stack.ambient.model_copy(update={"temperature": warmer})})

    def reading(self, setting: TubeSetting, reflection: ComplexArray, values: Values) -> ComplexArray:
        """Wavenumber of the real gas on the way to the microphones, of the stated one in the evaluation."""
        stated = setting.stack.ambient.temperature
        real = setting.wavenumber * np.sqrt(stated / (stated + values["difference"]))
        return setting.evaluated(setting.transfer_function(reflection, real))
