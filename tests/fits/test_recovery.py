"""What the signals were made with is found again."""

import numpy as np
import pytest

from multilayer.fits.burst.branches import find_candidates
from multilayer.fits.burst.fit import search_bounds
from multilayer.fits.burst.nelder_mead import envelope_cost, minimise_envelope_cost
from multilayer.fits.settings import FitSettings
from tests.fits.synthetic import Truth, problem

BOUNDS = search_bounds(FitSettings())

CASES = [
    Truth(2e5, 0.3, 500.0),
    Truth(2e5, 0.3, 100.0),
    Truth(2e5, 0.3, 1500.0),
    Truth(2e4, 0.1, 1000.0),  # well above the resonance: several wavelengths in the sample
    Truth(8e5, 0.05, 700.0),
    Truth(5e6, 0.8, 1500.0),
    Truth(3e3, 0.6, 400.0),
    Truth(5e7, 0.2, 1500.0, dispersive=False),
]


@pytest.mark.parametrize("truth", CASES, ids=lambda t: f"{t.storage_modulus:g}Pa-{t.loss_factor}-{t.frequency:g}Hz")
@pytest.mark.parametrize("poisson_ratio", [0.0, 0.35])
def test_clean_burst(truth: Truth, poisson_ratio: float) -> None:
    found = find_candidates(problem(truth, poisson_ratio=poisson_ratio), *BOUNDS)
    best = found.minima[0]
    assert best.z == pytest.approx(truth.x, rel=1e-3, abs=1e-4)
    assert not best.at_bound
    assert found.plausible == 1


@pytest.mark.parametrize("seed", range(3))
def test_noise_moves_the_result_little(seed: int) -> None:
    truth = Truth(2e5, 0.2, 600.0, noise=0.01, seed=seed)
    best = find_candidates(problem(truth), *BOUNDS).minima[0]
    assert best.z == pytest.approx(truth.x, abs=0.005)


def test_a_ring_down_longer_than_the_record() -> None:
    # loss factor 0.02 at the resonance: the top plate still moves by 40 % of its maximum when the record ends
    truth = Truth(190e3, 0.02, 150.0, record=1.6)
    posed = problem(truth)
    assert posed.data.cut_short
    best = find_candidates(posed, *BOUNDS).minima[0]
    assert best.z[0] == pytest.approx(truth.x[0], abs=0.002)
    assert best.z[1] == pytest.approx(truth.loss_factor, rel=0.05)


def test_nelder_mead_on_a_clean_burst() -> None:
    truth = Truth(2e5, 0.3, 300.0, dispersive=False)
    posed = problem(truth, termination="ambient")
    found = minimise_envelope_cost(posed, np.array([np.log(1.5e5), 0.2]), *BOUNDS)
    assert found.z[0] == pytest.approx(truth.x[0], abs=0.01)
    assert found.z[1] == pytest.approx(truth.loss_factor, rel=0.05)
    costs = np.array([cost for _, cost in found.history])
    assert len(costs) > 20
    assert envelope_cost(posed, found.z) == pytest.approx(costs.min())
    assert found.norm == pytest.approx(float(posed.misfit(found.z)))


def test_cost_of_the_truth_is_zero_and_grows_away_from_it() -> None:
    truth = Truth(2e5, 0.3, 300.0, dispersive=False)
    posed = problem(truth)
    away = [envelope_cost(posed, truth.x + step) for step in ([0, 0], [0.1, 0], [0.2, 0], [0, 0.1])]
    scale = float(posed.data.envelope.sum())
    assert away[0] < 1e-4 * scale
    assert 0.01 * scale < away[1] < away[2]
    assert away[3] > 0.01 * scale


def test_the_residual_norm_is_the_distance_of_the_signals() -> None:
    # Parseval: what the optimiser sees in the band is the time-domain distance of model and measurement
    truth = Truth(2e5, 0.3, 300.0)
    posed = problem(truth)
    x = truth.x + np.array([0.1, 0.05])
    in_time = np.linalg.norm(posed.signal(x) - posed.data.top) / np.linalg.norm(posed.data.top)
    assert posed.misfit(x) == pytest.approx(in_time, rel=0.02)
