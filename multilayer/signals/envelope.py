"""Envelopes of bursts and their levels: Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96, eqs. (1) and (10)."""

from __future__ import annotations

import numpy as np
from scipy import fft

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.signals.spectra import padded_length


def analytic_signal(signal: ArrayLike) -> ComplexArray:
    """Return the signal plus i times its Hilbert transform, sample for sample.

    The record is zero-padded to twice its length before the transform, so that what happens at its end does
    not reach round to its beginning.

    Parameters
    ----------
    signal : array, shape (..., n_samples)
        Real.

    Returns
    -------
    array of complex, shape (..., n_samples)
    """
    samples = np.asarray(signal, dtype=float)
    n_samples = samples.shape[-1]
    n_fft = padded_length(n_samples)
    spectrum = np.asarray(fft.fft(samples, n_fft, axis=-1), dtype=complex)
    # only positive frequencies, doubled; the two bins that are their own mirror image stay as they are
    weight = np.zeros(n_fft)
    weight[0] = 1.0
    weight[1 : (n_fft + 1) // 2] = 2.0
    if n_fft % 2 == 0:
        weight[n_fft // 2] = 1.0
    return np.asarray(fft.ifft(spectrum * weight, axis=-1)[..., :n_samples], dtype=complex)


def envelope(signal: ArrayLike) -> RealArray:
    """Return the modulus of the analytic signal (Bonfiglio & Pompoli 2015, eq. (1)).

    It is the burst's window as long as the window's spectrum lies below the tone: three cycles or more.

    Parameters
    ----------
    signal : array, shape (..., n_samples)

    Returns
    -------
    array, shape (..., n_samples)
        In the unit of the signal, never negative.
    """
    return np.asarray(np.abs(analytic_signal(signal)), dtype=float)


def rms(signal: ArrayLike) -> RealArray:
    """Return the root mean square over the last axis, shape (...)."""
    return np.asarray(np.sqrt(np.mean(np.square(np.asarray(signal, dtype=float)), axis=-1)))


def level_difference_db(a: ArrayLike, b: ArrayLike) -> RealArray:
    """Return ``20 log10(rms(a) / rms(b))`` in dB, shape (...) (Bonfiglio & Pompoli 2015, eq. (10)).

    Infinite when only one of the two is silent, not a number when both are.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(20.0 * np.log10(rms(a) / rms(b)))
