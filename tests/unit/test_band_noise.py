"""Noise that is not white is told, with the factor by which it is off; drifts and sources that vary are no noise."""

import numpy as np
import pytest
from scipy import signal

from multilayer.rig.bench import Bench
from multilayer.rig.noise import pink_noise
from multilayer.rig.synthesis import make_campaign
from multilayer.signals.band_noise import band_noise, in_words
from multilayer.signals.recording import Recording
from tests.rig.virtual import rig_file, rod
from tests.unit.test_signals_quality import BURSTS, RATE, recording


def white(shape, rng):
    return rng.normal(size=shape)


def low(shape, rng):
    """Return noise of unit variance below 500 Hz."""
    filtered = signal.sosfilt(signal.butter(4, 500.0, fs=RATE, output="sos"), rng.normal(size=shape), axis=-1)
    return filtered / filtered.std()


def noises(colour, repeats, level=0.01):
    """Return what is told of every burst, by its frequency."""
    told = {}
    for frequency in BURSTS:
        sound, rng = recording(frequency, noise=0.0, repeats=repeats), np.random.default_rng(int(frequency))
        base, top = (x + level * colour(x.shape, rng) for x in (sound.base, sound.top))
        told[f"{frequency:g} Hz"] = band_noise(Recording(base, top, RATE), frequency, 10)
    return told


@pytest.mark.parametrize("repeats", [2, 3, 10])
def test_white_noise_is_as_it_is_estimated(repeats):
    told = noises(white, repeats)
    factors = [noise.factor for noise in told.values() if noise is not None]
    assert len(factors) >= len(BURSTS) - 1
    assert np.mean(factors) == pytest.approx(1, abs=0.3)
    assert in_words(told) == []


@pytest.mark.parametrize("repeats", [2, 3, 10])
def test_noise_of_a_low_pass(repeats):
    """All below 500 of 12800 Hz: there 23 times what it is taken for (the filter's noise has a bandwidth of 513 Hz)."""
    told = noises(low, repeats)
    factors = [told[f"{f:g} Hz"].factor for f in (300.0, 400.0)]
    assert np.mean(factors) == pytest.approx(12800 / 513, rel=0.35)
    (text,) = in_words(told)
    assert text.startswith("noise is not white: within the bands of bursts its power is ")
    assert "times (at 1500 Hz) what it would be if all noise of a record were white" in text
    assert "standard deviations are off by up to the root of that" in text


def test_pink_noise():
    (text,) = in_words(noises(pink_noise, 3))
    assert "use a quieter amplifier" in text


def test_noise_beside_the_bursts():
    """Repeats at other levels: what both channels have in common is no noise, but in the estimate."""
    level = np.array([[0.9], [1.0], [1.1]])
    told = {}
    for frequency in BURSTS:
        sound = recording(frequency, repeats=3)
        told[f"{frequency:g} Hz"] = band_noise(Recording(level * sound.base, level * sound.top, RATE), frequency, 10)
    (text,) = in_words(told)
    assert "let repeats be alike in level" in text


def test_what_cannot_be_told():
    assert band_noise(recording(400.0, repeats=1), 400.0, 10) is None
    assert band_noise(recording(400.0, noise=0.0), 400.0, 10) is None
    assert in_words({"a": None}) == []


@pytest.mark.parametrize("white_noise", [0.001, 0.004, 0.03])
@pytest.mark.parametrize(
    ("effects", "changes"),
    [
        ([{"effect": "creep", "rate": 0.05}], {}),
        ([{"effect": "temperature_drift", "total": -0.2}], {"remount": {"gain": 0.01, "stiffness": 0.02}}),
        ([], {"remount": {"gain": 0.003, "stiffness": 0.01}}),
    ],
    ids=["creep", "drift", "remounted"],
)
def test_a_sample_that_drifts_is_no_noise(monkeypatch, effects, changes, white_noise):
    monkeypatch.setattr(Bench, "_transmissibility", rod)
    bursts = [100.0, 150.0, 200.0, 300.0, 400.0, 600.0, 900.0, 1500.0]
    made = make_campaign(
        rig_file(*effects, frequencies=bursts, repeats=3, noise={"white": white_noise, "bits": 24}, **changes)
    )
    assert in_words({f"{f:g} Hz": band_noise(one, f, 10) for (_, f), one in made.recordings.items()}) == []
