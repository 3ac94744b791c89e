"""Noise of the virtual channels: levels, colours, hum, and the steps of a converter."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from multilayer.rig.noise import HEADROOM, Hum, NoiseSettings, add_noise, converted, hum, pink_noise, quantise

RATE = 25600.0


def rng():
    return np.random.default_rng(3)


def test_white_noise_has_its_level():
    noise = add_noise(np.zeros((4, 50_000)), 2.0, NoiseSettings(), 0.004, RATE, rng())
    assert noise.std() == pytest.approx(0.008, rel=0.01)
    assert np.abs(np.corrcoef(noise)[np.triu_indices(4, 1)]).max() < 0.02


def test_pink_noise_has_its_level_and_falls_by_3_db_an_octave():
    noise = pink_noise((200, 4096), rng())
    assert noise.std() == pytest.approx(1.0, rel=0.01)
    power = np.mean(np.abs(np.fft.rfft(noise)) ** 2, axis=0)
    bins = np.arange(1, 2000)
    slope = np.polyfit(np.log(bins), np.log(power[bins]), 1)[0]
    assert slope == pytest.approx(-1.0, abs=0.01)
    assert power[0] < 1e-12 * power[1]


@pytest.mark.parametrize("n_samples", [2, 3, 999, 1000])
def test_pink_noise_of_any_length(n_samples):
    many = pink_noise((3000, n_samples), rng())
    assert many.shape == (3000, n_samples)
    assert many.std() == pytest.approx(1.0, rel=0.05)


def test_hum_has_its_level_and_harmonics():
    settings = Hum(frequency=50.0, level=0.02, harmonics=3)
    signal = hum(settings, (5, int(RATE)), RATE, rng())  # one second: bins of 1 Hz
    lines = np.abs(np.fft.rfft(signal)) * 2 / RATE / np.sqrt(2)
    for order in (1, 2, 3):
        assert lines[:, 50 * order] == pytest.approx(0.02 / order, rel=1e-6)
    phases = np.angle(np.fft.rfft(signal)[:, 50])
    assert len(set(np.round(phases, 3))) == 5


def test_hum_beyond_half_the_rate_is_left_out():
    settings = Hum(frequency=50.0, level=0.02, harmonics=10)
    low = hum(settings, (1, 1000), 220.0, rng())
    assert np.max(np.abs(low)) <= 0.02 * np.sqrt(2) * (1 + 1 / 2)


def test_one_level_more_changes_no_other_noise():
    """So that a campaign can be made again with less noise, or with hum."""
    quiet = add_noise(np.zeros((2, 500)), 1.0, NoiseSettings(), 0.001, RATE, rng())
    loud = add_noise(np.zeros((2, 500)), 1.0, NoiseSettings(hum=Hum(level=1.0)), 0.004, RATE, rng())
    assert np.corrcoef(np.diff(quiet[0]), np.diff(loud[0]))[0, 1] < 1.0
    scaled = add_noise(np.zeros((2, 500)), 1.0, NoiseSettings(), 0.004, RATE, rng())
    assert np.allclose(scaled, 4 * quiet)
    assert np.allclose(loud - scaled, hum(Hum(level=1.0), (2, 500), RATE, _after_noise((2, 500))))


def _after_noise(shape):
    generator = rng()
    generator.standard_normal(shape)
    pink_noise(shape, generator)
    return generator


class TestConverter:
    @given(st.floats(-10, 10), st.integers(4, 24))
    def test_error_is_half_a_step_at_most(self, value, bits):
        step = 2 * 12.0 / 2**bits
        found = float(quantise(np.array(value), bits, 12.0))
        assert abs(found - value) <= 0.5 * step * (1 + 1e-9)
        assert found / step == pytest.approx(round(found / step), abs=1e-6)

    def test_range_ends(self):
        assert quantise(np.array([-50.0, 50.0]), 4, 8.0).tolist() == [-8.0, 7.0]

    def test_sets_its_own_range(self):
        signal = 3 * np.sin(np.arange(1000) / 7)
        found = converted(signal, NoiseSettings(bits=8))
        step = 2 * HEADROOM * np.abs(signal).max() / 2**8
        assert len(np.unique(found)) < 2**8
        assert np.abs(found - signal).max() <= 0.5 * step * (1 + 1e-9)

    def test_none(self):
        signal = np.linspace(-1, 1, 7)
        assert converted(signal, NoiseSettings(bits=None)) is signal
        assert not converted(np.zeros(4), NoiseSettings()).any()
