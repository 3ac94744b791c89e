"""The ranking of designs for the next experiment."""

import pickle
from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis.assessment import Assessment
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.evidence import UNKNOWN
from multilayer.diagnosis.experiment_design import posterior_without
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.levels.designs import LEVEL_DESIGNS
from multilayer.diagnosis.rig_designs import RIG_DESIGNS, rank_rig_designs
from multilayer.diagnosis.tube.designs import TUBE_DESIGNS
from multilayer.executors import local_pool
from multilayer.testing.benches import joint_bench

ALL_DESIGNS = [RIG_DESIGNS, TUBE_DESIGNS, LEVEL_DESIGNS]


@pytest.mark.parametrize("designs", ALL_DESIGNS)
def test_designs_remove_effects_that_there_are(designs):
    """By the design's list, and by what an effect, as that of a plugin, says of itself."""
    assert {name for design in designs for name in design.without} <= {*EFFECTS}
    of_plugin = SimpleNamespace(name="of_plugin", absent_in=designs[-1].change)
    assert [design.removes(of_plugin) for design in designs] == [design is designs[-1] for design in designs]


def test_changes_that_effects_name_are_designs():
    changes = {design.change for designs in ALL_DESIGNS for design in designs}
    assert {EFFECTS[name].absent_in for name in EFFECTS} - {""} <= changes


@pytest.mark.parametrize("designs", ALL_DESIGNS)
def test_designs_reach_other_processes(designs):
    assert [design.change for design in pickle.loads(pickle.dumps(designs))] == [design.change for design in designs]


def _large(name):
    hypothesis = joint_bench().with_effects(EFFECTS[name]())
    z = np.zeros(len(hypothesis.parameters))
    z[len(hypothesis.nominal_parameters) :] = 1.0
    return Fitted(hypothesis, hypothesis.as_minimum(z))


def test_swapped_channels_discriminate_a_gain_from_glue_wherever_it_is_computed():
    rivals = [(_large("channel_gain"), 0.5), (_large("adhesive"), 0.5)]
    plans = rank_rig_designs(rivals)
    swapped = next(plan for plan in plans if plan["change"] == "channels swapped")
    assert swapped["separates"] == [["channel_gain"], ["adhesive"]]
    with local_pool(2) as pool:
        assert rank_rig_designs(rivals, pool) == plans


@pytest.mark.parametrize(("behind", "group", "count"), [(20.0, 1, 2), (50.0, 1, 1), (3.0, 2, 2), (3.0, 3, 3)])
@pytest.mark.parametrize("has_places", [False, True])
def test_a_hypothesis_far_behind_is_no_rival(behind, group, count, has_places):
    names = [("skin",), ("adhesive",), ("preload",)]
    comparison = SimpleNamespace(
        ranked=names, fitted=dict.fromkeys(names, "fit"), score=lambda cause: -behind * names.index(cause),
        places={"faces": SimpleNamespace(explanation="free")} if has_places else {},
    )  # fmt: skip
    shares = {**dict.fromkeys(names, 0.3), UNKNOWN: 0.1}
    decision = SimpleNamespace(verdict="effect", group=names[:group], best=names[0], probabilities=lambda _: shares)
    rivals = Assessment(comparison, decision, {}, None, {}).rivals
    # without a near one, a cause that is none of the known is the rival: a free law at the best place
    free = [("free", 0.1)] if has_places and count == 1 else []
    assert rivals == [("fit", 0.3)] * count + free


@pytest.mark.parametrize("known", [0, 1, 2])
def test_an_unknown_cause_of_a_group_is_a_rival_of_the_others(known):
    names = [("skin",), ("adhesive",), ("preload",)]
    comparison = SimpleNamespace(
        ranked=names, fitted={one: one[0] for one in names}, score=lambda cause: -float(names.index(cause)),
        places={"faces": SimpleNamespace(explanation="free")},
    )  # fmt: skip
    shares = {**dict.fromkeys(names, 0.2), UNKNOWN: 0.4}
    decision = SimpleNamespace(
        verdict="unknown", group=[UNKNOWN, *names[:known]], best=names[0], probabilities=lambda _: shares
    )
    rivals = Assessment(comparison, decision, {}, None, {}).rivals
    assert rivals == [*((one[0], 0.2) for one in names[: max(known, 1)]), ("free", 0.4)]


def test_a_variance_that_rounding_makes_negative_is_none():
    fitted = _large("channel_gain")
    covariance = fitted.minimum.covariance.copy()
    covariance[0, 0] = -1e-18
    covariance[0, 1:] = covariance[1:, 0] = 0.0
    minimum = SimpleNamespace(z=fitted.minimum.z, covariance=covariance)
    _, z, root = posterior_without(SimpleNamespace(hypothesis=fitted.hypothesis, minimum=minimum), lambda effect: False)
    assert np.allclose(root @ root.T, covariance, rtol=1e-9, atol=1e-15)
    assert len(z) == len(root)
