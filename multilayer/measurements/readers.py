"""Readers of recordings, found by file suffix."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.accelerometers import acceleration_factor
from multilayer.registry import Registry
from multilayer.signals.channels import Channel, Channels
from multilayer.signals.recording import Reader, Waveforms

_BURST = re.compile(r"(base|top)(_\d+)?")
_EXPECTED = "'time', 'base' and 'top', or 'time', 'base_1', 'top_1', 'base_2', 'top_2', ..."


def _reader_fault(name: str, item: object) -> str:
    del name  # the suffix it reads; a function needs not know
    return "" if callable(item) else f"it is {item!r}, not a function from a path to Waveforms"


READERS: Registry[Reader] = Registry("multilayer.readers", "reader", _reader_fault)


def _read(path: Path | str) -> Waveforms | Channels:
    file = Path(path)
    suffix = file.suffix.removeprefix(".").lower()
    if suffix not in READERS:
        known = ", ".join(f".{name}" for name in READERS)
        raise InputError(Problem(f"nothing reads '{file.suffix}' files; save the signals as one of {known}", file=file))
    if not file.is_file():
        raise InputError(Problem("there is no such file", file=file))
    return READERS[suffix](file)


def read_channels(path: Path | str) -> Channels:
    """Return all channels of a file, through the reader of its suffix.

    Those of a burst are called ``base`` and ``top``, or ``base_1``, ``top_1``, ``base_2`` and so on, in m/s^2.

    Raises
    ------
    InputError
        When the file is missing, has a suffix nobody reads, or is refused by its reader.
    """
    found = _read(path)
    if isinstance(found, Channels):
        return found
    repeats = len(found.base)
    pairs = [("base", found.base), ("top", found.top)]
    channels = tuple(
        Channel(name if repeats == 1 else f"{name}_{i + 1}", signals[i], "m/s^2", found.sampling_rate)
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
    found = _read(path)
    return found if isinstance(found, Waveforms) else _burst(found)


def _burst(found: Channels) -> Waveforms:
    by_name = {channel.name.casefold(): channel for channel in found.channels}
    suffixes = _repeats(found, list(by_name))
    columns = {name: [by_name[f"{name}{suffix}"] for suffix in suffixes] for name in ("base", "top")}
    chosen = [*columns["base"], *columns["top"]]
    if len({(channel.samples.size, channel.sampling_rate) for channel in chosen}) > 1:
        raise found.error(f"its channels differ in length or sampling rate: {found}; record them together")
    base, top = (np.stack([_acceleration(found, one) for one in columns[name]]) for name in ("base", "top"))
    return Waveforms(base, top, chosen[0].sampling_rate)


def _acceleration(found: Channels, channel: Channel) -> RealArray:
    factor = 1.0 if channel.unit is None else acceleration_factor(channel.unit)
    if factor is None:
        text = f"channel '{channel.name}' is in {channel.unit}, which is no acceleration"
        raise found.error(f"{text}; a campaign is made of such files by `multilayer import`, with --sensitivity")
    return channel.samples * factor


def _repeats(found: Channels, names: list[str]) -> list[str]:
    """Return the suffixes of the repeats, as ``["_1", "_2"]`` or ``[""]``."""
    unknown = [name for name in names if not _BURST.fullmatch(name)]
    if unknown:
        remedy = f"name the {_what(found)}s {_EXPECTED}, or make a campaign of such files by `multilayer import`"
        raise found.error(f"{_what(found)} '{unknown[0]}' is not known; {remedy}")
    suffixes = {name.removeprefix("base").removeprefix("top") for name in names}
    ordered = sorted(suffixes, key=lambda suffix: int(suffix[1:] or 0)) or [""]
    missing = [f"{one}{suffix}" for suffix in ordered for one in ("base", "top") if f"{one}{suffix}" not in names]
    if missing:
        raise found.error(f"has no {_what(found)} {', '.join(missing)}; name the {_what(found)}s {_EXPECTED}")
    return ordered


def _what(found: Channels) -> str:
    return "channel" if found.line is None else "column"
