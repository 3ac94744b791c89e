"""Standard deviations: what they scale with, and whether they hold the truth."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.experiments.two_plate.burst import BurstProblem
from multilayer.fits.burst.acceptance import Criteria, discrepancies_in_band
from multilayer.fits.burst.branches import find_candidates
from multilayer.fits.burst.fit import search_bounds
from multilayer.fits.burst.uncertainty import error_parts, noise_covariance, pseudo_inverse
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Uncertainty
from multilayer.signals.envelope import envelope, level_difference_db
from multilayer.signals.time_of_flight import time_of_flight
from tests.fits.synthetic import Truth, burst, problem, rig

BOUNDS = search_bounds(FitSettings())
LABORATORY = Uncertainty(
    channel_gain=0.003, channel_delay=1e-6, remount_gain=0.001, thickness=5e-5, density=0.01, top_plate_mass=0.002
)


@pytest.mark.parametrize("quantity", list(Uncertainty.model_fields))
def test_a_stated_uncertainty_adds_its_square(quantity: str) -> None:
    truth = Truth(2e5, 0.3, 400.0)
    posed = problem(truth)

    def variance(size: float) -> np.ndarray:
        known = Uncertainty(**{quantity: size * getattr(LABORATORY, quantity)})
        return np.diag(error_parts(posed, truth.x, known).covariance - error_parts(posed, truth.x, None).covariance)

    assert np.all(variance(1) >= 0)
    assert variance(1).max() > 0
    assert variance(2) == pytest.approx(4 * variance(1), rel=0.02)


def noise_part(posed: BurstProblem, x: np.ndarray) -> np.ndarray:
    return noise_covariance(posed, x, pseudo_inverse(posed.jacobian(x)))


def test_noise_of_the_base_passes_through_the_resonance() -> None:
    at_resonance, far_above = Truth(2e5, 0.1, 150.0), Truth(2e5, 0.1, 1200.0)
    growth = []
    for truth in (at_resonance, far_above):
        posed = problem(truth)
        quiet, loud = (
            replace(posed.data, noise=posed.data.noise._replace(base=base, top=0.01)) for base in (0.0, 0.01)
        )
        with_base, without = (np.diag(noise_part(BurstProblem(d, posed.rig), truth.x)) for d in (loud, quiet))
        growth.append(with_base[0] / without[0])
    assert growth[0] > 10
    assert growth[1] < 1.5


def test_coverage_over_simulated_laboratories() -> None:
    """Draw what a laboratory does not know; its standard deviations must describe the errors."""
    rng = np.random.default_rng(4)
    truth = Truth(2e5, 0.3, noise=0.004)
    scores = []
    for k, frequency in enumerate(rng.choice([150.0, 300.0, 600.0, 1200.0], 40)):
        drawn = rig()
        draw = rng.standard_normal(5)
        for quantity, size, relative in (
            ("thickness", 5e-5, False),
            ("density", 0.01, True),
            ("top_plate_mass", 0.002, True),
        ):
            drawn = drawn.shifted(quantity, draw[0] * size, relative=relative)
            draw = np.roll(draw, -1)
        data = burst(replace(truth, frequency=float(frequency), seed=k), drawn)
        gain = np.hypot(LABORATORY.channel_gain, LABORATORY.remount_gain)
        data = replace(data, top=data.top * (1 + gain * draw[0]))
        posed = BurstProblem(data, rig())
        best = find_candidates(posed, *BOUNDS).minima[0]
        spread = np.sqrt(np.diag(error_parts(posed, best.z, LABORATORY).covariance))
        scores.append((best.z - truth.x) / spread)
    z = np.abs(np.array(scores))
    assert np.all((z < 2).mean(axis=0) >= 0.9)
    # and they are not merely large
    assert np.all(np.sqrt((z**2).mean(axis=0)) > 0.5)


@pytest.mark.parametrize("frequency", [150.0, 500.0, 1500.0])
def test_discrepancies_in_the_band_are_those_of_the_signals(frequency: float) -> None:
    truth = Truth(2e5, 0.3, frequency)
    posed = problem(truth)
    x = truth.x + np.array([[0.03, 0.0], [0.0, 0.03], [-0.02, 0.02]])
    tof, level = discrepancies_in_band(posed, x)
    for k, point in enumerate(x):
        signal, data = posed.signal(point), posed.data
        delays = [time_of_flight(data.base, top, data.sampling_rate) for top in (data.top, signal)]
        assert tof[k] == pytest.approx(delays[0] - delays[1], abs=2e-7)
        assert level[k] == pytest.approx(level_difference_db(data.envelope, envelope(signal)), abs=2e-3)


def test_criteria_speak() -> None:
    criteria = Criteria(time_of_flight=1 / 25600, level_db=0.5)
    assert criteria.reason(1 / 25600, -0.5) == ""
    assert "level off by +0.60 dB" in criteria.reason(0.0, 0.6)
    assert "time of flight off by -40 us" in criteria.reason(-4e-5, 0.0)
    assert "time of flight" in criteria.reason(float("nan"), 0.0)
