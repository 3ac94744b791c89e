"""Whether the top plate moves before the base does: against the quiet ahead of the burst, however long."""

import numpy as np
import pytest

from multilayer.experiments.two_plate.burst import BurstData
from multilayer.signals.bursts import hann_burst
from multilayer.signals.spectra import Noise

RATE, F = 25600.0, 400.0


def burst(*, lead, tail=0.2, before=0.0, noise=0.0):
    """Return a burst whose top moves with an amplitude of `before` times its crest from the start on."""
    n = int((lead + 10 / F + tail) * RATE)
    base = hann_burst(F, 10, RATE, n_samples=n, start=lead)
    rng = np.random.default_rng(1)
    time = np.arange(n) / RATE
    top = 2 * base + before * 2 * np.abs(base).max() * np.sin(2 * np.pi * 300 * time) * (time < lead)
    signals = [signal + noise * np.abs(base).max() * rng.normal(size=n) for signal in (base, top)]
    level = noise * np.abs(base).max()
    return BurstData("", F, RATE, *signals, Noise(level, level))


@pytest.mark.parametrize("lead", [0.002, 0.005, 0.05])
@pytest.mark.parametrize("tail", [0.02, 2.0])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_at_rest(lead, tail, noise):
    assert burst(lead=lead, tail=tail, noise=noise).head_start < 0.02


@pytest.mark.parametrize("lead", [0.01, 0.05])
@pytest.mark.parametrize("tail", [0.02, 2.0])
@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_it_still_rings(lead, tail, noise):
    assert burst(lead=lead, tail=tail, before=0.15, noise=noise).head_start == pytest.approx(0.15, abs=0.03)


def test_without_a_lead_nothing_can_be_said():
    assert burst(lead=0.0).head_start == 0
