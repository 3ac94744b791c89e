"""Tables of text: CSV of data recorders and of spreadsheets."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.bounds import CHANNELS
from multilayer.errors import InputError, Problem, show
from multilayer.measurements.readers import Reader
from multilayer.measurements.text_layout import layout_of
from multilayer.signals.channels import Channel, Channels, rate_of_step
from multilayer.tables import name_and_unit, other_width, read_text_table
from multilayer.text_lines import Layout, Line, data_lines
from multilayer.units import parse_quantity

_TIME = re.compile(r"(?:time|t|zeit)(?:_(?P<unit>s|ms|us))?", re.IGNORECASE)
_EXAMPLE = "as 'time', 'base' and 'top'"
# times are often printed with few digits; a missing sample makes a step of twice the others
_STEP_TOLERANCE = 0.3

Named = tuple[str, str | None]  # a column's name and unit


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
    lines = data_lines(file)
    if not lines:
        raise _error(file, f"is empty; its first line must name the columns, {_EXAMPLE}")
    layout = layout_of(lines)
    line = lines[layout.header][0]
    named = _names(lines, layout, file)
    rows = lines[layout.first :]
    layout.refuse_two_marks(rows, file)
    columns = dict(zip(named, _table(rows, layout, len(named), file).T, strict=True))
    time = next((column for column in named if _TIME.fullmatch(column[0])), None)
    rate = None
    if time is not None:
        rate = _sampling_rate(columns[time] * _seconds(time, file, line), [number for number, _ in rows], file)
    kept = [column for column in named if column[0] and column != time]
    channels = tuple(Channel(name, np.ascontiguousarray(columns[name, unit]), unit, rate) for name, unit in kept)
    return Channels(file, channels, line)


def _error(file: Path, message: str, line: int | None = None) -> InputError:
    return InputError(Problem(message, file=file, line=line))


def _names(lines: Sequence[Line], layout: Layout, file: Path) -> list[Named]:
    """Return name and unit of every column; both empty where a separator ends all lines."""
    line, header = lines[layout.header]
    cells = layout.cells(header)
    if all(layout.is_number(cell) for cell in cells):
        raise _error(file, f"no line names the columns; write names above the numbers, {_EXAMPLE}", line)
    split = [name_and_unit(cell) or (cell, None) for cell in cells]
    named: list[Named] = [(name, unit or None) for name, unit in split]
    if layout.n_units:
        units = layout.cells(lines[layout.header + 1][1])
        named = [(cell, unit.strip("[]() ") or None) for cell, unit in zip(cells, units, strict=True)]
    names = [name for name, _ in named]
    CHANNELS.check(len(names), file)
    twice = sorted(name for name, count in Counter(names).items() if count > 1)
    if twice:
        what = f"column '{twice[0]}' is there twice" if twice[0] else "several columns have no name"
        raise _error(file, f"{what}; number the repeats, as base_1, top_1, base_2, top_2", line)
    return named


def _table(lines: Sequence[Line], layout: Layout, n_columns: int, file: Path) -> RealArray:
    if len(lines) < 3:
        raise _error(file, f"holds {len(lines)} rows of samples; a recording needs more")
    fast = _fast_table(lines, layout, n_columns)
    if fast is not None:
        return fast
    table = np.full((len(lines), n_columns), np.nan)
    ends_empty = not any(layout.cells(text)[-1] for _, text in lines[:3])  # a separator at the end of every line
    kept = n_columns - ends_empty
    for row, (number, line) in zip(table, lines, strict=True):
        cells = layout.cells(line)
        if len(cells) != n_columns:
            raise _error(file, other_width(len(cells), n_columns), number)
        row[:kept] = [_number(cell, layout, file, number) for cell in cells[:kept]]
    return table


def _fast_table(lines: Sequence[Line], layout: Layout, n_columns: int) -> RealArray | None:
    """Return the table as NumPy reads it, None where it does not: long recordings take a tenth of the time."""
    pointed = (layout.pointed(line) for _, line in lines)
    try:
        table = np.loadtxt(pointed, delimiter=layout.separator, ndmin=2, comments=None)
    except ValueError:
        return None
    return table if table.shape == (len(lines), n_columns) else None


def _number(cell: str, layout: Layout, file: Path, line: int) -> float:
    try:
        return float(layout.pointed(cell))
    except ValueError:
        raise _error(file, f"{show(cell)} is no number", line) from None


def _seconds(time: Named, file: Path, line: int) -> float:
    """Return the factor from the column of times to s."""
    match = _TIME.fullmatch(time[0])
    unit = time[1] or (match and match["unit"]) or "s"
    try:
        return parse_quantity(f"1 {unit}", "s")
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


CSV = Reader(read_csv, read_text_table)
