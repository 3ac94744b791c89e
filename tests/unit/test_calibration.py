"""Calibration of the two chains: a known ratio and shift come back, and leave corrected signals."""

import json

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.signals.bursts import hann_burst
from multilayer.signals.calibration import Calibration, calibrate
from multilayer.signals.recording import Recording
from multilayer.signals.time_of_flight import time_of_flight

RATE = 25600.0
BURSTS = [100.0, 400.0, 900.0, 1500.0]
RATIOS = [1.02, 1.01, 0.99, 0.97]
SHIFTS = [3e-6, 1.1e-6, -0.4e-6, -5e-6]


def recording(frequency, ratio, shift, noise=0.0, *, repeats=3, seed=0):
    rng = np.random.default_rng(seed)
    n_samples = int(0.16 * RATE)
    base = hann_burst(frequency, 10, RATE, n_samples=n_samples, start=0.01)
    top = ratio * hann_burst(frequency, 10, RATE, n_samples=n_samples, start=0.01 + shift)
    channels = (signal + noise * rng.normal(size=(repeats, n_samples)) for signal in (base, top))
    return Recording(*channels, RATE)


def recordings(noise=0.0, **options):
    return {
        f: recording(f, ratio, shift, noise, seed=i, **options)
        for i, (f, ratio, shift) in enumerate(zip(BURSTS, RATIOS, SHIFTS, strict=True))
    }


def test_known_chains_come_back():
    found = calibrate(recordings())
    np.testing.assert_array_equal(found.frequencies, BURSTS)
    np.testing.assert_allclose(found.amplitude_ratio, RATIOS, rtol=1e-5)
    np.testing.assert_allclose(found.time_shift, SHIFTS, atol=1e-10)


def test_with_noise_within_its_reach():
    """Noise of 0.05 m/s2 on bursts of 5 m/s2 rms: the statistics of the fit, from many recordings."""
    fits = [calibrate({400.0: recording(400.0, 1.03, 4e-6, noise=0.05, seed=k)}) for k in range(40)]
    ratios = np.array([fit.amplitude_ratio[0] for fit in fits])
    shifts = np.array([fit.time_shift[0] for fit in fits])
    # noise of both channels over the burst's energy, averaged over three repeats
    energy = 5.0**2 * 10 / 400.0 * RATE
    expected = np.sqrt(2 / 3) * 0.05 / np.sqrt(energy)
    assert np.std(ratios) == pytest.approx(expected, rel=0.4)
    assert np.std(shifts) == pytest.approx(expected / (2 * np.pi * 400.0), rel=0.4)
    assert np.mean(ratios) == pytest.approx(1.03, abs=4 * expected / np.sqrt(40))
    assert np.mean(shifts) == pytest.approx(4e-6, abs=4 * expected / (2 * np.pi * 400.0 * np.sqrt(40)))


def test_noise_of_the_base_does_not_lower_the_ratio():
    """Plain least squares would lose the share of the noise in the base's energy: here 1.3 %."""
    fits = [calibrate({400.0: recording(400.0, 1.0, 0.0, 3.0, repeats=2, seed=k)}) for k in range(120)]
    ratios = np.array([fit.amplitude_ratio[0] for fit in fits])
    assert np.mean(ratios) == pytest.approx(1.0, abs=3.5 * np.std(ratios) / np.sqrt(120))
    assert 3.5 * np.std(ratios) / np.sqrt(120) < 0.01


def test_corrected_tops_equal_the_base():
    signals = recordings()
    calibration = calibrate(signals)
    for frequency, signal in signals.items():
        base, top = signal.mean()
        corrected = calibration.correct(top, RATE, frequency)
        np.testing.assert_allclose(corrected, base, atol=1e-3)
        assert np.abs(top - base).max() > 0.1
    assert calibration.correct(signals[400.0].top, RATE, 400.0).shape == signals[400.0].top.shape


def test_correction_is_a_fraction_of_a_sample_and_a_gain():
    calibration = Calibration(np.array([100.0, 200.0]), np.array([2.0, 2.0]), np.array([1e-5, 1e-5]))
    top = hann_burst(150.0, 10, RATE, n_samples=4000, start=0.02)
    corrected = calibration.correct(top, RATE, 150.0)
    assert time_of_flight(top, corrected, RATE) == pytest.approx(-1e-5, abs=1e-9)
    assert np.abs(corrected).max() == pytest.approx(np.abs(top).max() / 2, rel=1e-4)


def test_a_correction_does_not_wrap():
    """A top that still moves at the end of the record, to be delayed by 40 samples: its end is lost."""
    calibration = Calibration(np.array([100.0]), np.array([1.0]), np.array([-40 / RATE]))
    top = np.zeros(500)
    top[300:] = hann_burst(1000.0, 10, RATE, n_samples=200)
    assert np.abs(top[-40:]).max() > 1.0
    np.testing.assert_allclose(calibration.correct(top, RATE, 100.0)[:40], 0.0, atol=1e-9)


def test_between_bursts_it_interpolates_linearly():
    calibration = Calibration(np.array([300.0, 100.0]), np.array([1.2, 1.0]), np.array([2e-6, 0.0]))
    assert calibration.at(150.0) == pytest.approx((1.05, 0.5e-6))
    np.testing.assert_array_equal(calibration.frequencies, [100.0, 300.0])


@pytest.mark.parametrize("frequency", [99.0, 301.0])
def test_outside_it_refuses_and_says_the_range(frequency):
    calibration = Calibration(np.array([100.0, 300.0]), np.ones(2), np.zeros(2))
    with pytest.raises(InputError, match="outside of the calibrated range 100 Hz to 300 Hz"):
        calibration.correct(np.ones(10), RATE, frequency)


def test_json_and_back():
    calibration = calibrate(recordings())
    again = Calibration.from_dict(json.loads(json.dumps(calibration.to_dict())))
    for name in ("frequencies", "amplitude_ratio", "time_shift"):
        np.testing.assert_array_equal(getattr(again, name), getattr(calibration, name))


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"frequencies": [1.0]}, "lacks amplitude_ratio, time_shift"),
        ({"frequencies": [1.0], "amplitude_ratio": ["x"], "time_shift": [0.0]}, "lists of numbers"),
        ({"frequencies": [1.0, 2.0], "amplitude_ratio": [1.0], "time_shift": [0.0]}, "as many"),
        ({"frequencies": [], "amplitude_ratio": [], "time_shift": []}, "at least one"),
        ({"frequencies": [1.0], "amplitude_ratio": [0.0], "time_shift": [0.0]}, "above 0"),
        ({"frequencies": [1.0], "amplitude_ratio": [1.0], "time_shift": [float("nan")]}, "not finite"),
        ({"frequencies": [1, 1], "amplitude_ratio": [1, 1], "time_shift": [0, 0]}, "twice"),
    ],
)
def test_bad_calibrations_are_refused(data, message):
    with pytest.raises(InputError, match=message):
        Calibration.from_dict(data)


def test_no_bursts():
    with pytest.raises(InputError, match="at least one burst"):
        calibrate({})


def test_a_channel_of_the_wrong_sign():
    signal = recording(400.0, -1.0, 0.0)
    with pytest.raises(InputError, match=r"400 Hz shows no motion common .* of the same sign"):
        calibrate({400.0: signal})
