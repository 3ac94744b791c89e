"""Truncated records: the ring-down beyond the end of a record, and its effect on a ratio of spectra.

The ratio of the spectra of two records is the transmissibility only where both have decayed within the record. A
sample of loss factor 0.02 rings for fifty periods: truncated at a hundredth of its maximum, the ratio at its resonance
is several per cent off, and E2 with it. The model is therefore truncated where the record ends.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Self

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.signals.spectra import frequencies, padded_length, to_signal, to_spectrum

Motion = Callable[[RealArray], ComplexArray]
_LEAST = 2e-4  # of the base's largest bin: the level of a Hann window beyond a band of twice its frequency
_NOISE = 2.0  # standard deviations of a bin's noise below which it is not taken for motion
_GROWTH = 4  # first period that is tried, in lengths of the record
_MOST_GROWN = 32
_STANDS_OUT = 4.0  # noise alone exceeds it once in some ten thousand records
_SILENT = 1e-6  # of the largest sample: the least noise of a channel
_DECAYED = 0.01  # level at the end of the period, relative to that at the record's end


@dataclass(frozen=True, eq=False)
class RecordEnd:
    """The missing ring-down of one burst as a linear function of the transmissibility.

    Attributes
    ----------
    frequency : array, shape (m,)
        Frequencies at which the transmissibility is needed, Hz.
    direct, mirrored : complex array, shape (n, m)
        The ratio at n bins lacks ``direct T + mirrored conj(T)``; the second term is that of negative frequencies.
    period : int
        Samples after which the ring-down wraps round.
    """

    frequency: RealArray
    direct: ComplexArray = field(repr=False)
    mirrored: ComplexArray = field(repr=False)
    period: int

    @classmethod
    def of(cls, burst: BurstData, bins: RealArray, reach: tuple[float, float], period: int) -> Self:
        """Return the missing part for some bins of a burst.

        Parameters
        ----------
        burst : BurstData
        bins : array, shape (n,)
            Hz.
        reach : (low, high)
            Range of the rig's model, relative to the burst's frequency.
        period : int
            A transform length.

        Notes
        -----
        With the record's N samples and a period of P, ``x_n = 1/P sum_k [X_k exp(i w_k n) + conj]`` is summed over
        ``N <= n < P`` with ``exp(-i w_j n)``: geometric series.
        """
        n, f = burst.n_samples, frequencies(period, burst.sampling_rate)
        spectrum = to_spectrum(burst.base, period)
        floor = (_NOISE * burst.noise.base) ** 2 * n
        largest = float(np.abs(spectrum).max())
        low, high = (limit * burst.frequency for limit in reach)
        kept = (np.abs(spectrum) > max(_LEAST * largest, np.sqrt(floor))) & (f > max(low, 0.0)) & (f <= high)
        kept[-1] = False  # the bin at half the sampling rate has no mirror
        base = spectrum[kept] * (1 - floor / np.abs(spectrum[kept]) ** 2)
        w, at = (2 * np.pi * x / burst.sampling_rate for x in (f[kept], bins))
        level = to_spectrum_at(burst.base, at)[:, None] * period
        direct = _series(w - at[:, None], n, period) * base / level
        mirrored = _series(-w - at[:, None], n, period) * np.conj(base) / level
        return cls(f[kept], direct, mirrored, period)

    def missing(self, motion: ComplexArray) -> ComplexArray:
        """Return the missing part of the ratio, shape (..., n), for transmissibilities of shape (..., m)."""
        return np.asarray(motion @ self.direct.T + np.conj(motion) @ self.mirrored.T)


def rings_at_end(burst: BurstData) -> bool:
    """Tell whether a tone stands out of the noise in the last tenth of the top plate's record."""
    tail = burst.top[-max(burst.n_samples // 10, 16) :]
    window = np.hanning(len(tail))
    noise = max(burst.noise.top, _SILENT * float(np.abs(burst.top).max()))
    return bool(np.abs(np.fft.rfft(window * tail)).max() > _STANDS_OUT * noise * np.linalg.norm(window))


def to_spectrum_at(signal: RealArray, phase: RealArray) -> ComplexArray:
    """Return the spectrum of a signal at any angular frequencies per sample, shape (n,)."""
    return np.asarray(np.exp(-1j * np.outer(phase, np.arange(len(signal)))) @ signal)


def _series(step: RealArray, first: int, last: int) -> ComplexArray:
    """Return ``sum_{n=first}^{last-1} exp(i step n)``."""
    count = last - first
    half = 0.5 * step
    small = np.abs(np.sin(half)) < 1e-12
    kernel = np.where(small, count, np.sin(count * half) / np.where(small, 1.0, np.sin(half)))
    return np.asarray(kernel * np.exp(1j * half * (first + last - 1)))


def period_of(burst: BurstData, motion: Motion, reach: tuple[float, float]) -> int:
    """Return a transform length after which the modelled ring-down has decayed, or the longest that is tried."""
    low, high = (limit * burst.frequency for limit in reach)
    growth = _GROWTH
    while True:
        period = padded_length(burst.n_samples, growth)
        f = frequencies(period, burst.sampling_rate)
        spectrum = to_spectrum(burst.base, period)
        kept = (np.abs(spectrum) > _LEAST * np.abs(spectrum).max()) & (f > max(low, 0.0)) & (f <= high)
        shown = np.zeros(len(f), dtype=complex)
        shown[kept] = motion(f[kept]) * spectrum[kept]
        signal = np.abs(to_signal(shown, period, period))
        some = max(burst.n_samples // 50, 1)
        end = signal[burst.n_samples - some : burst.n_samples].mean()
        if growth >= _MOST_GROWN or signal[-some:].mean() <= _DECAYED * max(end, 0.01 * signal.max()):
            return period
        growth *= 2
