"""Bursts found in long recordings, and cut out aligned."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from multilayer.errors import InputError
from multilayer.measurements.cutting import Window, cut_bursts
from multilayer.measurements.pairs import Pair
from multilayer.signals.bursts import hann_burst
from multilayer.signals.find_bursts import find_bursts, stated_frequency

RATE = 12800.0


def recording(bursts, length, *, noise=0.0, cycles=10.0, offset=0.0, seed=0):
    """Return a signal with a burst for each (onset in s, frequency, level)."""
    rng = np.random.default_rng(seed)
    n = int(length * RATE)
    signal = sum(hann_burst(f, cycles, RATE, level, n_samples=n, start=at) for at, f, level in bursts)
    return signal + noise * rng.standard_normal(n) + offset


def pair(base, top=None):
    return Pair(Path("run.tdms"), base, 2.0 * base if top is None else top, RATE)


class TestFind:
    def test_onset_and_frequency(self):
        bursts = [(0.1, 100, 5), (0.3, 437.5, 5), (0.5, 1500, 0.5)]
        found = find_bursts(recording(bursts, 0.8, noise=0.002, offset=3.0), RATE, 10)
        assert [one.onset / RATE for one in found] == pytest.approx([at for at, _, _ in bursts], abs=2e-5)
        assert [one.frequency for one in found] == pytest.approx([f for _, f, _ in bursts], rel=5e-4)
        assert all(one.fits(10) and not one.fits(5) for one in found)

    def test_in_noise_of_a_tenth(self):
        found = find_bursts(recording([(0.1, 100, 5), (0.4, 800, 5)], 0.7, noise=0.5), RATE, 10)
        found = [one for one in found if one.fits(10)]
        assert [one.frequency for one in found] == pytest.approx([100, 800], rel=3e-3)
        assert [one.onset / RATE for one in found] == pytest.approx([0.1, 0.4], abs=5e-4)

    def test_drift_and_knocks_are_no_bursts(self):
        signal = recording([(0.1, 200, 5), (0.4, 300, 5)], 0.8, noise=0.01)
        signal += 20 * np.linspace(-1, 1, signal.size) ** 2
        signal[int(0.3 * RATE)] += 40.0
        assert [one.frequency for one in find_bursts(signal, RATE, 10) if one.fits(10)] == pytest.approx(
            [200, 300], rel=2e-3
        )

    def test_across_the_blocks_of_a_long_recording(self):
        times = 0.05 + 0.4 * np.arange(150)
        steps = []
        signal = np.tile(recording([(0.05, 500, 5)], 0.4), 150)
        signal += 0.01 * np.random.default_rng(0).standard_normal(signal.size)
        found = find_bursts(signal, RATE, 10, lambda: steps.append(1))
        assert [one.onset / RATE for one in found] == pytest.approx(times, abs=1e-4)
        assert len(steps) == 3

    @pytest.mark.parametrize("signal", [np.zeros(5000), np.ones(5000), np.random.default_rng(0).normal(size=50000)])
    def test_nothing_where_nothing_is(self, signal):
        assert [one for one in find_bursts(signal, RATE, 10) if one.fits(10)] == []

    @settings(max_examples=25, deadline=None)
    @given(st.floats(60, 2000), st.floats(0.05, 0.2), st.floats(-3, 3), st.integers(0, 5))
    def test_anywhere_at_any_frequency_and_level(self, frequency, at, decade, seed):
        level = 10**decade
        signal = recording([(at, frequency, level)], at + 10 / frequency + 0.1, noise=1e-3 * level, seed=seed)
        (found,) = (one for one in find_bursts(signal, RATE, 10) if one.fits(10))
        assert found.frequency == pytest.approx(frequency, rel=2e-3)
        assert found.onset / RATE == pytest.approx(at, abs=0.02 * 10 / frequency)


class TestStatedFrequency:
    @pytest.mark.parametrize(
        ("found", "stated"),
        [(99.97, 100), (1001.5, 1000), (316.1, 315), (31.47, 31.5), (62.9, 63), (1247, 1250), (1587, 1590)],
    )
    def test_round_numbers(self, found, stated):
        assert stated_frequency(found) == stated

    def test_known_ones(self):
        assert stated_frequency(99.0, (98.7, 250.0)) == 98.7
        assert stated_frequency(150.0, (98.7, 250.0)) is None


class TestCut:
    def test_repeats_on_samples_are_cut_sample_for_sample(self):
        rng = np.random.default_rng(0)
        onsets = np.array([1000, 4000, 7003]) / RATE
        base = recording([(t, 300, 5) for t in onsets], 0.9, noise=0.005)
        top = rng.normal(size=base.size)
        (burst,) = cut_bursts([pair(base, top)], Window(10, 0.005, 0.05)).bursts
        assert (burst.frequency, burst.recording.n_repeats) == (300, 3)
        first = 1000 - 64
        for k, shift in enumerate((0, 3000, 6003)):
            start, n = first + shift, burst.recording.n_samples
            np.testing.assert_array_equal(burst.recording.base[k], base[start : start + n])
            np.testing.assert_array_equal(burst.recording.top[k], top[start : start + n])
        assert n == int((0.005 + 10 / 300 + 0.05) * RATE)

    def test_repeats_between_samples_are_shifted(self):
        """Clocks of their own: what is left of the repeats' differences is below 0.3 % of the crest."""
        onsets = [0.1, 0.3 + 0.37 / RATE, 0.5 - 0.41 / RATE]
        base = recording([(t, 1000, 5) for t in onsets], 0.7)
        (burst,) = cut_bursts([pair(base)], Window(10)).bursts
        spread = np.ptp(burst.recording.base, axis=0).max()
        assert spread < 3e-3 * np.abs(base).max()
        np.testing.assert_allclose(burst.recording.top, 2 * burst.recording.base, atol=1e-9)

    def test_repeats_of_several_files_and_frequencies_in_any_order(self):
        one = pair(recording([(0.1, 500, 5), (0.2, 200, 5), (0.35, 500, 5)], 0.5))
        two = pair(recording([(0.1, 200, 5), (0.2, 350, 5)], 0.5))
        found = cut_bursts([one, two], Window(10)).bursts
        assert [(b.frequency, b.recording.n_repeats) for b in found] == [(200, 2), (350, 1), (500, 2)]

    def test_the_ring_down_decides_the_length(self):
        base = recording([(0.1, 500, 5)], 3.0, noise=1e-4)
        ring = np.zeros(base.size)
        start = int(0.11 * RATE)
        time = np.arange(base.size - start) / RATE
        ring[start:] = 10 * np.exp(-time / 0.05) * np.sin(2 * np.pi * 300 * time)
        (soft,) = cut_bursts([pair(base, ring)], Window(10)).bursts
        (stiff,) = cut_bursts([pair(base)], Window(10)).bursts
        assert soft.recording.n_samples / RATE == pytest.approx(0.005 + 0.01 + 0.05 * np.log(1e3), rel=0.1)
        assert stiff.recording.n_samples / RATE == pytest.approx(0.005 + 0.02 + 0.04, rel=0.01)

    @pytest.mark.parametrize("seed", range(5))
    def test_a_cut_ends_in_the_noise(self, seed):
        """Of thousands of samples of noise some stand out: they make no ring-down."""
        base = recording([(0.1, 500, 5)], 3.0, noise=1e-3, seed=seed)
        time = np.arange(base.size) / RATE - 0.11
        ring = np.where(time > 0, 10 * np.exp(-np.maximum(time, 0) / 0.05) * np.sin(2 * np.pi * 300 * time), 0.0)
        noise = 0.05
        top = ring + noise * np.random.default_rng(seed + 10).normal(size=base.size)
        (burst,) = cut_bursts([pair(base, top)], Window(10)).bursts
        assert burst.recording.n_samples / RATE == pytest.approx(0.005 + 0.01 + 0.05 * np.log(10 / noise), rel=0.25)

    def test_cut_off_at_the_ends_of_the_file(self):
        base = recording([(-0.02, 200, 5), (0.2, 200, 5), (0.48, 200, 5)], 0.5)
        result = cut_bursts([pair(base)], Window(10))
        assert [b.recording.n_repeats for b in result.bursts] == [1]

    def test_other_cycles_are_told(self):
        with pytest.raises(InputError, match=r"no burst of 10 cycles .*--cycles.* What stands out: .* has 5 cycles"):
            cut_bursts([pair(recording([(0.1, 300, 5)], 0.4, cycles=5))], Window(10))

    def test_more_time_than_there_is(self):
        base = recording([(0.1, 300, 5), (0.15, 300, 5)], 0.4)
        with pytest.raises(InputError, match=r"--after: 0.2 s are not there: there are only 0.016.* s in every repeat"):
            cut_bursts([pair(base)], Window(10, None, 0.2))

    def test_a_choice_of_frequencies(self):
        result = cut_bursts([pair(recording([(0.1, 300, 5), (0.2, 500, 5)], 0.4))], Window(10), (301.0,))
        assert [b.frequency for b in result.bursts] == [301]
        assert result.left_out == ("run.tdms, 0.200 s: what is found at 500 Hz is none of the frequencies given",)

    def test_known_frequencies_nearer_than_a_per_cent_stay_apart(self):
        close = (1000.0, 1008.0, 1016.0, 1024.0, 1032.0)
        one = pair(recording([(0.1 * (k + 1), f, 5) for k, f in enumerate(close)], 0.7))
        result = cut_bursts([one, one], Window(10), close)
        assert [(b.frequency, b.recording.n_repeats) for b in result.bursts] == [(f, 2) for f in close]
        with pytest.raises(InputError, match=r"10 bursts are found from 1000 to 1032 Hz.*played in --frequencies"):
            cut_bursts([one, one], Window(10))
