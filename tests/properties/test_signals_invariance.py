"""What a time of flight and an envelope must not care about."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multilayer.signals.bursts import hann_burst
from multilayer.signals.envelope import envelope
from multilayer.signals.time_of_flight import time_of_flight

RATE = 25600.0
N_SAMPLES = 4000

frequency = st.floats(100.0, 1500.0)
delay = st.floats(-60.0, 60.0)


def pair(f, shift):
    base = hann_burst(f, 10, RATE, n_samples=N_SAMPLES, start=0.02)
    return base, hann_burst(f, 10, RATE, n_samples=N_SAMPLES, start=0.02 + shift / RATE)


@settings(deadline=None, max_examples=60)
@given(frequency, delay)
def test_a_delay_is_found(f, shift):
    assert time_of_flight(*pair(f, shift), RATE) * RATE == pytest.approx(shift, abs=1e-3)


@settings(deadline=None, max_examples=60)
@given(frequency, st.integers(-40, 40), st.integers(0, 2**32 - 1))
def test_time_of_flight_follows_a_shift(f, shift, seed):
    base, top = pair(f, 3.7)
    top = top + 0.05 * np.random.default_rng(seed).normal(size=N_SAMPLES)
    top[:100] = top[-100:] = 0.0
    before = time_of_flight(base, top, RATE)
    assert time_of_flight(base, np.roll(top, shift), RATE) == pytest.approx(before + shift / RATE, abs=1e-9)


@settings(deadline=None, max_examples=60)
@given(frequency, delay, st.floats(1e-6, 1e6), st.floats(1e-6, 1e6))
def test_time_of_flight_ignores_gains(f, shift, a, b):
    base, top = pair(f, shift)
    reference = time_of_flight(base, top, RATE)
    assert time_of_flight(a * base, b * top, RATE) == pytest.approx(reference, abs=1e-12)


@settings(deadline=None, max_examples=60)
@given(frequency, delay)
def test_exchanged_channels_exchange_the_sign(f, shift):
    base, top = pair(f, shift)
    assert time_of_flight(top, base, RATE) == pytest.approx(-time_of_flight(base, top, RATE), abs=1e-9)


@settings(deadline=None, max_examples=60)
@given(frequency, st.floats(0.0, 2 * np.pi), st.floats(-1e3, 1e3))
def test_the_envelope_bounds_the_signal_and_ignores_its_sign(f, phase, gain):
    time = np.arange(N_SAMPLES) / RATE - 0.02
    shape = np.where((time > 0) & (time < 10 / f), np.sin(np.pi * time * f / 10) ** 2, 0.0)
    signal = gain * shape * np.cos(2 * np.pi * f * time + phase)
    found = envelope(signal)
    assert np.all(found >= np.abs(signal) - 1e-9 * abs(gain))
    np.testing.assert_allclose(found, envelope(-signal), rtol=0, atol=1e-12 * (1 + abs(gain)))
