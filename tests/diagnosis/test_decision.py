"""What the decision asks of causes, by itself."""

from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.hypothesis import Hypothesis
from multilayer.diagnosis.ranking import undone
from multilayer.testing.benches import joint_bench


class OtherGain(EFFECTS["channel_gain"]):
    """The same law under another name."""

    name = "other_gain"


def fitted(effects, sizes):
    campaign, joint = joint_bench()
    hypothesis = Hypothesis(campaign, joint).with_effects(*effects)
    own = [float(p.prior.coordinate(size)) for p, size in zip(hypothesis.effect_parameters, sizes, strict=True)]
    z = np.concatenate([np.zeros(len(joint.parameters)), own])
    return SimpleNamespace(hypothesis=hypothesis, minimum=SimpleNamespace(z=z))


@pytest.mark.parametrize("size", [0.04, 0.01, -0.02, -0.038])
def test_effects_that_undo_each_other_are_seen(size):
    found = undone(fitted([EFFECTS["channel_gain"](), OtherGain()], [0.04, size]))
    first, second = np.log1p(0.04), np.log1p(size)
    assert found == pytest.approx(min(first, abs(second)) / abs(first + second), rel=0.02)


def test_effects_that_have_nothing_to_do_with_each_other_undo_nothing():
    # level and phase
    assert undone(fitted([EFFECTS["channel_gain"](), EFFECTS["channel_delay"]()], [0.04, 1e-5])) < 1


def test_a_skin_is_never_softer_and_glue_never_heavier_than_glue():
    ratio = EFFECTS["skin"].parameters[1].prior
    mass = EFFECTS["adhesive"].parameters[2].prior
    assert ratio.value(-8.0) == pytest.approx(1.0, abs=1e-6)
    assert mass.value(8.0) == pytest.approx(0.6, rel=1e-6)
    assert ratio.value(0.0) > 3.0
