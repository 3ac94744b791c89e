"""Recordings that do not belong with their neighbours: bursts whose bands overlap see the same sample there."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from multilayer.arrays import RealArray
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import frequencies, noise_level, padded_length, to_spectrum

_LOBE = 1.5  # over the duration: half the width of what is compared, of a main lobe of 2
_FADE = 3.0  # nepers over the shortest record: what a record cuts off, and a sharp resonance, hardly count
_APART = 0.05
_ALONE = 10.0  # over the most that any of the others departs: of a sample that softens with level all do, by degrees
_CHANCE = 5.0  # times what noise does
_FEWEST = 4  # bursts with neighbours
_MOST = 0.25  # of those: more are no slip of a file


def departures(recordings: Mapping[float, Recording], cycles: float) -> dict[float, float]:
    """Return how far each burst's top over base is from that of its neighbours, relative, where their bands overlap.

    Both channels are multiplied by the same decaying exponential, which shows T(w - i s) in place of T(w) and takes
    the end of a ring-down, which records cut differently, out of it. Of several neighbours it is the lower median:
    half of them, at least, are as far. No model of the rig is asked: a linear sample that stays as it is has one T.

    Parameters
    ----------
    recordings : mapping of float to Recording
        By the bursts' frequencies, Hz, of one configuration.
    cycles : float
        Of the bursts, under their Hann windows.

    Returns
    -------
    dict
        By frequency; 0 where noise explains it. Without bursts that have no neighbour, or a channel of no signal.
    """
    if len(recordings) < _FEWEST:
        return {}
    shortest = min(recording.n_samples / recording.sampling_rate for recording in recordings.values())
    n_fft = max(padded_length(recording.n_samples) for recording in recordings.values())
    seen = {f: _Seen(recording, f, cycles, n_fft, _FADE / shortest) for f, recording in recordings.items()}
    found: dict[float, float] = {}
    for f, here in seen.items():
        apart = [d for g, there in seen.items() if g != f and np.isfinite(d := here.departure(there))]
        if apart:
            found[f] = sorted(apart)[(len(apart) - 1) // 2]
    return found


def belongs_exchanged(recordings: Mapping[float, Recording], frequency: float, cycles: float) -> bool | None:
    """Tell whether a burst is nearer to its neighbours with its channels exchanged; None where it has no neighbours.

    Parameters
    ----------
    recordings : mapping of float to Recording
        By the bursts' frequencies, Hz, of one configuration.
    frequency : float
        Of the burst.
    cycles : float
        Of the bursts.
    """
    turned = {**recordings, frequency: recordings[frequency].exchanged()}
    here, there = (departures(each, cycles).get(frequency) for each in (recordings, turned))
    return None if here is None or there is None else there < here


class _Seen:
    """What one burst shows of top over base within its main lobe.

    Attributes
    ----------
    inside : array of bool, shape (n_bins,)
    ratio : complex array, shape (n_inside,)
    variance : array, shape (n_inside,)
        Of the noise in the ratio.
    """

    def __init__(self, recording: Recording, frequency: float, cycles: float, n_fft: int, rate: float) -> None:
        f = frequencies(n_fft, recording.sampling_rate)
        self.inside = np.abs(f - frequency) < _LOBE * frequency / cycles
        time = np.arange(recording.n_samples) / recording.sampling_rate
        fade = np.exp(-rate * time)
        base, top = (to_spectrum((x - np.median(x)) * fade, n_fft)[self.inside] for x in recording.mean())
        noise = noise_level(recording, of_mean=True)
        with np.errstate(divide="ignore", invalid="ignore"):
            self.ratio = top / base
            size = np.sum(fade**2) / np.abs(base) ** 2
            self.variance: RealArray = size * (noise.top**2 + noise.base**2 * np.abs(self.ratio) ** 2)

    def departure(self, other: _Seen) -> float:
        """Return how far the two ratios are apart, relative; nan without a common band, 0 where noise explains it."""
        if self.inside.shape != other.inside.shape or not np.any(both := self.inside & other.inside):
            return np.nan
        a, b = self.ratio[both[self.inside]], other.ratio[both[other.inside]]
        variance = self.variance[both[self.inside]] + other.variance[both[other.inside]]
        # by the noise, but for what would count alone where there is none
        weight = 1 / (variance + 1e-12 * np.abs(a * b))
        size = np.sum(weight * np.abs(a * b))
        apart, chance = np.sum(weight * np.abs(a - b) ** 2), np.sum(weight * variance)
        if not (np.isfinite(apart) and size > 0):
            return np.nan
        return float(np.sqrt(apart / size)) if apart > _CHANCE**2 * chance else 0.0


def neighbours_in_words(recordings: Mapping[str, Mapping[str, tuple[float, Recording]]], cycles: float) -> list[str]:
    """Return a sentence about each configuration some of whose recordings do not belong with their neighbours.

    Parameters
    ----------
    recordings : mapping
        By configuration and file, the burst's frequency, Hz, and the recording.
    cycles : float
        Of the bursts.
    """
    texts = []
    for name, of_this in recordings.items():
        found = departures(dict(of_this.values()), cycles)
        odd = {f: apart for f, apart in found.items() if apart > _APART}
        rest = max((apart for f, apart in found.items() if f not in odd), default=0.0)
        if len(found) < _FEWEST or not 0 < len(odd) <= _MOST * len(found) or _ALONE * rest > min(odd.values()):
            continue
        files = {f: file for file, (f, _) in of_this.items()}
        listed = ", ".join(f"{files[f]} (by {100 * apart:.2g} %)" for f, apart in odd.items())
        texts.append(
            f"in configuration '{name}', top over base of {listed} departs from that of its neighbours where their "
            "bands overlap, which one sample does not do: is it the recording of another configuration, or was the "
            "rig touched? Put the right file in its place, measure the burst again, or remove it"
        )
    return texts
