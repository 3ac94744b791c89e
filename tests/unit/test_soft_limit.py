"""Sensors that limit without flat tops are told by the harmonic that they add; shakers and samples are none."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.signals.exchange import SWAPPED, leading_channel
from multilayer.signals.quality import check_configuration, check_recording
from multilayer.signals.recording import Recording
from multilayer.signals.soft_limit import flattened, limits_in_words
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum
from tests.unit.test_signals_quality import BURSTS, RATE, configuration, recording


def limited(sound, channel, cube):
    """Return a recording whose channel reads x - c x^3, `cube` the share of its crest; noise as in both."""
    x = getattr(sound, channel)
    return replace(sound, **{channel: x - cube * x**3 / np.abs(x).max() ** 2})


def distorted(frequency, phase):
    """Return a recording of a shaker with a third harmonic of 2 %, of any phase, that the top answers."""
    sound = recording(frequency)
    n = sound.n_samples
    n_fft = padded_length(n, 4)
    f = frequencies(n_fft, RATE)
    cube = to_spectrum((sound.base / np.abs(sound.base).max()) ** 3, n_fft)
    third = 0.08 * np.abs(sound.base).max() * to_signal(np.exp(1j * phase) * cube * (f > 2 * frequency), n_fft, n)
    response = 1 / (1 - (f / 400.0) ** 2 + 0.2j * f / 400.0)
    return Recording(sound.base + third, sound.top + to_signal(response * to_spectrum(third, n_fft), n_fft, n), RATE)


@pytest.mark.parametrize("frequency", BURSTS)
@pytest.mark.parametrize("noise", [0.0, 0.004, 0.05])
@pytest.mark.parametrize("cycles", [4.0, 10.0, 10.5])
def test_sound_recordings_are_not_flattened(frequency, noise, cycles):
    assert not any(flat.share for flat in flattened(recording(frequency, noise=noise), frequency, cycles).values())


@pytest.mark.parametrize("channel", ["base", "top"])
@pytest.mark.parametrize("frequency", BURSTS)
@pytest.mark.parametrize("cube", [0.02, 0.1, 0.3])
def test_the_share_is_that_of_the_cube(channel, frequency, cube):
    of_both = flattened(limited(recording(frequency), channel, cube), frequency, 10.0)
    flat = of_both.pop(channel)
    assert flat.limits
    assert flat.share == pytest.approx(0.75 * cube, rel=0.5)  # the crest that remains is smaller
    assert not any(other.share for other in of_both.values())


def test_clipping_ahead_of_noise_is_told_as_well():
    """No equal samples are left, so `clipped_repeats` does not see it."""
    sound = recording(300.0)
    limit = 0.9 * np.abs(sound.base).max()
    rng = np.random.default_rng(2)
    clipped = np.clip(sound.base, -limit, limit) + 0.002 * rng.normal(size=sound.base.shape)
    bursts = {f"{i}.npz": (300.0, replace(sound, base=clipped)) for i in range(2)}
    (text,) = limits_in_words(bursts, 10.0)
    assert text.startswith("the base channel limits softly in 2 of 2 recordings: ")
    assert check_recording(replace(sound, base=clipped), 300.0) == []


def test_a_sensor_that_limits_is_told_once():
    sound = configuration()
    loud = {f"{f:g}.npz": (f, limited(s, "top", 0.2 if f in (300.0, 400.0, 500.0) else 0.0)) for f, s in sound.items()}
    (text,) = limits_in_words(loud, 10.0)
    assert text.startswith(
        "the top channel limits softly in 3 of 6 recordings: the third harmonic is that of flattened "
    )
    assert "% of the amplitude (" in text
    assert limits_in_words({name: (f, sound[f]) for name, (f, _) in loud.items()}, 10.0) == []


def test_a_shaker_with_harmonics_is_no_sensor_that_limits():
    phases = np.linspace(0, 2 * np.pi, len(BURSTS), endpoint=False)
    bursts = {f"{f:g}": (f, distorted(f, phase)) for f, phase in zip(BURSTS, phases, strict=True)}
    assert any(flat.share for f, burst in bursts.values() for flat in flattened(burst, f, 10.0).values())
    assert limits_in_words(bursts, 10.0) == []


def test_a_single_burst_may_be_so_by_chance():
    assert limits_in_words({"a": (300.0, limited(recording(300.0), "top", 0.2))}, 10.0) == []


def test_flattened_crests_do_not_exchange_channels():
    """The crests of a ring-down are flattened later than those of the base: the top seems to lead."""
    bursts = configuration(resonance=170.0, damping=0.03)
    loud = limited(bursts[100.0], "top", 0.3)
    assert leading_channel(loud, 100.0, 10) == SWAPPED
    assert check_configuration(bursts | {100.0: loud}) == []
