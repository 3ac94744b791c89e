"""Readers of waveforms and of spectra, found by file suffix."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.bounds import FILE_BYTES, OF_OTHER_UNITS, magnitudes
from multilayer.errors import InputError, Problem, show
from multilayer.files import is_file
from multilayer.measurements.accelerometers import acceleration_factor
from multilayer.measurements.spectra import Spectra
from multilayer.registry import Registry
from multilayer.signals.channels import Channel, Channels, refuse_other_starts
from multilayer.signals.recording import Waveforms
from multilayer.tables import Table, read_text_table
from multilayer.writing.manifest import note_input

_BURST = re.compile(r"(base|top)(_\d+)?")
_EXPECTED = "'time', 'base' and 'top', or 'time', 'base_1', 'top_1', 'base_2', 'top_2', ..."


@dataclass(frozen=True)
class Reader:
    """The two functions that read files of a format which may hold signals over time or values over frequency.

    A format whose files hold only one of the two, or say which, needs no `Reader` but a function.

    Attributes
    ----------
    waveforms : callable
        From a path to `Waveforms` (one burst) or `Channels` (whatever a recorder stored).
    spectra : callable
        From a path to `Spectra`, or to a `Table` where the file has lines.
    """

    waveforms: Callable[[Path], Waveforms | Channels]
    spectra: Callable[[Path], Spectra | Table]


ReadFunction: TypeAlias = Callable[[Path], Waveforms | Channels | Spectra | Table]
"""Entry points of ``multilayer.readers`` are such functions, or a `Reader`, under the file suffix they read."""


def _reader_fault(name: str, item: object) -> str:
    if (suffix := _suffix(Path(f"file.{name}"))) != name:
        return f"readers are found by the last suffix of a file, in small letters; call it '{suffix}'"
    if callable(item) or isinstance(item, Reader):
        return ""
    return f"it is {item!r}, not a function from a path to Waveforms, Channels or Spectra, nor a Reader"


READERS: Registry[Reader | ReadFunction] = Registry("multilayer.readers", "reader", _reader_fault)


def _suffix(file: Path) -> str:
    return file.suffix.removeprefix(".").lower()


def _content(file: Path, what: Literal["waveforms", "spectra"]) -> Waveforms | Channels | Spectra | Table:
    """Return what the reader of a file's suffix finds in it; the file must exist, and the reader keep its word."""
    if not is_file(file):
        raise InputError(Problem("there is no such file", file=file))
    FILE_BYTES.check(file.stat().st_size, file, "cut it into several files")
    note_input(file)
    suffix = _suffix(file)
    reader = READERS[suffix]
    if isinstance(reader, Reader):
        reader = reader.waveforms if what == "waveforms" else reader.spectra
    content = reader(file)
    if fault := _content_fault(content):
        text = f"the reader '{suffix}' of {READERS.origins(suffix)[0]} is at fault, not the file: {fault}"
        raise InputError(Problem(text, file=file))
    return content


def _content_fault(content: object) -> str:
    """Tell what is wrong with the types of what a reader returns; empty where nothing is."""
    if isinstance(content, Waveforms):
        return _samples_fault("base", content.base, 2) or _samples_fault("top", content.top, 2)
    if isinstance(content, Channels):
        return next(filter(None, (_samples_fault(one.name, one.samples, 1) for one in content.channels)), "")
    if isinstance(content, Spectra | Table):
        return ""
    return f"what it returns is {_told(content)}, and must be Waveforms, Channels, Spectra or a Table"


def _samples_fault(name: str, samples: object, axes: int) -> str:
    if isinstance(samples, np.ndarray) and samples.ndim == axes and samples.dtype.kind in "fiu":
        return ""
    shape = "(repeats, samples)" if axes == 2 else "(samples,)"
    return f"{show(name)} is {_told(samples)}, and must be a NumPy array of real numbers of shape {shape}"


