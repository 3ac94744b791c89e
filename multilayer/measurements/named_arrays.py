"""Channels and spectra from arrays with names, as files of MATLAB, HDF5 and NumPy hold them."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

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
_SAMPLES = re.compile(r"(?:samples?|Sa?)\s*/\s*s(?:ec)?|sps", re.IGNORECASE)
_EVEN = 1e-3  # of a step
_RATE_AGREEMENT = 1e-3
_FEWEST = 3
ATTRIBUTE = "@/"  # between the name of an array (empty for the whole file) and that of its attribute

_Arrays: TypeAlias = Mapping[str, NDArray[np.generic]]


class _Clock(NamedTuple):
    """What an array says of when others were sampled: their rate, Hz, and start, s, None where it does not say."""

    name: str
    rate: float
    start: float | None


def channels_of(file: Path, arrays: Mapping[str, NDArray[np.generic]], units: Mapping[str, str]) -> Channels:
    """Return the channels among arrays: every array of numbers with three samples or more.

    A sampling rate is a single number called ``sampling_rate``, ``fs`` and the like, Hz, a step ``dt``, s, or an array
    ``time`` or ``t``, s, at even steps, or in the unit that `units` has for it. It holds for what stands in the same
    group, unless a group within has another. Of an array with two axes the longer one is time; its channels are
    numbered.

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
        When time runs unevenly, a rate or a time has a wrong unit, a channel has several rates, or there is no channel.
    """
    numeric = {name: np.asarray(values) for name, values in arrays.items() if np.asarray(values).dtype.kind in "fiu"}
    channels: list[Channel] = []
    clocks = _Clocks(file, numeric, units)
    for name, values in numeric.items():
        if values.ndim > 2 or values.size < _FEWEST or _last(name) in _TIMES or ATTRIBUTE in name:
            continue
        clock = clocks.of(name)
        when = (clock.rate, clock.start) if clock else (None, None)
        channels += [Channel(full, as_samples(row), units.get(name), *when) for full, row in _rows(name, values)]
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


class _Clocks:
    """What the arrays of a file say of when others were sampled, by the group in which it stands."""

    def __init__(self, file: Path, arrays: _Arrays, units: Mapping[str, str]) -> None:
        self.file, self.arrays, self.units = file, arrays, units
        self.places: dict[str, list[str]] = {}
        for name in arrays:
            stem, slash, _ = name.rpartition("/")
            self.places.setdefault(stem + slash, []).append(name)
        self.known: dict[tuple[str, int], list[_Clock]] = {}

    def of(self, name: str) -> _Clock | None:
        """Return rate and start of a channel, as the nearest group around it says; or else as all others in the file.

        The attributes of the array itself come first, then what stands in its group and the group's attributes, and so
        on outwards.
        """
        size, group = max(self.arrays[name].shape), name
        levels = [[f"{name}{ATTRIBUTE}"]]
        while group:
            group = group.rpartition("/")[0]
            levels.append([f"{group}/" if group else "", f"{group}{ATTRIBUTE}"])
        # attributes of another array are of no concern
        levels.append([place for place in self.places if place.removesuffix(ATTRIBUTE) not in self.arrays])
        for level in levels:
            if clocks := [clock for place in level for clock in self._at(place, size)]:
                self._refuse_different(name, clocks)
                return clocks[0]
        return None

    def _refuse_different(self, name: str, clocks: Sequence[_Clock]) -> None:
        rates = [clock.rate for clock in clocks]
        if max(rates) > (1 + _RATE_AGREEMENT) * min(rates):
            listed = ", ".join(f"{clock.rate:.6g} Hz by '{clock.name}'" for clock in clocks)
            text = f"states different sampling rates for '{name}': {listed}"
            raise InputError(Problem(f"{text}; export one of them, in the group of its channels", file=self.file))

    def _at(self, place: str, size: int) -> list[_Clock]:
        """Return what stands right at a place and says a rate for arrays of a size: rates, then steps, then times."""
        if (place, size) not in self.known:
            names = self.places.get(place, [])
            times = [name for name in names if _last(name) in _TIMES and self.arrays[name].size >= _FEWEST]
            times = [name for name in times if self.arrays[name].size == size] or times
            axes = [self._of_times(name) for name in times]
            start = axes[0].start if axes else None
            rates = [_Clock(name, number, start) for name, number in self._numbers(names, _RATES, "Hz")]
            steps = [_Clock(name, 1.0 / number, start) for name, number in self._numbers(names, _STEPS, "s")]
            self.known[place, size] = rates + steps + axes
        return self.known[place, size]

    def _numbers(self, names: Sequence[str], wanted: Sequence[str], unit: str) -> list[tuple[str, float]]:
        """Return the single numbers above 0 that are called so, in Hz or s."""
        single = [(name, float(self.arrays[name].ravel()[0])) for name in names if self.arrays[name].size == 1]
        ordered = sorted((wanted.index(_last(name)), name, x) for name, x in single if _last(name) in wanted and x > 0)
        return [(name, x * self._factor(name, unit)) for _, name, x in ordered]

    def _factor(self, name: str, wanted: str) -> float:
        """Return the factor to Hz or s from the unit that the file states for a rate or for times."""
        unit = _SAMPLES.sub("1/s", self.units.get(name, wanted).strip())
        try:
            return Header(name, _last(name), unit).factor(wanted)
        except ValueError as error:
            raise InputError(Problem(str(error), file=self.file)) from None

    def _of_times(self, name: str) -> _Clock:
        time = as_samples(self.arrays[name]) * self._factor(name, "s")
        step = float(time[-1] - time[0]) / (time.size - 1)
        if not step > 0 or np.max(np.abs(np.diff(time) - step)) > _EVEN * step + 1e-12 * float(np.abs(time[-1])):
            text = "its array of times does not rise in even steps; export samples at even steps"
            raise InputError(Problem(text, file=self.file))
        return _Clock(name, rate_of_step(step), float(time[0]))
