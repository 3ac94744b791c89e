"""The excitation: a Hann-windowed tone burst, as in Bonfiglio & Pompoli, Polymer Testing 48 (2015) 89-96."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ArrayLike, RealArray

# mean square of a Hann window (3/8) times that of a sine (1/2)
_MEAN_SQUARE = 3.0 / 16.0


def hann_burst(
    frequency: ArrayLike,
    cycles: float,
    sampling_rate: float,
    level_rms: float = 5.0,
    *,
    n_samples: int | None = None,
    start: ArrayLike = 0.0,
) -> RealArray:
    """Return a sine of so many cycles under a Hann window, zero before and after.

    Parameters
    ----------
    frequency : float or array, shape (...)
        Frequency of the tone, Hz.
    cycles : float
        Periods in the burst; it lasts ``cycles / frequency``.
    sampling_rate : float
        Samples per second, Hz.
    level_rms : float
        Root mean square of the windowed burst over its own duration, m/s^2 (or any unit). The peak is nearly
        ``level_rms * sqrt(16/3)``, so 5 m/s^2 rms peak at 11.5 m/s^2.
    n_samples : int, optional
        Length of the record; by default it ends with the (longest) burst.
    start : float or array, shape (...)
        When the burst begins, s; need not fall on a sample.

    Returns
    -------
    array, shape (..., n_samples)

    Notes
    -----
    The burst is sampled, not band-limited: cut ``cycles`` below about 3 and its spectrum reaches
    far beyond the tone. The tone starts at phase 0, so it has no mean.
    """
    tone = np.asarray(frequency, dtype=float)[..., np.newaxis]
    begin = np.asarray(start, dtype=float)[..., np.newaxis]
    duration = cycles / tone
    if n_samples is None:
        n_samples = int(np.ceil(np.max(begin + duration) * sampling_rate)) + 1
    time = np.arange(n_samples) / sampling_rate - begin
    window = np.where((time > 0) & (time < duration), np.sin(np.pi * time / duration) ** 2, 0.0)
    burst: RealArray = level_rms / np.sqrt(_MEAN_SQUARE) * window * np.sin(2 * np.pi * tone * time)
    return burst
