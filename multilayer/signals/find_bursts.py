"""Tone bursts in a long recording: where they begin, and at which frequency."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import fft

from multilayer.arrays import ComplexArray, RealArray
from multilayer.signals.envelope import envelope
from multilayer.signals.spectra import padded_length, to_spectrum

BLOCK = 2**18  # samples per step: the envelope of a long recording would need too much memory at once
_OVERLAP = 2**13  # the Hilbert transform of a burst's tone has died out within it
_HIGH_PASS = 5.0  # Hz: drifts and offsets of amplifiers
_QUIET = 10  # percentile of the levels of short stretches: the recording at rest
_STRETCHES = 400
_ABOVE_NOISE = 6.0  # standard deviations; white noise exceeds it once in 7e7 samples
_ABOVE_CREST = 0.02  # of the loudest burst
_PROMINENCE = 0.5  # of its height, for a peak that stands alone
_HALF_WIDTH = 2.0  # a Hann window is half as long as itself at half of its height
_LOBES = 4.0  # over the cycles: half the width of a Hann window's spectrum with its first side lobes
_CYCLES_OFF = 0.3  # relative: how far a burst's length may be off


@dataclass(frozen=True)
class FoundBurst:
    """One burst in a recording.

    Attributes
    ----------
    onset : float
        Sample at which it begins, between samples.
    frequency : float
        Of its tone as the signal shows it, Hz.
    cycles : float
        How many periods its window spans, as the width of its envelope tells.
    """

    onset: float
    frequency: float
    cycles: float

    def fits(self, cycles: float) -> bool:
        """Tell whether it is a burst of so many cycles, rather than a knock or a tone."""
        return abs(self.cycles / cycles - 1.0) <= _CYCLES_OFF


def number_of_blocks(n_samples: int) -> int:
    """Return in how many steps `find_bursts` goes through a recording."""
    return max(-(-n_samples // BLOCK), 1)


def find_bursts(
    signal: RealArray, sampling_rate: float, cycles: float, progress: Callable[[], None] = lambda: None
) -> list[FoundBurst]:
    """Return the events in a recording that look like tone bursts under Hann windows, in the order of time.

    A burst is a peak of the envelope that stands clear of the noise at rest and falls to half of its height on both
    sides. Its frequency is the centre of its power spectrum, from the mean phase step of the analytic signal between
    samples; its centre that of its energy.

    Parameters
    ----------
    signal : array, shape (n_samples,)
        Acceleration of the driven plate, in any unit.
    sampling_rate : float
        Hz.
    cycles : float
        Periods of the bursts: an onset lies half as many before the centre of a burst.
    progress : callable
        Called after each of `number_of_blocks` steps.

    Returns
    -------
    list of FoundBurst
        Candidates; `FoundBurst.fits` tells whether one has the expected number of cycles.

    Notes
    -----
    Bursts below about 10 Hz are lost to the high-pass filter; so are bursts of less than 1/50 of the loudest one.
    """
    from scipy.signal import find_peaks, peak_widths

    high_passed = _without_drift(signal, sampling_rate)
    loudness = _envelope(high_passed, progress)
    threshold = max(_ABOVE_NOISE * _noise(high_passed), _ABOVE_CREST * float(loudness.max(initial=0.0)))
    peaks, properties = find_peaks(loudness, height=threshold, prominence=threshold)
    clear = properties["prominences"] >= _PROMINENCE * properties["peak_heights"]
    peaks = peaks[clear]
    prominent: Any = tuple(properties[key][clear] for key in ("prominences", "left_bases", "right_bases"))
    widths, _, left, right = peak_widths(loudness, peaks, 0.5, prominent)
    bursts: list[FoundBurst] = []
    for width, start, end in zip(widths, left, right, strict=True):
        burst = _burst(high_passed, sampling_rate, cycles, 0.5 * (start + end), _HALF_WIDTH * width)
        if burst is not None and not (bursts and burst.onset - bursts[-1].onset < 0.5 * width):
            bursts.append(burst)
    return bursts


def _without_drift(signal: RealArray, sampling_rate: float) -> RealArray:
    from scipy.signal import butter, sosfiltfilt

    centred = signal - np.median(signal)
    if centred.size < sampling_rate / _HIGH_PASS or sampling_rate <= 4 * _HIGH_PASS:
        return np.asarray(centred)
    return np.asarray(sosfiltfilt(butter(2, _HIGH_PASS, "highpass", fs=sampling_rate, output="sos"), centred))


def _envelope(signal: RealArray, progress: Callable[[], None]) -> RealArray:
    """Return the envelope, made block by block."""
    loudness = np.empty(signal.size)
    for start in range(0, signal.size, BLOCK):
        ahead = max(start - _OVERLAP, 0)
        piece = envelope(signal[ahead : start + BLOCK + _OVERLAP])
        end = min(start + BLOCK, signal.size)
        loudness[start:end] = piece[start - ahead : end - ahead]
        progress()
    return loudness


def _noise(signal: RealArray) -> float:
    """Return the standard deviation at rest: of the quietest tenth of short stretches."""
    length = max(signal.size // _STRETCHES, 16)
    stretches = signal[: signal.size // length * length].reshape(-1, length)
    return float(np.percentile(stretches.std(axis=1), _QUIET)) if len(stretches) else 0.0


def _burst(signal: RealArray, rate: float, cycles: float, centre: float, duration: float) -> FoundBurst | None:
    """Return the burst about a centre, from the samples within its estimated duration; None without a frequency."""
    low, high = max(int(centre - duration), 0), min(int(centre + duration) + 2, signal.size)
    local = _in_band(signal[low:high], cycles)
    index = np.arange(low, high)
    power = np.abs(local) ** 2
    inside = np.abs(index - centre) <= 0.5 * duration
    near = inside[1:] & (power[1:] >= 0.25 * power[inside].max(initial=0.0))
    phase_step = float(np.angle(np.sum((local[1:] * np.conj(local[:-1]))[near])))
    if not phase_step > 0:
        return None
    frequency = phase_step * rate / (2 * np.pi)
    middle = float(np.sum((index * power)[inside]) / np.sum(power[inside]))
    return FoundBurst(middle - 0.5 * cycles / frequency * rate, frequency, duration / rate * frequency)


def _in_band(signal: RealArray, cycles: float) -> ComplexArray:
    """Return the analytic signal of the strongest tone and its side lobes, without the noise elsewhere."""
    n_fft = padded_length(signal.size)
    spectrum = to_spectrum(signal, n_fft)
    bins = np.arange(spectrum.size)
    strongest = int(np.argmax(np.abs(spectrum)))
    lobes = np.abs(bins - strongest) <= _LOBES / cycles * strongest
    return np.asarray(fft.ifft(2 * np.where(lobes, spectrum, 0.0), n_fft)[: signal.size])


def stated_frequency(measured: float, known: tuple[float, ...] = ()) -> float | None:
    """Return the frequency that a burst was meant to have.

    That is the nearest of the known ones if it lies within 5 %, else None. Without known frequencies it is the roundest
    number within 0.5 %, by which the response of a shaker shifts the centre of a burst's spectrum.

    Parameters
    ----------
    measured : float
        Frequency of the tone in the signal, Hz.
    known : tuple of float
        Frequencies that there may be, Hz.
    """
    if known:
        nearest = min(known, key=lambda f: abs(f - measured))
        return nearest if abs(measured / nearest - 1.0) <= 0.05 else None
    for step in (1000.0, 500.0, 100.0, 50.0, 10.0, 5.0, 1.0, 0.5, 0.1):
        rounded = round(measured / step) * step
        if rounded > 0 and abs(measured / rounded - 1.0) <= 5e-3:
            return float(f"{rounded:.6g}")
    return float(f"{measured:.5g}")
