"""NI TDMS files, which LabVIEW and other programs of National Instruments write."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.bounds import CHANNELS, DATA_VALUES
from multilayer.errors import InputError, Problem
from multilayer.measurements.reading import damaged, library, reads
from multilayer.signals.channels import Channel, Channels, as_samples, different

_KIND = "a TDMS file"
_SIGNATURE = b"TDSm"


def read_tdms(path: Path | str) -> Channels:
    """Read a ``.tdms`` file through npTDMS.

    A channel's rate is that of its waveform (``wf_increment``), its start the sum of ``wf_start_time`` and
    ``wf_start_offset``, its unit ``unit_string``. It is called by its own name, or ``GROUP/NAME`` where two groups have
    a channel of one name.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When npTDMS is not installed, or the file is damaged, cut short, or holds no numbers.
    """
    file = Path(path)
    nptdms = library("nptdms", file)
    with reads(file, _KIND), _no_warnings_logged():
        _refuse_other_kind(file)
        _refuse_large(nptdms.TdmsFile.read_metadata(file), file)
        tdms = nptdms.TdmsFile.read(file)
        if tdms.file_status.incomplete_final_segment:
            raise damaged(file, _KIND, "its last segment is incomplete")
        numeric = [channel for group in tdms.groups() for channel in group.channels() if _is_numeric(channel)]
        names = different(
            [channel.name for channel in numeric], [f"{channel.group_name}/{channel.name}" for channel in numeric]
        )
        times = [channel.properties["wf_start_time"] for channel in numeric if "wf_start_time" in channel.properties]
        earliest = min(times) if times else None
        channels = tuple(_channel(name, channel, earliest) for name, channel in zip(names, numeric, strict=True))
    if not channels:
        raise InputError(Problem("holds no channel of numbers", file=file))
    return Channels(file, channels)


@contextmanager
def _no_warnings_logged() -> Iterator[None]:
    """Take what npTDMS logs about damaged files, and then goes on with, for an error."""
    loggers = [logging.getLogger(name) for name in logging.root.manager.loggerDict if name.split(".")[0] == "nptdms"]
    for logger in loggers:
        logger.addFilter(_refused)
    try:
        yield
    finally:
        for logger in loggers:
            logger.removeFilter(_refused)


def _refused(record: logging.LogRecord) -> bool:
    if record.levelno >= logging.WARNING:
        raise ValueError(record.getMessage())
    return True


def _refuse_other_kind(file: Path) -> None:
    """Refuse what does not begin as a TDMS file does; npTDMS takes a few bytes of anything for an empty one."""
    with file.open("rb") as stream:
        if stream.read(len(_SIGNATURE)) != _SIGNATURE:
            raise damaged(file, _KIND, "it does not begin like one")


def _refuse_large(metadata: Any, file: Path) -> None:
    """Refuse more samples than are taken, from what the segments claim to hold."""
    lengths = [len(channel) for group in metadata.groups() for channel in group.channels()]
    CHANNELS.check(len(lengths), file)
    DATA_VALUES.check(sum(lengths), file)


def _is_numeric(channel: Any) -> bool:
    return len(channel) > 0 and channel.dtype.kind in "fiu"


def _channel(name: str, channel: Any, earliest: Any) -> Channel:
    samples = as_samples(channel[:])
    if samples.size != len(channel):
        raise ValueError(f"'{name}' has {samples.size} of {len(channel)} samples")
    step = float(channel.properties.get("wf_increment", 0.0))
    unit = str(channel.properties.get("unit_string", "")).strip() or None
    return Channel(name, samples, unit, 1.0 / step if step > 0 else None, _start(channel.properties, earliest))


def _start(properties: Any, earliest: Any) -> float | None:
    """Return the time of a channel's first sample after the earliest start in the file, s; None where it says none."""
    time = properties.get("wf_start_time")
    offset = properties.get("wf_start_offset")
    if (time is None) != (earliest is None) or (time is None and offset is None):
        return None
    since = 0.0 if time is None else float((time - earliest) / np.timedelta64(1, "s"))
    return since + float(offset or 0.0)
