"""A recorder's clock that is off by some per mille is told; a shaker's response is none."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from multilayer.signals.bursts import hann_burst
from multilayer.signals.clock import clock_ratio, clocks_in_words, frequency_ratio
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum
from tests.unit.test_signals_quality import CAMPAIGNS, RATE, configuration, recording, shared_configurations


def resonance(frequency, loss):
    return lambda f: 1 / (1 - (f / frequency) ** 2 + 1j * loss * f / frequency)


RESPONSES = {
    "flat": np.ones_like,
    "6 dB per octave": lambda f: 1j * f,
    "12 dB per octave": lambda f: -(f**2),
    "suspension": lambda f: f**2 * resonance(60.0, 0.3)(f),
    "resonance above": resonance(2500.0, 0.05),
    "resonance among them": resonance(700.0, 0.1),
    "resonance at the last": resonance(1550.0, 0.05),
}


def driven(response, factor=1.0, cycles=10.0):
    """Return bursts of a shaker with some response, stated at 1/factor of their frequencies."""
    rng, bursts = np.random.default_rng(3), {}
    for stated in np.arange(100.0, 1501.0, 200.0):
        n = int((0.005 + cycles / stated + 0.12) * RATE)
        n_fft = padded_length(n, 8)
        burst = hann_burst(factor * stated, cycles, RATE, n_samples=n, start=0.005)
        base = to_signal(to_spectrum(burst, n_fft) * response(frequencies(n_fft, RATE)), n_fft, n)
        base = base / base.std() + 0.004 * rng.normal(size=(2, n))
        bursts[float(stated)] = Recording(base, base, RATE)
    return bursts


@pytest.mark.parametrize("name", RESPONSES)
@pytest.mark.parametrize("cycles", [5.0, 10.0, 20.0])
def test_a_shakers_response_is_no_clock(name, cycles):
    assert clock_ratio(driven(RESPONSES[name], cycles=cycles), cycles) is None


@pytest.mark.parametrize("stated", [9.0, 9.7, 10.3, 11.0])
@pytest.mark.parametrize("name", ["flat", "12 dB per octave"])
def test_another_window_is_no_clock(name, stated):
    assert clock_ratio(driven(RESPONSES[name]), stated) is None


@pytest.mark.parametrize("name", ["flat", "6 dB per octave", "12 dB per octave", "suspension", "resonance at the last"])
@pytest.mark.parametrize("factor", [0.985, 0.997, 1.003, 1.018])
def test_a_clock_is_told_beside_a_shakers_response(name, factor):
    ratio = clock_ratio(driven(RESPONSES[name], factor), 10.0)
    assert ratio is not None
    assert ratio.value == pytest.approx(factor, abs=max(2e-4, 4 * ratio.deviation))


def test_the_deviation_is_that_of_the_noise():
    ratios = []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        burst = hann_burst(500.0, 10, RATE, n_samples=2000, start=0.01)
        noisy = burst + 0.2 * rng.normal(size=(2, burst.size))
        ratios.append(frequency_ratio(Recording(noisy, noisy, RATE), 500.0, 10.0))
    values, deviations = np.transpose(ratios)
    assert np.std(values) == pytest.approx(np.mean(deviations), rel=0.3)
    assert np.mean(values) == pytest.approx(1, abs=np.mean(deviations))


def test_single_frequencies_that_are_off_are_no_clock():
    """As of a generator whose table holds whole samples to a period."""
    bursts = configuration()
    nominal = {f * (1 + 0.005 * (-1) ** i): bursts[f] for i, f in enumerate(bursts)}
    assert clock_ratio(nominal, 10.0) is None


@pytest.mark.parametrize("n_samples", [1, 2, 30])
def test_records_that_are_too_short_do_not_tell(n_samples):
    sound = recording(500.0)
    short = Recording(sound.base[:, :n_samples], sound.top[:, :n_samples], RATE)
    assert frequency_ratio(short, 500.0, 10.0) is None


def test_one_sentence_for_configurations_with_the_same_clock():
    sound = configuration()
    off = {f: replace(s, sampling_rate=RATE / 1.01) for f, s in sound.items()}
    (text,) = clocks_in_words({"a": sound, "b": off, "c": off}, 10.0)
    assert text.startswith("the bursts of b, c appear at 0.9901 times their stated frequencies (standard error ")
    assert text.endswith("a sampling_rate of 25346.5 Hz right? 25600 Hz would fit")
    (text,) = clocks_in_words({"b": off}, 10.0)
    assert text.startswith("all bursts appear")
    assert clocks_in_words({"a": sound}, 10.0) == []


@pytest.mark.reference
@pytest.mark.skipif(not CAMPAIGNS.is_dir(), reason="../shared is absent")
@pytest.mark.parametrize("folder", shared_configurations(), ids=lambda path: Path(path).name)
def test_clocks_of_the_shared_campaigns(folder):
    from multilayer.measurements.campaign import load_campaign, load_recordings

    campaign = load_campaign(folder)
    recordings = load_recordings(campaign)
    by_configuration = {}
    for (name, frequency), of_this in recordings.items():
        by_configuration.setdefault(name, {})[frequency] = of_this
    assert clocks_in_words(by_configuration, campaign.burst.cycles) == []
