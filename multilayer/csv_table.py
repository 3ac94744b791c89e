"""Results as CSV."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Iterable, Sequence
from numbers import Number
from typing import Any

from multilayer.doors import for_cell, from_cell

_QUOTED = re.compile(r'[,"#\r\n]')  # also '#', which begins a comment where tables are read


def csv_table(columns: Sequence[str], rows: Iterable[Iterable[Any]], digits: int = 9) -> str:
    """Return a table as CSV: an empty cell for None and NaN, text as `for_cell` has it.

    Parameters
    ----------
    columns : sequence of str
    rows : iterable of iterable
        Values in the order of the columns.
    digits : int
        That are significant.
    """
    lines = [[for_cell(name) for name in columns], *([_cell(value, digits) for value in row] for row in rows)]
    return "".join(f"{_line(cells)}\n" for cells in lines)


def rows_of(table: str) -> list[list[str]]:
    """Return the rows of a table that `csv_table` wrote, the names of its columns first, all of them as texts.

    Parameters
    ----------
    table : str
    """
    return [[from_cell(cell) for cell in row] for row in csv.reader(io.StringIO(table, newline=""))]


def _line(cells: Iterable[str]) -> str:
    return ",".join(map(_quoted, cells)) or '""'  # a blank line would be no row


def _quoted(cell: str) -> str:
    return '"' + cell.replace('"', '""') + '"' if _QUOTED.search(cell) else cell


def _cell(value: Any, digits: int) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:.{digits}g}"
    return str(value) if isinstance(value, Number) else for_cell(str(value))
