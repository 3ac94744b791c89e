"""Several solutions that fit alike: found, listed, and never chosen in silence."""

import numpy as np
import pytest

from multilayer.fits.burst.branches import Candidates, choose_branches, find_candidates
from multilayer.fits.burst.fit import fit_bursts, search_bounds
from multilayer.fits.settings import FitSettings
from multilayer.inference.problem import Minimum
from multilayer.measurements.description import Campaign
from multilayer.signals.recording import Recording
from tests.fits.synthetic import FS, Truth, burst, campaign_dict, problem, rig

BOUNDS = search_bounds(FitSettings())


def _candidates(*points: tuple[float, float, float], plausible: int) -> Candidates:
    minima = [Minimum(np.array([np.log(e1), eta]), np.array([norm]), np.zeros((1, 2))) for e1, eta, norm in points]
    return Candidates(minima, plausible)


def test_neighbours_decide_between_equals() -> None:
    sure = _candidates((1e5, 0.2, 0.01), plausible=1)
    torn = _candidates((4e5, 0.5, 0.020), (1.1e5, 0.2, 0.021), plausible=2)
    first, second, third = choose_branches([100.0, 200.0, 300.0], [sure, torn, sure])
    assert not first.by_neighbours
    assert second.by_neighbours
    assert second.minimum is torn.minima[1]
    assert third.minimum is sure.minima[0]


def test_without_a_sure_neighbour_nothing_is_decided() -> None:
    torn = _candidates((4e5, 0.5, 0.020), (1.1e5, 0.2, 0.021), plausible=2)
    assert all(choice.unresolved for choice in choose_branches([100.0, 200.0], [torn, torn]))


# a burst of the thick soft sample far above its resonance, buried in noise: the shape of the burst no longer tells
# which number of wavelengths the sample holds
TORN = Truth(3e4, 0.15, 1500.0, noise=4.0, seed=3)


def test_noise_leaves_several_branches_open() -> None:
    found = find_candidates(problem(TORN), *BOUNDS)
    assert found.plausible >= 2
    assert min(abs(m.z[0] - TORN.x[0]) for m in found.minima[: found.plausible]) < 0.3


def _fit(truths: list[Truth]):
    campaign = Campaign.model_validate(campaign_dict(frequencies_hz=tuple(t.frequency for t in truths)))
    model = rig()
    data = {t.frequency: burst(t, model) for t in truths}
    recordings = {("one", f): Recording(d.base, d.top, FS) for f, d in data.items()}
    return fit_bursts(campaign, recordings, FitSettings()).bursts


def test_a_torn_burst_alone_is_not_accepted() -> None:
    (only,) = _fit([TORN])
    assert not only.accepted
    assert "several solutions fit alike" in only.reason


def test_a_torn_burst_among_clear_ones_says_so() -> None:
    clear = [Truth(3e4, 0.15, f, noise=0.002, seed=int(f)) for f in (400.0, 900.0)]
    *_, torn = _fit([*clear, TORN])
    assert any("the other bursts decided" in note for note in torn.notes)
    assert np.log(torn.optimum.storage_modulus) == pytest.approx(TORN.x[0], abs=0.3)
