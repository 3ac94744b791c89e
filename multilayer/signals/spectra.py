"""Between time and frequency: with exp(+i w t), a delay tau multiplies a spectrum by exp(-i w tau)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy import fft

from multilayer.arrays import ArrayLike, BoolArray, ComplexArray, RealArray
from multilayer.signals.recording import Recording

# a normal deviate exceeds 0.6745 standard deviations in half of all cases
_MEDIAN_TO_STD = 1.0 / 0.6745
_QUIET_SHARE = 0.1


def padded_length(n_samples: int, factor: int = 2) -> int:
    """Return a transform length of at least `factor` times the record, quick to transform.

    A discrete spectrum describes a periodic signal: whatever a filter makes to ring or to lag beyond the end
    of the record comes back at its beginning. Zeros after the record give the ring-down room to die out.
    Twice the length is enough for correlations, and for a response that has decayed within one record after
    the end of the record; a lightly damped response needs a larger factor.
    """
    return int(fft.next_fast_len(factor * n_samples, real=True))


def to_spectrum(signal: ArrayLike, n_fft: int) -> ComplexArray:
    """Return the one-sided spectrum of a real signal, zero-padded to `n_fft` samples.

    Parameters
    ----------
    signal : array, shape (..., n_samples)
    n_fft : int
        Transform length, at least `n_samples`; see `padded_length`.

    Returns
    -------
    array, shape (..., n_fft // 2 + 1)
        Sums over the samples, in the unit of the signal; bin frequencies as in `frequencies`.

    Raises
    ------
    ValueError
        When `n_fft` is shorter than the record: the record would be cut silently.
    """
    samples = np.asarray(signal, dtype=float)
    if n_fft < samples.shape[-1]:
        raise ValueError(f"a transform of {n_fft} samples cuts a record of {samples.shape[-1]}")
    return np.asarray(fft.rfft(samples, n_fft, axis=-1), dtype=complex)


def to_signal(spectrum: ArrayLike, n_fft: int, n_samples: int) -> RealArray:
    """Return the first `n_samples` of the real signal of a one-sided spectrum; inverse of `to_spectrum`."""
    return np.asarray(fft.irfft(np.asarray(spectrum), n_fft, axis=-1)[..., :n_samples], dtype=float)


def frequencies(n_fft: int, sampling_rate: float) -> RealArray:
    """Return the frequencies of a one-sided spectrum, Hz, shape (n_fft // 2 + 1,)."""
    return np.asarray(fft.rfftfreq(n_fft, 1.0 / sampling_rate), dtype=float)


def band(base_spectrum: ArrayLike, threshold: float = 0.01) -> BoolArray:
    """Return which bins hold the burst's energy: modulus at least `threshold` times the largest.

    Parameters
    ----------
    base_spectrum : array, shape (..., n_frequency)
        Spectrum of the support plate's acceleration.
    threshold : float
        Between 0 and 1. Outside of the band the base moves so little that a ratio of spectra is noise.

    Returns
    -------
    array of bool, shape (..., n_frequency)
        All false for a silent signal.
    """
    modulus = np.abs(np.asarray(base_spectrum))
    largest = np.max(modulus, axis=-1, keepdims=True)
    return np.asarray((modulus >= threshold * largest) & (largest > 0))


class Noise(NamedTuple):
    """Standard deviation of each channel's noise, in the unit of the signals."""

    base: float
    top: float


def noise_level(recording: Recording, *, of_mean: bool = False) -> Noise:
    """Return the standard deviation of the noise of each channel.

    With several repeats it is their scatter about their mean (with n - 1 in the denominator: unbiased), which
    includes everything else that differs from repeat to repeat. With a single repeat it comes from the last tenth
    of the record, through the median of its second differences (F. R. Hampel, J. Am. Stat. Assoc. 69 (1974) 383-393):
    the rest of a ring-down, slow against the sampling, and single spikes do not count. That assumes white noise: noise
    below a tenth of the sampling rate is underestimated.

    Parameters
    ----------
    recording : Recording
        Both channels, (repeats, samples).
    of_mean : bool
        Noise of the mean over the repeats (smaller by the root of their number) in place of that of a single
        repeat.
    """
    repeats = recording.base.shape[0]
    measure = _quiet_noise if repeats == 1 else _scatter
    scale = 1.0 / np.sqrt(repeats) if of_mean else 1.0
    return Noise(scale * measure(recording.base), scale * measure(recording.top))


def _scatter(repeated: RealArray) -> float:
    return float(np.sqrt(np.mean(np.var(repeated, axis=0, ddof=1))))


def _quiet_noise(repeated: RealArray) -> float:
    n_samples = repeated.shape[-1]
    tail = repeated[..., -max(int(_QUIET_SHARE * n_samples), 16) :]
    # white noise of unit variance has second differences of variance 1 + 4 + 1
    differences = np.diff(tail, n=2, axis=-1) / np.sqrt(6.0)
    return float(_MEDIAN_TO_STD * np.median(np.abs(differences))) if differences.size else 0.0
