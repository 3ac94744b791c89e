"""Recordings as tables of text: CSV of data recorders and of spreadsheets."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.accelerometers import acceleration_factor, voltage_factor
from multilayer.measurements.channels import Channel, Channels, rate_of_step
from multilayer.units import parse_quantity

_SEPARATORS = (";", "\t", ",", None)
_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_TIME = re.compile(r"(?:time|t|zeit)(?:_(?P<unit>s|ms|us))?", re.IGNORECASE)
_HINT = re.compile(r"sep=.?")  # ahead of the header, for spreadsheets
_PREAMBLE = 60  # lines that programs write ahead of a header, at most
# times are often printed with few digits; a missing sample makes a step of twice the others
_STEP_TOLERANCE = 0.3

Line = tuple[int, str]  # its number from 1, and its text


@dataclass(frozen=True)
class _Layout:
    """Where a table stands: its separator, the index of its header, and how many lines of units follow."""

    separator: str | None
    header: int
    n_units: int = 0

    @property
    def first(self) -> int:
        """Index of the first line of samples."""
        return self.header + 1 + self.n_units

    def cells(self, line: str) -> list[str]:
        return [cell.strip().strip('"').strip() for cell in line.split(self.separator)]


def read_csv(path: Path | str) -> Channels:
    """Read a text table of samples, a column for each channel.

    Columns are separated by semicolons, tabs, commas or blanks, and named in the last line ahead of the numbers, with
    units in brackets (``base [m/s^2]``) or in a line of their own below; what programs write above is left alone, as is
    what follows a ``#``. Decimals have a point, or a comma where columns are separated by something else. A column
    `time` (or `t`; s unless it says another unit) has equal steps, which give the sampling rate.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        With file and line, when the file is not text, no line names the columns, a name is there twice, a row is short
        or long, a cell is no number, or the time does not run in equal steps.
    """
    file = Path(path)
    lines = _data_lines(file)
    if not lines:
        raise _error(file, "is empty; its first line must name the columns, as 'time', 'base' and 'top'")
    layout = _layout(lines)
    number = lines[layout.header][0]
    headers = layout.cells(lines[layout.header][1])
    if all(_is_number(cell, layout.separator) for cell in headers):
        raise _error(file, "no line names the columns; write names above the numbers, as 'time', 'base', 'top'", number)
    rows = lines[layout.first :]
    table = _table(rows, layout, len(headers), file)
    named = _named(headers, layout.cells(lines[layout.header + 1][1]) if layout.n_units else None)
    kept = [i for i, (name, _) in enumerate(named) if name]
    _refuse_twice([named[i][0] for i in kept], file, number)
    time = next((i for i in kept if _TIME.fullmatch(named[i][0])), None)
    rate = None
    if time is not None:
        unit = named[time][1] or _time_suffix(named[time][0])
        rate = _sampling_rate(table[:, time] * _seconds(unit, file, number), [line for line, _ in rows], file)
    columns = [Channel(*named[i][:1], np.ascontiguousarray(table[:, i]), named[i][1], rate) for i in kept if i != time]
    return Channels(file, tuple(columns), number)


def _error(file: Path, message: str, line: int | None = None) -> InputError:
    return InputError(Problem(message, file=file, line=line))


def _data_lines(file: Path) -> list[Line]:
    """Return the lines that are neither blank nor comments."""
    try:
        text = _decoded(file.read_bytes())
    except FileNotFoundError:
        raise _error(file, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise _error(file, f"is no text that can be read ({error}); export it again as UTF-8") from None
    stripped = ((number, line.partition("#")[0].strip(" ")) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, line) for number, line in stripped if line.strip() and not _HINT.fullmatch(line)]


def _decoded(raw: bytes) -> str:
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        return raw.decode("utf-16")  # "Unicode text" of spreadsheets
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        if b"\0" in raw:
            raise
        text = raw.decode("cp1252")  # "CSV" of spreadsheets
    if "\0" in text:
        raise UnicodeDecodeError("utf-8", raw, raw.index(b"\0"), raw.index(b"\0") + 1, "a zero byte")
    return text


def _layout(lines: Sequence[Line]) -> _Layout:
    """Return where the table stands; at the first line, as far as its header tells, where no two rows are numbers."""
    for separator in _SEPARATORS:
        layout = _Layout(separator, 0)
        above = [layout.cells(text) for _, text in lines[: _PREAMBLE + 2]]
        for i, (cells, after) in enumerate(pairwise(above)):
            if not all(_is_row(row, separator) for row in (cells, after)) or len(cells) != len(after):
                continue
            if (
                i
                and len(above[i - 1]) == len(cells)
                and (separator is None or len(cells) > 1 or "," not in lines[i][1])
            ):
                has_units = i > 1 and len(above[i - 2]) == len(cells) and all(_is_unit(cell) for cell in above[i - 1])
                return _Layout(separator, i - 1 - has_units, int(has_units))
            break
    header = lines[0][1]
    return _Layout(next((mark for mark in (";", ",", "\t") if mark in header), None), 0)


def _is_row(cells: Sequence[str], separator: str | None) -> bool:
    return any(cells) and all(not cell or _is_number(cell, separator) for cell in cells)


def _is_number(cell: str, separator: str | None) -> bool:
    try:
        float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        return False
    return True


def _is_unit(cell: str) -> bool:
    text = cell.strip("[]() ")
    known = text in ("", "-", "s", "ms", "us", "µs")
    return known or acceleration_factor(text) is not None or voltage_factor(text) is not None


def _named(headers: Sequence[str], units: Sequence[str] | None) -> list[tuple[str, str | None]]:
    """Return name and unit of every column."""
    if units is not None:
        return [(name, unit.strip("[]() ") or None) for name, unit in zip(headers, units, strict=True)]
    matches = [_HEADER.fullmatch(header) for header in headers]
    pairs = zip(matches, headers, strict=True)
    return [(match["name"], match["unit"] or None) if match else (header, None) for match, header in pairs]


def _refuse_twice(names: Sequence[str], file: Path, line: int) -> None:
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise _error(
            file, f"column '{twice[0]}' is there twice; number the repeats, as base_1, top_1, base_2, top_2", line
        )


def _table(lines: Sequence[Line], layout: _Layout, n_columns: int, file: Path) -> RealArray:
    if len(lines) < 3:
        raise _error(file, f"holds {len(lines)} rows of samples; a recording needs more")
    fast = _fast_table([text for _, text in lines], layout, n_columns)
    if fast is not None:
        return fast
    table = np.full((len(lines), n_columns), np.nan)
    empty = _unnamed_ends(layout, lines)
    for row, (number, line) in zip(table, lines, strict=True):
        cells = layout.cells(line)
        if len(cells) != n_columns:
            raise _error(file, f"has {len(cells)} cells where {n_columns} columns are named", number)
        row[: n_columns - empty] = [
            _number(cell, layout.separator, file, number) for cell in cells[: n_columns - empty]
        ]
    return table


def _fast_table(lines: list[str], layout: _Layout, n_columns: int) -> RealArray | None:
    """Return the table as NumPy reads it, None where it does not: long recordings take a tenth of the time."""
    points = lines if layout.separator == "," else (line.replace(",", ".") for line in lines)
    try:
        table = np.loadtxt(points, delimiter=layout.separator, ndmin=2, comments=None)
    except ValueError:
        return None
    return table if table.shape == (len(lines), n_columns) else None


def _unnamed_ends(layout: _Layout, lines: Sequence[Line]) -> int:
    """Return how many columns at the end are empty in the first rows: separators that end every line."""
    ends = 0
    for cells in zip(*(reversed(layout.cells(text)) for _, text in lines[:3]), strict=False):
        if any(cells):
            break
        ends += 1
    return ends


def _number(cell: str, separator: str | None, file: Path, line: int) -> float:
    try:
        return float(cell if separator == "," else cell.replace(",", "."))
    except ValueError:
        raise _error(file, f"'{cell.strip()}' is no number", line) from None


def _time_suffix(name: str) -> str | None:
    match = _TIME.fullmatch(name)
    return match["unit"] if match else None


def _seconds(unit: str | None, file: Path, line: int) -> float:
    try:
        return parse_quantity(f"1 {unit or 's'}", "s")
    except ValueError:
        raise _error(file, f"'{unit}' is no unit of time; write 'time [s]' or 'time [ms]'", line) from None


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
    return rate_of_step(float(step))
