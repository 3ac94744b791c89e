"""Bursts, spectra, envelopes and times of flight against closed forms."""

import numpy as np
import pytest

from multilayer.signals.bursts import hann_burst
from multilayer.signals.envelope import analytic_signal, envelope, level_difference_db, rms
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import band, frequencies, noise_level, padded_length, to_signal, to_spectrum
from multilayer.signals.time_of_flight import time_of_flight

RATE = 25600.0
BURSTS = np.arange(100.0, 1501.0, 100.0)


def window(frequency, n_samples, start, cycles=10):
    time = np.arange(n_samples) / RATE - start
    duration = cycles / frequency
    inside = (time > 0) & (time < duration)
    return np.where(inside, np.sin(np.pi * time / duration) ** 2, 0.0)


class TestBurst:
    @pytest.mark.parametrize("frequency", [100.0, 730.0, 1500.0])
    def test_level_is_the_rms_over_the_bursts_own_duration(self, frequency):
        burst = hann_burst(frequency, 10, RATE, level_rms=5.0, n_samples=6000, start=0.013)
        assert np.sqrt(np.sum(burst**2) / (10 / frequency * RATE)) == pytest.approx(5.0, rel=1e-9)

    def test_peak_of_5_rms_is_11_5(self):
        assert np.max(np.abs(hann_burst(100.0, 10, RATE, level_rms=5.0))) == pytest.approx(11.5, abs=0.06)

    def test_it_is_zero_before_and_after(self):
        burst = hann_burst(200.0, 10, RATE, n_samples=3000, start=0.01)
        np.testing.assert_allclose(burst[:257], 0.0, atol=1e-15)
        np.testing.assert_allclose(burst[256 + 1280 :], 0.0, atol=1e-15)
        assert np.abs(burst[257:264]).min() > 1e-6

    def test_default_length_holds_the_longest_burst(self):
        bursts = hann_burst(np.array([100.0, 200.0]), 10, RATE, start=0.002)
        assert bursts.shape == (2, int(np.ceil(0.102 * RATE)) + 1)
        np.testing.assert_array_equal(bursts[1], hann_burst(200.0, 10, RATE, n_samples=2613, start=0.002))

    def test_the_level_scales_it(self):
        np.testing.assert_allclose(
            hann_burst(300.0, 10, RATE, level_rms=2.0), 0.4 * hann_burst(300.0, 10, RATE, level_rms=5.0)
        )


