"""From what size on effects would show in the data, and up to which."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis.effects.base import EFFECTS
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.signatures import detectable_sizes, signatures
from multilayer.diagnosis.thresholds import DETECTED
from multilayer.testing.benches import joint_bench, level_bench, soft_sample, tube_bench
from tests.diagnosis.rigs import measured_with


def of_bench(hypothesis):
    """Return the nominal fit of a bench, of which nothing is unknown."""
    return Fitted(hypothesis, hypothesis.as_minimum(np.zeros(len(hypothesis.parameters))))


def of_rig():
    """Return the nominal fit of a rig whose modulus law and stated uncertainties are unknown."""
    return measured_with([], [])


def detectable(nominal, name):
    effects = {name: EFFECTS[name]()}
    return detectable_sizes(nominal, effects, signatures(nominal, effects)).get(name)


def length(nominal, name, size):
    """Return how many standard deviations an effect changes, less what the unknowns absorb; its others are usual."""
    effect, minimum = EFFECTS[name](), nominal.minimum
    first, *others = effect.parameters
    own = [first.prior.coordinate(size), *(1.0 if p.prior.normal else 0.0 for p in others)]
    z = np.append(minimum.z, own)
    change = nominal.hypothesis.with_effects(effect).residual(z) - nominal.hypothesis.residual(minimum.z)
    absorbed = minimum.jacobian @ np.linalg.solve(minimum.precision, minimum.jacobian.T @ change)
    return np.sqrt(change @ (change - absorbed))


NOMINAL = {
    "rig": of_rig,
    "wall": lambda: of_bench(level_bench("transmission_loss")),
    "tube": lambda: of_bench(tube_bench()),
}
VANISHING = [
    ("rig", "sensor_mount"), ("wall", "flanking_path"), ("wall", "structural_links"), ("wall", "panel_size"),
    ("tube", "frame_motion"), ("tube", "edge_constraint"),
]  # fmt: skip
GROWING = [
    ("rig", "channel_gain"), ("rig", "sensor_mass"), ("rig", "skin"), ("wall", "leak"), ("wall", "limit_angle"),
    ("tube", "rear_air_gap"), ("tube", "facing"), ("tube", "temperature"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("shows", "of", "name"), [*(("up to", *one) for one in VANISHING), *(("from", *one) for one in GROWING)]
)
def test_an_effect_shows_from_a_size_on_or_where_it_vanishes_at_large_values_up_to_one(shows, of, name):
    nominal = NOMINAL[of]()
    entry = detectable(nominal, name)
    assert entry["shows"] == shows
    near = [length(nominal, name, factor * entry["smallest"]) for factor in (0.95, 1.0, 1.05)]
    assert near[1] == pytest.approx(DETECTED, rel=0.02)
    smaller, larger = near[::2] if shows == "from" else near[::-2]
    assert smaller < DETECTED < larger


def test_of_a_hump_the_first_side_from_where_the_effect_is_absent_is_told():
    """A stiff frame resonates in the band and shows; of usual stiffness it is limp, and hardly does."""
    nominal = of_bench(tube_bench())
    usual = EFFECTS["frame_motion"]().parameters[0].prior.value(0.0)
    assert length(nominal, "frame_motion", usual) < DETECTED
    assert detectable(nominal, "frame_motion")["smallest"] > 10 * usual


def test_springs_on_a_frame_that_moves_are_absent_where_they_are_soft():
    assert detectable(of_bench(tube_bench(elastic=True)), "edge_constraint")["shows"] == "from"


def test_a_free_rim_has_no_size_and_what_nobody_could_see_has_none():
    bench = joint_bench()
    nominal = Fitted(bench, bench.as_minimum(soft_sample(bench)))
    effects = {name: EFFECTS[name]() for name in ("finite_size", "channel_gain")}
    columns = np.zeros((len(nominal.minimum.residual), 2))
    assert [*detectable_sizes(nominal, effects, columns)] == ["channel_gain"]
    deaf = replace(bench, configurations=[replace(d, variance=1e12 * d.variance) for d in bench.configurations])
    entry = detectable(Fitted(deaf, deaf.as_minimum(soft_sample(deaf))), "channel_gain")
    assert entry == {"parameter": "gain", "smallest": None, "unit": "", "shows": "from"}
