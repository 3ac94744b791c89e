"""A recording that is another's is told from its neighbours, whose bands overlap; what a sample may do is not."""

import numpy as np
import pytest

from multilayer.rig.bench import Bench
from multilayer.rig.synthesis import make_campaign
from multilayer.signals.exchange import SWAPPED, leading_channel
from multilayer.signals.neighbours import belongs_exchanged, departures, neighbours_in_words
from multilayer.signals.quality import check_configuration
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, to_signal, to_spectrum
from tests.rig.virtual import rig_file, rod
from tests.unit.test_signals_quality import RATE, recording

BURSTS = [300.0 + 50.0 * i for i in range(9)]


def configuration(**options):
    return {f: recording(f, **options) for f in BURSTS}


def told(recordings):
    return neighbours_in_words({"thin": {f"{f:.0f}.npz": (f, one) for f, one in recordings.items()}}, 10)


@pytest.mark.parametrize("noise", [0.0, 0.004, 0.1])
@pytest.mark.parametrize("damping", [0.01, 0.1])
def test_recordings_of_one_linear_sample_agree(noise, damping):
    found = departures(configuration(noise=noise, damping=damping), 10)
    assert set(found) == set(BURSTS)
    assert max(found.values()) < 0.01


@pytest.mark.parametrize("frequency", [BURSTS[0], BURSTS[4], BURSTS[-1]])
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_the_recording_of_another_sample_is_told(frequency, noise):
    (text,) = told(configuration(noise=noise) | {frequency: recording(frequency, noise=noise, resonance=450.0)})
    assert text.startswith(f"in configuration 'thin', top over base of {frequency:.0f}.npz (by ")


def test_two_of_them_side_by_side_are_told():
    others = {f: recording(f, resonance=500.0) for f in BURSTS[3:5]}
    (text,) = told(configuration() | others)
    assert "450.npz (by " in text
    assert "500.npz (by " in text


def test_a_gain_that_was_changed_for_one_burst_is_told():
    one = recording(500.0)
    (text,) = told(configuration() | {500.0: Recording(one.base, 1.1 * one.top, RATE)})
    assert "500.npz (by 9.5 %)" in text


def test_bursts_without_neighbours_are_not_compared():
    assert departures({f: recording(f) for f in (100.0, 300.0, 900.0, 2700.0)}, 10) == {}
    assert departures({f: recording(f) for f in (400.0, 420.0, 440.0)}, 10) == {}


@pytest.mark.parametrize(
    "effect",
    [
        {"effect": "temperature_drift", "total": -0.3},
        {"effect": "temperature_drift", "total": 0.5},
        {"effect": "creep", "rate": 0.2},
        {"effect": "amplitude_softening", "softening": 300.0},
        {"effect": "clock_skew"},
    ],
    ids=["cooling", "warming", "creep", "softening", "clock"],
)
def test_a_sample_that_changes_by_degrees_is_no_wrong_file(monkeypatch, effect):
    monkeypatch.setattr(Bench, "_transmissibility", rod)
    law = {"law": "loss_factor", "young_modulus": 2e5, "loss_factor": 0.1}
    specimen = {"density": 80.0, "poisson_ratio": 0.3, "young_modulus": law}
    settings = rig_file(effect, specimen=specimen, frequencies=BURSTS, repeats=3)
    made = make_campaign(settings).recordings
    recordings = {frequency: one for (_, frequency), one in made.items()}
    assert np.isfinite(list(departures(recordings, 10).values())).all()
    assert told(recordings) == []


def with_absorber(frequency):
    """Return a recording of a plate that carries 5 % of its mass on a spring with losses, tuned to 400 Hz."""
    sound, n_fft = recording(frequency, noise=0.0), 2**15
    ratio, tuned = (frequencies(n_fft, RATE) / resonance for resonance in (200.0, 400.0))
    spring = 1 + 0.1j
    inertia = ratio**2 * (1 + 0.05 * spring / (spring - tuned**2))
    base = np.pad(sound.base[:1], ((0, 0), (0, 9000 - sound.n_samples)))
    top = to_signal(to_spectrum(base, n_fft) * spring / (spring - inertia), n_fft, 9000)
    rng = np.random.default_rng(int(frequency))
    return Recording(*(one + 0.01 * rng.normal(size=(2, 9000)) for one in (base, top)), RATE)


def test_what_resonates_on_the_plate_exchanges_no_channels():
    recordings = {f: with_absorber(f) for f in BURSTS}
    assert SWAPPED in [leading_channel(one, f, 10) for f, one in recordings.items()]
    assert check_configuration(recordings) == []


def test_a_burst_that_is_exchanged_is_found_beside_its_neighbours():
    recordings = {f: with_absorber(f) for f in BURSTS}
    recordings[500.0] = recordings[500.0].exchanged()
    (finding,) = check_configuration(recordings)
    assert finding.frequency == 500
    assert finding.message.startswith("base and top look exchanged")
    assert belongs_exchanged(recordings, 500.0, 10) is True
    assert belongs_exchanged(recordings, 400.0, 10) is False
    assert belongs_exchanged({f: recordings[f] for f in (300.0, 400.0, 600.0)}, 400.0, 10) is None