class TestSpectra:
    @pytest.mark.parametrize(("n_samples", "factor"), [(1, 2), (1758, 2), (5683, 2), (5683, 4), (4099, 3)])
    def test_padded_length(self, n_samples, factor):
        length = padded_length(n_samples, factor)
        assert factor * n_samples <= length < 1.1 * factor * n_samples + 8

    def test_a_delay_turns_the_phase_backwards(self):
        burst = hann_burst(500.0, 10, RATE, n_samples=3000, start=0.005)
        late = hann_burst(500.0, 10, RATE, n_samples=3000, start=0.005 + 0.0003)
        n_fft = padded_length(3000)
        f = frequencies(n_fft, RATE)
        inside = band(to_spectrum(burst, n_fft), 0.05)
        turned = to_spectrum(burst, n_fft) * np.exp(-2j * np.pi * f * 0.0003)
        np.testing.assert_allclose(to_spectrum(late, n_fft)[inside], turned[inside], rtol=1e-6)

    @pytest.mark.parametrize("n_fft", [400, 401])
    def test_there_and_back(self, n_fft):
        signal = np.random.default_rng(0).normal(size=(2, 3, 400))
        back = to_signal(to_spectrum(signal, n_fft), n_fft, 400)
        np.testing.assert_allclose(back, signal, atol=1e-13)
        assert to_spectrum(signal, n_fft).shape == (2, 3, frequencies(n_fft, RATE).size)

    def test_a_transform_never_cuts_a_record(self):
        with pytest.raises(ValueError, match="cuts a record of 400"):
            to_spectrum(np.zeros(400), 399)

    def test_a_cosine_stands_in_its_bin(self):
        signal = np.cos(2 * np.pi * 400.0 * np.arange(256) / RATE)
        spectrum = to_spectrum(signal, 256)
        assert frequencies(256, RATE)[np.argmax(np.abs(spectrum))] == pytest.approx(400.0)

    def test_a_long_ring_down_does_not_wrap(self):
        """A resonance that rings past the record's end; the exact answer by recursion."""
        burst = hann_burst(500.0, 10, RATE, n_samples=1024, start=0.004)
        pole = np.exp((-30.0 + 2j * np.pi * 520.0) / RATE)
        exact = np.zeros(1024, dtype=complex)
        state = 0j
        for k, sample in enumerate(burst):
            state = pole * state + sample
            exact[k] = state
        assert np.abs(exact[-1]) > 0.2 * np.abs(exact).max()

        def filtered(n_fft):
            z = np.exp(2j * np.pi * np.arange(n_fft // 2 + 1) / n_fft)
            # the real part of a one-pole filter's output: half of the pole and half of its conjugate
            response = 0.5 / (1 - pole / z) + 0.5 / (1 - np.conj(pole) / z)
            return to_signal(response * to_spectrum(burst, n_fft), n_fft, 1024)

        before = slice(0, 100)  # the burst begins at sample 102
        padded = filtered(padded_length(1024, 8))
        assert np.abs(filtered(1024)[before]).max() > 0.1 * np.abs(exact).max()
        assert np.abs(padded[before]).max() < 1e-3 * np.abs(exact).max()
        np.testing.assert_allclose(padded, exact.real, atol=1e-3 * np.abs(exact).max())

    def test_the_band_holds_the_burst(self):
        n_fft = padded_length(5000)
        burst = hann_burst(BURSTS, 10, RATE, n_samples=5000, start=0.01)
        spectrum, f = to_spectrum(burst, n_fft), frequencies(n_fft, RATE)
        mask = band(spectrum, 0.1)
        assert mask.shape == spectrum.shape
        for frequency, row in zip(BURSTS, mask, strict=True):
            # the main lobe of a Hann window reaches 2 / duration to either side
            assert 0.8 * frequency < f[row].min() < frequency < f[row].max() < 1.2 * frequency
        energy = np.sum(np.abs(spectrum) ** 2 * mask, axis=-1) / np.sum(np.abs(spectrum) ** 2, axis=-1)
        assert np.all(energy > 0.99)

    def test_silence_has_no_band(self):
        assert not band(np.zeros(10), 0.1).any()


class TestNoise:
    @staticmethod
    def noisy(repeats, seed=0, noise=(0.02, 0.005)):
        rng = np.random.default_rng(seed)
        burst = hann_burst(400.0, 10, RATE, n_samples=4000, start=0.002)
        base, top = (burst + level * rng.normal(size=(repeats, 4000)) for level in noise)
        return Recording(base, top, RATE)

    @pytest.mark.parametrize(("repeats", "tolerance"), [(1, 0.15), (2, 0.05), (3, 0.05), (10, 0.03)])
    def test_known_noise_is_found(self, repeats, tolerance):
        level = noise_level(self.noisy(repeats))
        assert level.base == pytest.approx(0.02, rel=tolerance)
        assert level.top == pytest.approx(0.005, rel=tolerance)

    def test_two_repeats_are_unbiased(self):
        """Dividing by n in place of n - 1 would give 0.71 of it."""
        squares = [noise_level(self.noisy(2, seed)).base ** 2 for seed in range(20)]
        assert np.mean(squares) == pytest.approx(0.02**2, rel=0.02)

    def test_the_mean_has_less(self):
        recording = self.noisy(4)
        assert noise_level(recording, of_mean=True).base == pytest.approx(noise_level(recording).base / 2)
        mean, burst = recording.mean()[0], hann_burst(400.0, 10, RATE, n_samples=4000, start=0.002)
        assert np.std(mean - burst) == pytest.approx(0.01, rel=0.05)

    def test_neither_ring_down_nor_spikes_count_as_noise(self):
        recording = self.noisy(1)
        time = np.arange(4000) / RATE
        top = recording.top + 0.05 * np.sin(2 * np.pi * 120.0 * time)
        top[:, -50] += 3.0
        assert noise_level(Recording(recording.base, top, RATE)).top == pytest.approx(0.005, rel=0.2)


class TestEnvelope:
    @pytest.mark.parametrize("frequency", BURSTS)
    def test_of_a_hann_burst_is_the_window(self, frequency):
        burst = hann_burst(frequency, 10, RATE, level_rms=np.sqrt(3 / 16), n_samples=4000, start=0.0123)
        np.testing.assert_allclose(envelope(burst), window(frequency, 4000, 0.0123), atol=5e-4)

    def test_broadcasts(self):
        burst = hann_burst(BURSTS, 10, RATE, n_samples=4000)
        assert envelope(burst).shape == (15, 4000)
        np.testing.assert_allclose(envelope(burst)[3], envelope(burst[3]), atol=1e-12)

    @pytest.mark.parametrize("n_samples", [999, 1000])
    def test_real_part_is_the_signal(self, n_samples):
        signal = np.random.default_rng(1).normal(size=n_samples)
        np.testing.assert_allclose(analytic_signal(signal).real, signal, atol=1e-12)

    def test_the_hilbert_transform_of_a_cosine_burst_is_the_sine_burst(self):
        time = np.arange(4000) / RATE - 0.02
        shape = window(500.0, 4000, 0.02)
        cosine, sine = shape * np.cos(2 * np.pi * 500.0 * time), shape * np.sin(2 * np.pi * 500.0 * time)
        np.testing.assert_allclose(analytic_signal(cosine).imag, sine, atol=1e-3)

    def test_the_end_of_the_record_does_not_reach_its_beginning(self):
        late = np.zeros(1000)
        late[700:] = hann_burst(1000.0, 10, RATE, n_samples=300, start=100 / RATE)
        assert np.abs(late[-1]) > 1.0
        without_padding = np.abs(np.fft.ifft(np.fft.fft(late) * np.r_[1, np.full(499, 2), 1, np.zeros(499)]))
        assert envelope(late)[:5].max() < 0.02 * without_padding[:5].max()

    def test_levels(self):
        signal = np.random.default_rng(2).normal(size=(4, 500))
        np.testing.assert_allclose(rms(signal), np.sqrt((signal**2).mean(axis=-1)))
        np.testing.assert_allclose(level_difference_db(2 * signal, signal), 20 * np.log10(2.0))
        assert level_difference_db(np.zeros(5), np.ones(5)) == -np.inf


class TestTimeOfFlight:
    @pytest.mark.parametrize("delay", [-40.6, -0.5, 0.0, 0.3, 0.5, 0.49999, 7.25, 31.9])
    def test_delayed_bursts(self, delay):
        base = hann_burst(BURSTS, 10, RATE, n_samples=6000, start=0.02)
        top = -0.3 * -hann_burst(BURSTS, 10, RATE, n_samples=6000, start=0.02 + delay / RATE)
        found = time_of_flight(base, top, RATE) * RATE
        assert found.shape == (15,)
        np.testing.assert_allclose(found, delay, atol=1e-6)
        whole = time_of_flight(base, top, RATE, subsample=False) * RATE
        np.testing.assert_allclose(whole, np.round(whole), atol=1e-12)
        assert np.all(np.abs(whole - delay) <= 0.5 + 1e-9)

    def test_at_few_samples_per_period_the_right_period_wins(self):
        """At 5 samples per period the samples straddle the crests: the largest sample may be next door."""
        for delay in np.linspace(0, 3, 31):
            base = hann_burst(RATE / 5.1, 30, RATE, n_samples=1000, start=0.005)
            top = hann_burst(RATE / 5.1, 30, RATE, n_samples=1000, start=0.005 + delay / RATE)
            assert time_of_flight(base, top, RATE) * RATE == pytest.approx(delay, abs=1e-3)

    def test_noise_moves_it_little(self):
        rng = np.random.default_rng(3)
        base = hann_burst(300.0, 10, RATE, n_samples=4000, start=0.01)
        top = hann_burst(300.0, 10, RATE, n_samples=4000, start=0.01 + 2.3 / RATE)
        top = top + 0.1 * rng.normal(size=(50, 4000))
        found = time_of_flight(base, top, RATE) * RATE
        # Cramer-Rao: sigma / sqrt(sum (dx/dt)^2)
        bound = 0.1 / np.sqrt(np.sum(np.gradient(base) ** 2))
        assert np.std(found) == pytest.approx(bound, rel=0.3)
        assert np.mean(found) == pytest.approx(2.3, abs=5 * bound / np.sqrt(50))

    def test_base_broadcasts_against_tops(self):
        base = hann_burst(300.0, 10, RATE, n_samples=4000, start=0.01)
        tops = np.stack([np.roll(base, k) for k in range(6)]).reshape(2, 3, -1)
        np.testing.assert_allclose(time_of_flight(base, tops, RATE) * RATE, np.arange(6.0).reshape(2, 3), atol=1e-9)

    def test_an_inverted_top_shows_half_a_period(self):
        base = hann_burst(400.0, 10, RATE, n_samples=4000, start=0.02)
        assert abs(time_of_flight(base, -base, RATE)) == pytest.approx(0.5 / 400.0, rel=0.01)

    def test_silence_has_no_delay(self):
        base = hann_burst(400.0, 10, RATE, n_samples=1000)
        assert time_of_flight(base, np.zeros(1000), RATE) == 0.0
        assert time_of_flight(base, np.zeros(1000), RATE, subsample=False) == 0.0

    def test_unlike_records_are_refused(self):
        with pytest.raises(ValueError, match="base has 10 samples, top 11"):
            time_of_flight(np.ones(10), np.ones(11), RATE)
