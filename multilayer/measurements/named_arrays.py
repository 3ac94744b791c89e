"""Channels and spectra from arrays with names, as files of MATLAB, HDF5 and NumPy hold them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.errors import InputError, Problem
from multilayer.measurements.columns import FREQUENCY
from multilayer.measurements.spectra import Spectra
from multilayer.signals.channels import Channel, Channels, as_samples, different, rate_of_step
from multilayer.tables import Header

_RATES = ("sampling_rate", "sample_rate", "samplerate", "samplingrate", "sampling_frequency", "fs", "rate")
_STEPS = ("dt", "time_step", "wf_increment")
_TIMES = ("time", "t")
_EVEN = 1e-3  # of a step
_FEWEST = 3
ATTRIBUTE = "@/"  # between the name of an array (empty for the whole file) and that of its attribute


def channels_of(file: Path, arrays: Mapping[str, NDArray[np.generic]], units: Mapping[str, str]) -> Channels:
    """Return the channels among arrays: every array of numbers with three samples or more.

    A sampling rate is a single number called ``sampling_rate``, ``fs`` and the like, Hz, a step ``dt``, s, or an array
    ``time`` or ``t``, s, at even steps. Of an array with two axes the longer one is time; its channels are numbered.

    Parameters
    ----------
    file : Path
    arrays : mapping
        By name; a name may be a path with slashes, whose last part counts for rates and times. An attribute of one
        array stands under ``NAME@/ATTRIBUTE``, one of the whole file under ``@/ATTRIBUTE``.
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
        Channel(full, as_samples(row), units.get(name), _attribute_rate(file, name, numeric) or general)
        for name, values in numeric.items()
        if values.ndim <= 2 and values.size >= _FEWEST and _last(name) not in _TIMES and ATTRIBUTE not in name
        for full, row in _rows(name, values)
    ]
    if not channels:
        raise InputError(Problem("holds no array of samples", file=file))
    return Channels(file, tuple(channels))


def spectra_of(file: Path, arrays: Mapping[str, NDArray[np.generic]], units: Mapping[str, str]) -> Spectra:
    """Return the spectra among arrays: every array of numbers with as many values as the array of frequencies.

    The latter is called ``frequency``, ``freq`` or ``f``, in Hz unless it has another unit. Arrays with two axes are
    several spectra, numbered. Spectra are named by the last part of a path, or by all of it where two share that part.

    Parameters
    ----------
    file, arrays, units
        See `channels_of`; numbers may be complex, or pairs of fields ``real`` and ``imag``.

    Raises
    ------
    InputError
        When there are no frequencies, several arrays of them, or nothing beside them.
    """
    numeric = {
        name: array
        for name, values in arrays.items()
        if (array := _numbers(values)).dtype.kind in "fiuc" and ATTRIBUTE not in name
    }
    axes = [name for name, array in numeric.items() if array.size > 1 and _frequency(name) is not None]
    if len(axes) != 1:
        what = f"several arrays of frequencies: {', '.join(axes)}" if axes else "no array called 'frequency'"
        raise InputError(Problem(f"holds {what}; values over frequency need one such array beside them", file=file))
    frequency = numeric.pop(axes[0])
    rows = {
        full: (name, row) for name, array in numeric.items() for full, row in _spectra_in(name, array, frequency.size)
    }
    if not rows:
        raise InputError(Problem(f"holds no array of {frequency.size} values, as '{axes[0]}' has", file=file))
    names = different([full.rpartition("/")[2] for full in rows], list(rows))
    return Spectra(
        frequency.ravel() * _hertz(file, axes[0], units),
        {name: row for name, (_, row) in zip(names, rows.values(), strict=True)},
        {name: units[path] for name, (path, _) in zip(names, rows.values(), strict=True) if path in units},
    )


def _numbers(values: NDArray[np.generic]) -> NDArray[Any]:
    array = np.asarray(values)
    if array.dtype.names == ("real", "imag"):  # complex numbers of MATLAB's version 7.3
        return np.asarray(array["real"] + 1j * array["imag"])
    return array


def _frequency(name: str) -> Header | None:
    header = Header.of(_last(name))
    return header if header.name in FREQUENCY.names else None


def _hertz(file: Path, name: str, units: Mapping[str, str]) -> float:
    header = Header.of(_last(name))
    try:
        return Header(name, header.name, units.get(name, header.unit or "Hz")).factor("Hz")
    except ValueError as error:
        raise InputError(Problem(str(error), file=file)) from None


def _spectra_in(name: str, array: NDArray[Any], count: int) -> Iterator[tuple[str, NDArray[Any]]]:
    """Give names and values of the spectra of `count` values in an array, numbered where it has two axes."""
    if array.size == count:
        yield name, array.ravel()
    elif array.ndim == 2 and count in array.shape:
        rows = array.T if array.shape[0] == count else array
        yield from ((f"{name}_{i}", row) for i, row in enumerate(rows, start=1))


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


def _attribute_rate(file: Path, name: str, arrays: Mapping[str, NDArray[np.generic]]) -> float | None:
    """Return the sampling rate, Hz, among the attributes of one array."""
    return _rate(file, {key: value for key, value in arrays.items() if key.startswith(name + ATTRIBUTE)})


def _rate_of_times(file: Path, time: NDArray[np.float64]) -> float:
    step = float(time[-1] - time[0]) / (time.size - 1)
    if not step > 0 or np.max(np.abs(np.diff(time) - step)) > _EVEN * step + 1e-12 * float(np.abs(time[-1])):
        raise InputError(
            Problem("its array of times does not rise in even steps; export samples at even steps", file=file)
        )
    return rate_of_step(step)
