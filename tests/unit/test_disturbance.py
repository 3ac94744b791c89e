"""Offsets and hum are taken off and told; sound recordings are left as they are."""

import numpy as np
import pytest

from multilayer.signals.disturbance import in_words, without_disturbances
from multilayer.signals.quality import check_recording
from multilayer.signals.recording import Recording
from tests.unit.test_signals_quality import BURSTS, RATE, recording


def with_hum(sound, size, mains=50.0):
    time = np.arange(sound.n_samples) / RATE
    hum = size * np.cos(2 * np.pi * mains * time + np.array([[0.3], [2.0]]))
    return Recording(sound.base + hum, sound.top + 0.5 * hum, RATE)


@pytest.mark.parametrize("frequency", BURSTS)
@pytest.mark.parametrize("noise", [0.0, 0.004, 0.3])
def test_sound_recordings_are_left_alone(frequency, noise):
    sound = recording(frequency, noise=noise)
    assert without_disturbances(sound, frequency, 10) == (sound, ())


@pytest.mark.parametrize("frequency", BURSTS)
def test_an_offset_is_taken_off(frequency):
    sound = recording(frequency)
    crest = np.abs(sound.base).max()
    cleaned, seen = without_disturbances(Recording(sound.base + 0.2 * crest, sound.top, RATE), frequency, 10)
    assert [(one.kind, one.channel) for one in seen] == [("offset", "base")]
    assert seen[0].share == pytest.approx(0.2, abs=0.01)
    assert np.abs(cleaned.base - sound.base).max() < 2e-3 * crest


@pytest.mark.parametrize("frequency", [300.0, 800.0, 1500.0])
@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_far_below_the_burst_is_taken_off(frequency, mains):
    sound = recording(frequency)
    crest = np.abs(sound.base).max()
    cleaned, seen = without_disturbances(with_hum(sound, 0.3 * crest, mains), frequency, 10)
    assert {one.kind for one in seen} == {f"hum of {mains:g} Hz"}
    assert np.abs(cleaned.base - sound.base).max() < 6e-3 * crest
    assert check_recording(cleaned, frequency) == []


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_hum_beside_the_burst_is_that_of_the_end(mains):
    sound = recording(100.0)
    crest = np.abs(sound.base).max()
    cleaned, seen = without_disturbances(with_hum(sound, 0.3 * crest, mains), 100.0, 10)
    assert {(one.kind, one.channel) for one in seen} == {(f"hum of {mains:g} Hz", name) for name in ("base", "top")}
    assert np.abs(cleaned.base - sound.base).max() < 6e-3 * crest
    assert np.abs(cleaned.top - sound.top).max() < 6e-3 * crest


@pytest.mark.parametrize("frequency", BURSTS)
@pytest.mark.parametrize("resonance", [8.0, 30.0, 50.0, 57.0])
@pytest.mark.parametrize("damping", [0.002, 0.05, 0.2])
def test_a_top_that_rings_slowly_is_left_alone(frequency, resonance, damping):
    sound = recording(frequency, resonance=resonance, damping=damping, tail=0.1)
    assert without_disturbances(sound, frequency, 10) == (sound, ())


@pytest.mark.parametrize("frequency", BURSTS)
def test_drift_along_a_line_is_taken_off(frequency):
    """What drifts all along is no ring-down: the record need not be longer."""
    sound = recording(frequency)
    crest = np.abs(sound.base).max()
    ramp = 0.02 * crest * np.linspace(0, 1, sound.n_samples)
    cleaned, seen = without_disturbances(Recording(sound.base + ramp, sound.top - ramp, RATE), frequency, 10)
    kinds = {(taken.kind, taken.channel) for taken in seen}
    assert {("drift", "base"), ("offset", "base"), ("drift", "top"), ("offset", "top")} <= kinds
    assert np.abs(cleaned.base - sound.base).max() < 2e-3 * crest
    assert np.abs(cleaned.top - sound.top).max() < 5e-3 * np.abs(sound.top).max()


@pytest.mark.parametrize("mains", [50.0, 60.0])
def test_weak_hum_far_below_the_burst_stands_out_of_what_lies_beside_it(mains):
    """Left in the records, hum of a per cent is a tone at their ends, which passes for a ring-down."""
    sound = recording(800.0)
    crest = np.abs(sound.base).max()
    cleaned, seen = without_disturbances(with_hum(sound, 0.008 * crest, mains), 800.0, 10)
    assert ("hum", "base") in {(taken.kind.split()[0], taken.channel) for taken in seen}
    assert np.abs(cleaned.base - sound.base).max() < 2e-3 * crest


def test_one_sentence_for_each_kind():
    sound = recording(300.0)
    _, seen = without_disturbances(Recording(sound.base + 2, sound.top + 1, RATE), 300.0, 10)
    (text,) = in_words({"a.npz": seen, "b.npz": ()})
    assert text.startswith("offset in 1 of 2 recordings, taken off: up to 2 m/s2, ")
    assert "base channel" in text


def test_values_that_are_not_finite_are_for_the_quality_check():
    sound = recording(300.0)
    sound.base[0, 5] = np.nan
    assert without_disturbances(sound, 300.0, 10) == (sound, ())
