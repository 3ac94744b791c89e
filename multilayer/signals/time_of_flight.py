"""Time of flight between two accelerometers: the delay at the maximum of their cross-correlation."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.signals.spectra import padded_length, to_signal, to_spectrum

# from the crest of a sinusoid through three samples Newton's method needs two or three steps
_NEWTON_STEPS = 3


def time_of_flight(base: ArrayLike, top: ArrayLike, sampling_rate: float, *, subsample: bool = True) -> RealArray:
    """Return the delay of `top` behind `base` at the maximum of their cross-correlation.

    Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, step 2 of the inversion: the delay ``tau`` of the largest
    ``sum_t base(t) top(t + tau)``.

    Parameters
    ----------
    base, top : array, shape (..., n_samples)
        Accelerations of support plate and top plate, over the same time; leading axes broadcast.
    sampling_rate : float
        Hz.
    subsample : bool
        Interpolate the correlation between the samples (exactly, for band-limited signals, by its Fourier
        series). With False the delay is a whole number of samples, as in the paper.

    Returns
    -------
    array, shape (...)
        In s, positive when `top` comes later. Zero when one of the signals is silent.

    Notes
    -----
    The correlation of a narrow-band burst oscillates with the burst's own period under an
    envelope that is as wide as the burst. Hence the delay is that of the phase, modulo one period; of the
    many peaks the one nearest to the crest of the envelope wins, that is, the one nearest to the delay of the
    energy. For ten cycles under a Hann window the next peak is 6 % lower, so the choice is safe for a mere
    delay; where the phase of the response is near 180 degrees (well above the resonance), two peaks half a
    period to either side are nearly as high, and a small change of the signals moves the result by a whole
    period. A negative delay of half a period is then nothing wrong.

    The signals are zero-padded: delays up to the length of the record are told apart from negative ones.
    """
    start, end = np.asarray(base, dtype=float), np.asarray(top, dtype=float)
    if start.shape[-1] != end.shape[-1]:
        raise ValueError(f"base has {start.shape[-1]} samples, top {end.shape[-1]}: they must be as many")
    n_fft = padded_length(start.shape[-1])
    cross = to_spectrum(end, n_fft) * np.conj(to_spectrum(start, n_fft))
    correlation = to_signal(cross, n_fft, n_fft)
    if not subsample:
        return _signed(np.argmax(correlation, axis=-1), n_fft) / sampling_rate
    return _signed(_interpolated_peak(correlation, cross, n_fft), n_fft) / sampling_rate


def _signed(lag: ArrayLike, n_fft: int) -> RealArray:
    """Return lags of the periodic correlation as positive and negative ones."""
    lags = np.asarray(lag, dtype=float)
    return np.where(lags > n_fft / 2, lags - n_fft, lags)


def _interpolated_peak(correlation: RealArray, cross: ComplexArray, n_fft: int) -> RealArray:
    """Return the lag of the highest peak between samples, in samples from 0 to n_fft."""
    before, after = np.roll(correlation, 1, axis=-1), np.roll(correlation, -1, axis=-1)
    is_peak = (correlation >= before) & (correlation > after) & (before + after > -2.0 * correlation)
    # a sinusoid through three samples decides between periods, not the samples themselves: where there are few
    # of them to a period they straddle the crest. At the middle one it has the phase -arctan(tangent)
    safe = np.where(is_peak, correlation, 1.0)
    cosine = np.where(is_peak, 0.5 * (before + after) / safe, 0.0)
    cosine = np.minimum(cosine, 1.0 - 1e-12)  # rounding may reach 1
    tangent = np.where(is_peak, 0.5 * (after - before) / safe, 0.0) / np.sqrt(1.0 - cosine**2)
    height = np.where(is_peak, correlation * np.hypot(1.0, tangent), -np.inf)
    index = np.argmax(height, axis=-1, keepdims=True)
    offset = np.take_along_axis(np.arctan(tangent) / np.arccos(cosine), index, axis=-1)
    has_peak = np.take_along_axis(is_peak, index, axis=-1)
    lag = np.where(has_peak, index + offset, 0.0)
    return np.where(has_peak, _newton(lag, cross, n_fft), 0.0)[..., 0]


def _newton(lag: RealArray, cross: ComplexArray, n_fft: int) -> RealArray:
    """Return the stationary point of the correlation's Fourier series next to `lag`, shape (..., 1)."""
    omega = 2.0 * np.pi * np.arange(cross.shape[-1]) / n_fft
    refined = lag
    for _ in range(_NEWTON_STEPS):
        turned = cross * np.exp(1j * omega * refined)
        slope = -np.sum(omega * turned.imag, axis=-1, keepdims=True)
        bend = -np.sum(omega**2 * turned.real, axis=-1, keepdims=True)
        step = np.where(bend < 0, -slope / np.where(bend < 0, bend, -1.0), 0.0)
        # the peak lies within half a sample of the first guess; noise must not lead away
        refined = np.clip(refined + step, lag - 0.5, lag + 0.5)
    return refined
