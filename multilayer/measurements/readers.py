"""Readers of recordings, found by file suffix."""

from __future__ import annotations

from pathlib import Path

from multilayer.errors import InputError, Problem
from multilayer.measurements.recording import Reader, Waveforms
from multilayer.registry import Registry

READERS: Registry[Reader] = Registry("multilayer.readers", "reader")


def read_waveforms(path: Path | str) -> Waveforms:
    """Return what a file holds, through the reader of its suffix.

    Raises
    ------
    InputError
        When the file is missing, has a suffix nobody reads, or is refused by its reader.
    """
    file = Path(path)
    suffix = file.suffix.removeprefix(".").lower()
    if suffix not in READERS:
        known = ", ".join(f".{name}" for name in READERS)
        raise InputError(Problem(f"nothing reads '{file.suffix}' files; save the signals as one of {known}", file=file))
    if not file.is_file():
        raise InputError(Problem("there is no such file", file=file))
    return READERS[suffix](file)
