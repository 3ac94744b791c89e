"""Flat tops: channels that went beyond the range of their converter."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import BoolArray, RealArray

_SHORTEST_RUN = 3
# a rounded parabola falls by at most 7 steps over half the length of its flat top; noise may double that
_STEPS_BELOW = 16.0
_SINGLE_PRECISION = float(np.finfo(np.float32).eps)


def clipped_repeats(channel: RealArray) -> BoolArray:
    """Tell which repeats have flat tops.

    A converter out of range repeats its extreme value, and then leaves it steeply. A sound sine may repeat it
    too when its steps are coarse, but a rounded parabola is as flat beside its top as on it. So a top is
    called flat when three or more neighbouring samples share the repeat's largest (or smallest) value and the
    signal falls by more than 16 steps within half the length of that run on both sides; the step is the
    smallest difference between two values that occur, or the resolution of single precision.

    Parameters
    ----------
    channel : array, shape (repeats, n_samples)

    Returns
    -------
    array of bool, shape (repeats,)

    Notes
    -----
    Clipping ahead of a filter (an amplifier overloaded before the anti-aliasing filter) leaves no equal
    samples and is not seen; nor is clipping that takes off less than some steps of the converter, or less
    than three samples of a crest: with 17 samples to a period, up to a tenth of the amplitude.
    """
    return np.array([_is_flat(repeat) or _is_flat(-repeat) for repeat in channel], dtype=bool)


def _is_flat(signal: RealArray) -> bool:
    """Return whether the largest value is shared by a run that ends steeply on both sides."""
    largest = float(signal.max())
    resolution = _SINGLE_PRECISION * float(np.abs(signal).max())
    steps = np.diff(np.unique(signal))
    distinct = steps[steps > resolution]
    step = max(float(distinct.min()) if distinct.size else resolution, resolution)
    first, last = _runs(signal >= largest - resolution)
    long = last - first + 1 >= _SHORTEST_RUN
    return any(_edge_drop(signal, a, b) > _STEPS_BELOW * step for a, b in zip(first[long], last[long], strict=True))


def _runs(flags: BoolArray) -> tuple[np.ndarray, np.ndarray]:
    """Return the first and last index of each run of true values."""
    edges = np.diff(np.concatenate([[False], flags, [False]]).astype(int))
    return np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1


def _edge_drop(signal: RealArray, first: int, last: int) -> float:
    """Return how far the signal falls within half a run's length beside it, on the flatter side."""
    beyond = (last - first + 1) // 2
    sides = [i for i in (first - beyond, last + beyond) if 0 <= i < signal.size]
    return min((float(signal[first] - signal[i]) for i in sides), default=0.0)
