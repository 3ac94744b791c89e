"""The law of a modulus that drifts is the one that is told."""

import numpy as np

from multilayer.diagnosis.effects.temperature_drift import TemperatureDrift
from multilayer.testing.benches import joint_bench


def test_the_modulus_drifts_by_the_factor_that_is_told():
    effect, setting = TemperatureDrift(), joint_bench().settings[-1]
    modulus = np.full((1, len(setting.frequency)), 2e5 + 4e4j)
    drifted = effect.modulus(setting, modulus, {"total": np.array([[-0.4]])})
    np.testing.assert_allclose(drifted / modulus, np.exp(-0.4 * np.atleast_2d(setting.order)))
    for told in (effect.law, TemperatureDrift.__doc__):
        assert told.startswith("E exp(d u), u")
