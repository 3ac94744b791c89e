"""Repeats in which a channel failed are refused; those of samples that drift are told, or left alone."""

import numpy as np
import pytest

from multilayer.rig.bench import Bench
from multilayer.rig.synthesis import make_campaign
from multilayer.signals.quality import check_recording
from multilayer.signals.recording import Recording
from multilayer.signals.repeats import compare_repeats, in_words
from tests.rig.virtual import rig_file, rod
from tests.unit.test_signals_quality import BURSTS, RATE, recording


def spoiled(sound, change, which, channel="top"):
    """Return the recording with some repeats of one channel changed."""
    signals = {"base": sound.base.copy(), "top": sound.top.copy()}
    signals[channel][which] = change(signals[channel][which])
    return Recording(signals["base"], signals["top"], RATE)


def dead(signal):
    return 0.004 * signal.std() * np.random.default_rng(1).normal(size=signal.shape)


@pytest.mark.parametrize("frequency", BURSTS)
@pytest.mark.parametrize(
    ("change", "channel"),
    [
        (dead, "top"), (dead, "base"), (np.zeros_like, "top"), (np.zeros_like, "base"), (lambda x: -x, "top"),
        (lambda x: x / 2, "top"), (lambda x: 10**0.5 * x, "base"), (lambda x: 10 * x, "top"),
    ],
    ids=["noise", "noise of base", "zeros", "zeros of base", "sign", "half", "base 10 dB", "20 dB"],
)  # fmt: skip
@pytest.mark.parametrize("repeats", [3, 10])
def test_a_failed_repeat_is_refused(frequency, change, channel, repeats):
    bad = spoiled(recording(frequency, repeats=repeats), change, slice(1, 2), channel)
    (problem,) = check_recording(bad, frequency)
    assert problem.startswith(f"repeat 2 of {repeats} differs from the others in top over base ")
    assert "leave that out, or measure the burst again" in problem


@pytest.mark.parametrize("frequency", [300.0, 800.0])
def test_a_channel_that_fails_within_the_burst_is_refused(frequency):
    sound = recording(frequency, repeats=3)
    after = np.arange(sound.n_samples) > int((0.002 + 4 / frequency) * RATE)
    (problem,) = check_recording(spoiled(sound, lambda x: np.where(after, 0.0, x), 2), frequency)
    assert problem.startswith("repeat 3 of 3 differs from the others in top over base by a factor of 0.")


@pytest.mark.parametrize("which", [0, 1])
def test_of_two_nobody_knows_which(which):
    (problem,) = check_recording(spoiled(recording(400.0), lambda x: x / 2, which), 400.0)
    assert problem.startswith("its two repeats differ in top over base by a factor of 0.5: a channel failed")
    assert "nothing tells in which of them" in problem
    (problem,) = check_recording(spoiled(recording(400.0, repeats=4), lambda x: x / 2, [which, which + 2]), 400.0)
    assert "of 4 differ from the others" in problem
    assert "nothing tells in which of them" in problem


@pytest.mark.parametrize("noise", [0.004, 0.05, 0.3])
@pytest.mark.parametrize("repeats", [2, 3, 10])
@pytest.mark.parametrize("frequency", BURSTS)
def test_noise_and_a_source_that_varies_are_left_alone(noise, repeats, frequency):
    sound = recording(frequency, noise=noise, repeats=repeats)
    level = np.linspace(0.3, 2, repeats)[:, None]
    apart = compare_repeats(Recording(level * sound.base, level * sound.top, RATE), frequency, 10)
    assert not apart.is_broken.any()
    assert apart.largest == 0


def test_a_single_repeat_has_nothing_to_differ_from():
    assert compare_repeats(recording(400.0, repeats=1), 400.0, 10) is None


def test_a_smaller_difference_is_told():
    apart = compare_repeats(spoiled(recording(300.0, repeats=3), lambda x: 0.8 * x, 2), 300.0, 10)
    assert not apart.is_broken.any()
    (text,) = in_words({"a.npz": apart, "b.npz": None})
    assert text.startswith("repeats differ in top over base in 1 of 2 recordings, beyond their noise: up to 20 % ")
    assert "(repeat 3, a.npz)" in text


@pytest.mark.parametrize(
    ("effects", "changes"),
    [
        ([{"effect": "creep", "rate": 0.2}], {}),
        ([{"effect": "temperature_drift", "total": -0.3}], {"remount": {"gain": 0.01, "stiffness": 0.02}}),
        ([{"effect": "temperature_drift", "total": 0.3}], {"remount": {"gain": 0.05, "stiffness": 0.05}}),
    ],
    ids=["creep", "cooling", "warming"],
)
@pytest.mark.parametrize("repeats", [2, 3, 5])
def test_a_sample_that_drifts_is_no_failure(monkeypatch, effects, changes, repeats):
    monkeypatch.setattr(Bench, "_transmissibility", rod)
    bursts = [100.0, 150.0, 200.0, 250.0, 300.0, 400.0, 600.0, 900.0, 1500.0]
    law = {"law": "loss_factor", "young_modulus": 2e5, "loss_factor": 0.1}
    specimen = {"density": 80.0, "poisson_ratio": 0.3, "young_modulus": law}
    settings = rig_file(*effects, specimen=specimen, frequencies=bursts, repeats=repeats, **changes)
    largest = 0.0
    for (_, frequency), made in make_campaign(settings).recordings.items():
        apart = compare_repeats(made, frequency, 10)
        assert not apart.is_broken.any(), (frequency, apart)
        largest = max(largest, apart.largest)
    assert largest > (0.1 if changes else 0.05)  # near the resonance, so that the check had something to spare
