"""Channels from arrays with names, as files of MATLAB and HDF5 files hold them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from multilayer.errors import InputError, Problem
from multilayer.signals.channels import Channel, Channels, as_samples, rate_of_step

_RATES = ("sampling_rate", "sample_rate", "samplerate", "samplingrate", "sampling_frequency", "fs", "rate")
_STEPS = ("dt", "time_step", "wf_increment")
_TIMES = ("time", "t")
_EVEN = 1e-3  # of a step
_FEWEST = 3
ATTRIBUTE = "@/"  # between the name of an array, or of the whole file, and what is said of it


def channels_of(file: Path, arrays: Mapping[str, NDArray[np.generic]], units: Mapping[str, str]) -> Channels:
    """Return the channels among arrays: every array of numbers with three samples or more.

    A sampling rate is a single number called ``sampling_rate``, ``fs`` and the like, Hz, a step ``dt``, s, or an array
    ``time`` or ``t``, s, at even steps. Of an array with two axes the longer one is time; its channels are numbered.

    Parameters
    ----------
    file : Path
    arrays : mapping
        By name; a name may be a path with slashes, whose last part counts for rates and times. What is said of an
        array alone stands under ``NAME@/WHAT``, of the whole file under ``@/WHAT``.
    units : mapping of str
        By name, where the file says them.

    Raises
    ------
    InputError
        When time runs unevenly, or there is no channel.
    """
    numeric = {name: np.asarray(values) for name, values in arrays.items() if np.asarray(values).dtype.kind in "fiu"}
    general = _rate(file, {name: values for name, values in numeric.items() if name.find(ATTRIBUTE) <= 0})
    channels = [
        Channel(full, as_samples(row), units.get(name), _own_rate(file, name, numeric) or general)
        for name, values in numeric.items()
        if values.ndim <= 2 and values.size >= _FEWEST and _last(name) not in _TIMES and ATTRIBUTE not in name
        for full, row in _rows(name, values)
    ]
    if not channels:
        raise InputError(Problem("holds no array of samples", file=file))
    return Channels(file, tuple(channels))


def _last(name: str) -> str:
    return name.rpartition("/")[2].casefold()


def _rows(name: str, values: NDArray[np.generic]) -> Iterator[tuple[str, NDArray[np.generic]]]:
    rows = np.atleast_2d(values)
    rows = rows if rows.shape[1] >= rows.shape[0] else rows.T
    if len(rows) == 1:
        yield name, rows[0]
    else:
        yield from ((f"{name}_{i}", row) for i, row in enumerate(rows, start=1))


def _rate(file: Path, arrays: Mapping[str, NDArray[np.generic]]) -> float | None:
    single = {_last(name): float(values.ravel()[0]) for name, values in arrays.items() if values.size == 1}
    for name in _RATES:
        if single.get(name, 0.0) > 0:
            return single[name]
    for name in _STEPS:
        if single.get(name, 0.0) > 0:
            return 1.0 / single[name]
    times = [as_samples(values) for name, values in arrays.items() if _last(name) in _TIMES and values.size >= _FEWEST]
    return _rate_of_times(file, times[0]) if times else None


def _own_rate(file: Path, name: str, arrays: Mapping[str, NDArray[np.generic]]) -> float | None:
    """Return the rate that is said of one array alone."""
    return _rate(file, {key: value for key, value in arrays.items() if key.startswith(name + ATTRIBUTE)})


def _rate_of_times(file: Path, time: NDArray[np.float64]) -> float:
    step = float(time[-1] - time[0]) / (time.size - 1)
    if not step > 0 or np.max(np.abs(np.diff(time) - step)) > _EVEN * step + 1e-12 * float(np.abs(time[-1])):
        raise InputError(
            Problem("its array of times does not rise in even steps; export samples at even steps", file=file)
        )
    return rate_of_step(step)
