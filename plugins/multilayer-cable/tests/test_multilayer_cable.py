"""The effect keeps the laws of effects, and has the rig's notch."""

import numpy as np
from multilayer_cable import CableResonance

from multilayer.rig.effects import EFFECTS as RIG_EFFECTS
from multilayer.testing import check_effect
from multilayer.testing.benches import bench


def test_laws_of_effects():
    check_effect(CableResonance)


def test_the_notch_is_that_of_the_virtual_rig():
    given = {"frequency": 300.0, "loss_factor": 0.2, "depth": 0.15}
    theirs = RIG_EFFECTS["cable_resonance"](**given)
    setting = bench(CableResonance()).settings[0]
    ones = np.ones((1, setting.frequency.size), dtype=complex)
    values = {name: np.array([[value]]) for name, value in given.items()}
    ours = CableResonance().motion(setting, ones, values)[0]

    class First:
        index, count = 0, 1

    assert np.allclose(ours, theirs.apply_to_response(setting.frequency, ones[0], First()), rtol=1e-14)
