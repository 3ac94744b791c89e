"""Recordings as tables of text."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.recording import Waveforms

_CHANNEL = re.compile(r"(base|top)(_\d+)?")
_EXPECTED = "'time', 'base' and 'top', or 'time', 'base_1', 'top_1', 'base_2', 'top_2', ..."
# times are often printed with few digits; a missing sample makes a step of twice the others
_STEP_TOLERANCE = 0.3


def read_csv(path: Path | str) -> Waveforms:
    """Read a text table with the columns `time`, `base` and `top`.

    Columns are separated by commas, semicolons, tabs or blanks, and named in the first line; what follows a
    ``#`` is no data. Repeats have columns of their own, `base_1`, `top_1`, `base_2`, `top_2` and so on. Time
    in s with equal steps, which give the sampling rate; accelerations in m/s^2, with a decimal point.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        With file and line, when the file is not text, a column is missing, unknown or there twice, a row is
        short or long, a cell is no number, or the time does not run in equal steps.
    """
    file = Path(path)
    lines = _data_lines(file)
    if not lines:
        raise _error(file, f"is empty; its first line must name the columns: {_EXPECTED}")
    number, header = lines[0]
    separator = next((mark for mark in (";", ",", "\t") if mark in header), None)
    names = [name.strip().strip('"').lower() for name in header.split(separator)]
    repeats = _repeats(names, file, number)
    table = _table(lines[1:], separator, len(names), file)
    rate = _sampling_rate(table[:, names.index("time")], [line for line, _ in lines[1:]], file)
    base, top = (table[:, [names.index(f"{channel}{suffix}") for suffix in repeats]].T for channel in ("base", "top"))
    return Waveforms(np.ascontiguousarray(base), np.ascontiguousarray(top), rate)


def _error(file: Path, message: str, line: int | None = None) -> InputError:
    return InputError(Problem(message, file=file, line=line))


def _data_lines(file: Path) -> list[tuple[int, str]]:
    """Return the lines that are neither blank nor comments, with their numbers from 1."""
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise _error(file, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise _error(file, f"is no text that can be read ({error}); export it again as UTF-8") from None
    stripped = ((number, line.partition("#")[0].strip()) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, line) for number, line in stripped if line]


def _repeats(names: Sequence[str], file: Path, line: int) -> list[str]:
    """Return the suffixes of the repeats, as ``["_1", "_2"]`` or ``[""]``."""
    unknown = [name for name in names if name != "time" and not _CHANNEL.fullmatch(name)]
    if unknown:
        raise _error(file, f"column '{unknown[0]}' is not known; name the columns {_EXPECTED}", line)
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise _error(file, f"column '{twice[0]}' is there twice; number the repeats: {_EXPECTED}", line)
    found = {name.removeprefix("base").removeprefix("top") for name in names if name != "time"}
    suffixes = sorted(found, key=lambda suffix: int(suffix[1:] or 0)) or [""]
    needed = ["time", *(f"{channel}{suffix}" for suffix in suffixes for channel in ("base", "top"))]
    missing = [name for name in needed if name not in names]
    if missing:
        raise _error(file, f"has no column {', '.join(missing)}; name the columns {_EXPECTED}", line)
    return suffixes


def _table(lines: Sequence[tuple[int, str]], separator: str | None, n_columns: int, file: Path) -> RealArray:
    if len(lines) < 3:
        raise _error(file, f"holds {len(lines)} rows of samples; a recording needs more")
    table = np.empty((len(lines), n_columns))
    for row, (number, line) in zip(table, lines, strict=True):
        cells = line.split(separator)
        if len(cells) != n_columns:
            raise _error(file, f"has {len(cells)} cells where {n_columns} columns are named", number)
        row[:] = [_number(cell, file, number) for cell in cells]
    return table


def _number(cell: str, file: Path, line: int) -> float:
    try:
        return float(cell)
    except ValueError:
        comma = "; write decimals with a point" if "," in cell else ""
        raise _error(file, f"'{cell.strip()}' is no number{comma}", line) from None


def _sampling_rate(time: RealArray, line_numbers: Sequence[int], file: Path) -> float:
    step = (time[-1] - time[0]) / (time.size - 1)
    if not (np.isfinite(time).all() and step > 0):
        raise _error(file, "time does not rise from the first row to the last; it must be in s, in equal steps")
    steps = np.diff(time)
    usual = float(np.median(steps))
    uneven = np.flatnonzero(np.abs(steps - usual) > _STEP_TOLERANCE * usual)
    if uneven.size:
        first = int(uneven[0])
        raise _error(
            file,
            f"time steps by {steps[first]:.6g} s here and by {usual:.6g} s elsewhere; samples are missing or "
            "the time is printed with too few digits",
            line_numbers[first + 1],
        )
    return float(1.0 / step)