def _told(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"an array of {value.dtype} of shape {value.shape}"
    return f"of type {type(value).__name__}"


def read_spectra(path: Path | str) -> Table:
    """Return what a file holds over frequency as columns: through the reader of its suffix, else as a text table.

    Raises
    ------
    InputError
        When the file is missing, is refused by its reader, or holds signals over time.
    """
    file = Path(path)
    if _suffix(file) not in READERS:
        return read_text_table(file)
    content = _content(file, "spectra")
    if isinstance(content, Spectra):
        return content.table(file)
    if isinstance(content, Table):
        return content
    text = "is read as signals over time, and values over frequency are wanted; save those as a text table"
    raise InputError(Problem(text, file=file))


def _read(path: Path | str) -> Waveforms | Channels:
    file = Path(path)
    if _suffix(file) not in READERS:
        known = ", ".join(f".{name}" for name in READERS)
        raise InputError(Problem(f"nothing reads '{file.suffix}' files; save the signals as one of {known}", file=file))
    content = _content(file, "waveforms")
    if isinstance(content, Waveforms | Channels):
        _refuse_absurd(content, file)
        return content
    raise InputError(Problem("is read as values over frequency, and signals over time are wanted", file=file))


def _refuse_absurd(content: Waveforms | Channels, file: Path) -> None:
    """Refuse samples that are no measured values, as flipped bits make them, and sampling rates that are none."""
    signals = (
        [("base", content.base), ("top", content.top)]
        if isinstance(content, Waveforms)
        else [(channel.name, channel.samples) for channel in content.channels]
    )
    for name, samples in signals:
        largest = float(np.max(np.abs(samples), initial=0.0, where=np.isfinite(samples)))
        if largest > OF_OTHER_UNITS.most:
            text = f"{show(name)} holds values as large as {largest:.3g}: it is damaged, or read as another type"
            raise InputError(Problem(f"{text}; export it again", file=file))
    rates = [content.sampling_rate] if isinstance(content, Waveforms) else [c.sampling_rate for c in content.channels]
    for rate in rates:
        if rate is not None and (refusal := magnitudes("Hz").refusal(rate, "Hz")):
            text = f"a sampling rate of {rate:.6g} Hz is not allowed: it {refusal}; export it again"
            raise InputError(Problem(text, file=file))


def read_channels(path: Path | str) -> Channels:
    """Return all channels of a file, through the reader of its suffix.

    Those of a burst are called ``base`` and ``top``, or ``base_1``, ``top_1``, ``base_2`` and so on, in m/s^2.

    Raises
    ------
    InputError
        When the file is missing, has a suffix nobody reads, or is refused by its reader.
    """
    content = _read(path)
    if isinstance(content, Channels):
        return content
    repeats = len(content.base)
    pairs = [("base", content.base), ("top", content.top)]
    channels = tuple(
        Channel(name if repeats == 1 else f"{name}_{i + 1}", signals[i], "m/s^2", content.sampling_rate)
        for i in range(repeats)
        for name, signals in pairs
    )
    return Channels(Path(path), channels)


def read_waveforms(path: Path | str) -> Waveforms:
    """Return the burst that a file holds, through the reader of its suffix.

    Of several channels, all must be called `base` and `top`, or repeats of them `base_1`, `top_1`, `base_2` and so on;
    their unit is m/s^2, or another acceleration that they state.

    Raises
    ------
    InputError
        When the file is missing, has a suffix nobody reads, is refused by its reader, or holds other channels.
    """
    content = _read(path)
    return content if isinstance(content, Waveforms) else _burst(content)


def _burst(channels: Channels) -> Waveforms:
    by_name = {channel.name.casefold(): channel for channel in channels.channels}
    suffixes = _repeats(channels, list(by_name))
    columns = {name: [by_name[f"{name}{suffix}"] for suffix in suffixes] for name in ("base", "top")}
    chosen = [*columns["base"], *columns["top"]]
    if len({(channel.samples.size, channel.sampling_rate) for channel in chosen}) > 1:
        raise channels.error(f"its channels differ in length or sampling rate: {channels}; record them together")
    for pair in zip(columns["base"], columns["top"], strict=True):
        refuse_other_starts(channels, pair)
    base, top = (np.stack([_acceleration(channels, channel) for channel in columns[name]]) for name in ("base", "top"))
    return Waveforms(base, top, chosen[0].sampling_rate)


def _acceleration(channels: Channels, channel: Channel) -> RealArray:
    factor = 1.0 if channel.unit is None else acceleration_factor(channel.unit)
    if factor is None:
        text = f"channel '{channel.name}' is in {channel.unit}, which is no acceleration"
        raise channels.error(f"{text}; a campaign is made of such files by `multilayer import`, with --sensitivity")
    return channel.samples * factor


def _repeats(channels: Channels, names: list[str]) -> list[str]:
    """Return the suffixes of the repeats, as ``["_1", "_2"]`` or ``[""]``."""
    unknown = [name for name in names if not _BURST.fullmatch(name)]
    if unknown:
        remedy = f"name the {_what(channels)}s {_EXPECTED}, or make a campaign of such files by `multilayer import`"
        raise channels.error(f"{_what(channels)} '{unknown[0]}' is not known; {remedy}")
    suffixes = {name.removeprefix("base").removeprefix("top") for name in names}
    ordered = sorted(suffixes, key=lambda suffix: int(suffix[1:] or 0)) or [""]
    missing = [f"{name}{suffix}" for suffix in ordered for name in ("base", "top") if f"{name}{suffix}" not in names]
    if missing:
        raise channels.error(f"has no {_what(channels)} {', '.join(missing)}; name the {_what(channels)}s {_EXPECTED}")
    return ordered


def _what(channels: Channels) -> str:
    return "channel" if channels.line is None else "column"
