"""Recordings that hold the same samples are told: files copied under another name, repeats exported twice."""

from multilayer.signals.copies import copies_in_words, samples_of
from multilayer.signals.recording import Recording
from tests.unit.test_signals_quality import BURSTS, RATE, recording


def test_recordings_of_their_own_pass():
    assert copies_in_words({f"{f}.npz": samples_of(recording(f)) for f in BURSTS}) == []


def test_a_copy_is_told_with_what_it_is_a_copy_of():
    samples = {f"{f:.0f}.npz": samples_of(recording(f)) for f in BURSTS}
    (text,) = copies_in_words(samples | {"other.npz": samples["500.npz"]})
    assert text.startswith("recordings hold the same samples: 500.npz and other.npz; ")


def test_one_channel_alone_makes_no_copy():
    one = recording(300.0)
    two = Recording(one.base, recording(300.0, resonance=500.0).top, RATE)
    assert copies_in_words({"a.npz": samples_of(one), "b.npz": samples_of(two)}) == []


def test_repeats_that_are_the_same_are_told():
    one = recording(300.0, repeats=1)
    twice = Recording(one.base.repeat(2, axis=0), one.top.repeat(2, axis=0), RATE)
    samples = {f"{i}.npz": samples_of(twice if i == 0 else recording(400.0)) for i in range(2)}
    (text,) = copies_in_words(samples)
    assert text.startswith("repeats hold the same samples in 1 of 2 recordings (0.npz): ")


def test_long_lists_are_cut():
    same = samples_of(recording(300.0))
    (text,) = copies_in_words({f"{i}.npz": same for i in range(6)})
    assert "0.npz and 1.npz, 0.npz and 2.npz, 0.npz and 3.npz and 2 more; " in text
