"""Records that end before the ring-down does are no gap. Data of rods, another forward model."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis import diagnose
from multilayer.diagnosis.effects.sensor_mass import SensorMass
from multilayer.diagnosis.goodness_of_fit import lack_of_fit
from multilayer.diagnosis.thresholds import MODEL_ERROR
from tests.fits.rods import campaign_of_rods, constant_loss

BURSTS = (100.0, 300.0, 500.0, 700.0, 900.0)


def nominal(tail, noise):
    made = campaign_of_rods(constant_loss(2e5, 0.02), frequencies=BURSTS, tail=tail, noise=(noise, noise))
    return diagnose.fit_nominal(*made)[0]


@pytest.fixture(scope="module")
def short():
    return nominal(0.08, 0.002)


def test_they_are_completed_as_the_model_has_them(short, monkeypatch):
    assert not lack_of_fit(short)
    monkeypatch.setattr(diagnose, "with_complete_records", lambda problem, minima, bursts: (problem, minima))
    assert lack_of_fit(nominal(0.08, 0.002))


def test_the_completed_ratio_is_that_of_long_records(short):
    (data,), long = short.hypothesis.data, nominal(2.0, 0.002)
    assert long.hypothesis.data[0].completed_by is None
    problem = long.hypothesis
    (motion,) = np.exp(problem.experiments[0].log_motion(problem.points(long.minimum.z), data.frequency, data.burst))
    assert np.max(data.completed_by) > 0.1
    assert np.all(np.abs(np.log(data.ratio / motion)) < 3 * np.sqrt(data.variance + MODEL_ERROR**2))


def test_a_given_effect_rings_too():
    """A mass that is known to stand on the plate: 3 g on 12.5 g."""
    made = campaign_of_rods(
        constant_loss(2e5, 0.03), frequencies=BURSTS, thicknesses=(0.0125, 0.025), tail=0.12, noise=(0.002, 0.002),
        errors={"top_plate_mass": 0.24},
    )  # fmt: skip
    known = diagnose.fit_nominal(*made, given=(SensorMass(),))[0]
    assert max(data.completed_by.max() for data in known.hypothesis.data) > 0.02
    assert not lack_of_fit(known)


def test_it_is_told(short):
    (completed,) = diagnose.record_warnings(short)
    assert "bursts whose records end before all is at rest, by up to 15 % of the ratio: 1; the rest is" in completed
    (left_out,) = diagnose.record_warnings(nominal(0.05, 0.002))
    assert "bursts left out, whose records end long before all is at rest: 1; record longer" in left_out
    assert diagnose.record_warnings(nominal(2.0, 0.002)) == []


def test_where_the_model_misses_too_much_records_are_taken_as_they_are_and_that_is_told():
    """A modulus that resonates at 480 Hz, as that of no law."""
    law = constant_loss(2e5, 0.02)

    def resonant(frequency):
        x = np.asarray(frequency, dtype=float) / 480
        return law(frequency) * (1 + 0.3 / (1 - x**2 + 0.1j * x))

    made = campaign_of_rods(resonant, frequencies=BURSTS, tail=0.08, noise=(0.002, 0.002))
    missed = diagnose.fit_nominal(*made)[0]
    (data,) = missed.hypothesis.data
    assert (data.ends, data.completed_by) == ({}, None)
    assert np.max(data.incomplete_by) > 0.1
    *_, told = diagnose.record_warnings(missed)
    assert told.startswith("bursts whose records end before all is at rest, by some ")
    assert told.endswith("that model misses too much to add the rest: it may pass for a gap, record longer")


@pytest.mark.parametrize(("by", "count"), [(0.002, 0), (0.004, 1)])
def test_records_taken_as_they_are_are_told_where_solvers_are_better(short, by, count):
    (data,) = short.hypothesis.data
    plain = replace(data, completed_by=None, incomplete_by=np.array([by]))
    same = replace(short, hypothesis=replace(short.hypothesis, configurations=(plain,)))
    assert len(diagnose.record_warnings(same)) == count
