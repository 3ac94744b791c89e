"""What to measure next."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis import experiments
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.judgement import Judgement
from multilayer.diagnosis.tube import experiments as tube_experiments
from multilayer.executors import local_pool
from multilayer.inference.problem import Minimum
from multilayer.testing.benches import joint_bench


@pytest.mark.parametrize("menu", [experiments.MENU, tube_experiments.MENU])
def test_changes_reach_other_processes(menu):
    assert [one.change for one in pickle.loads(pickle.dumps(menu))] == [one.change for one in menu]


def _large(name):
    hypothesis = joint_bench().with_effects(EFFECTS[name]())
    z = np.zeros(len(hypothesis.parameters))
    z[len(hypothesis.nominal_parameters) :] = 1.0
    residual, slopes = hypothesis.linearised(z)
    return Fitted(hypothesis, Minimum(z, float(residual @ residual), residual, slopes))


def test_swapped_channels_tell_a_gain_from_glue_wherever_it_is_computed():
    alive = [(_large("channel_gain"), 0.5), (_large("adhesive"), 0.5)]
    plans = experiments.next_experiments(alive)
    swapped = next(plan for plan in plans if plan["change"] == "channels swapped")
    assert swapped["separates"] == [["channel_gain"], ["adhesive"]]
    with local_pool(2) as pool:
        assert experiments.next_experiments(alive, pool) == plans


@pytest.mark.parametrize(("behind", "group", "alive"), [(30.0, 1, 2), (150.0, 1, 1), (3.0, 2, 2), (3.0, 3, 3)])
def test_what_is_far_behind_is_worth_no_experiment(behind, group, alive):
    names = [("skin",), ("adhesive",), ("preload",)]
    found = SimpleNamespace(
        ranked=names, fitted=dict.fromkeys(names, "fit"), score=lambda one: -behind * names.index(one),
        probabilities=lambda: dict.fromkeys(names, 0.3),
    )  # fmt: skip
    judgement = Judgement(found, SimpleNamespace(group=names[:group]), {}, None, {})
    assert len(judgement.alive) == alive
