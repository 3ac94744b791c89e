"""Where a table stands in a text file: separator, decimals, header and units, as programs of all kinds write them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from multilayer.measurements.accelerometers import acceleration_factor, voltage_factor
from multilayer.text_lines import Layout, Line, data_lines

_SEPARATORS = (";", "\t", ",", None)
_PREAMBLE = 60  # lines that programs write ahead of a header, at most


def layout_of(lines: Sequence[Line]) -> Layout:
    """Return where the table stands: the header above the first two rows of numbers that have as many cells.

    Without such rows, the first line is the header, and tells the separator.
    """
    layouts = (_with_separator(lines[: _PREAMBLE + 2], separator) for separator in _SEPARATORS)
    header = lines[0][1]
    first_line = Layout(next((mark for mark in (";", ",", "\t") if mark in header), None), 0)
    return next((layout for layout in layouts if layout is not None), first_line)


def _with_separator(lines: Sequence[Line], separator: str | None) -> Layout | None:
    layout = Layout(separator, 0)
    rows = [layout.cells(text) for _, text in lines]
    first = next((i for i, two in enumerate(pairwise(rows)) if all(layout.is_row(row) for row in two)), 0)
    widths = [len(row) for row in rows]
    if first == 0 or widths[first - 1] != widths[first]:
        return None
    if widths[first] == 1 and "," in lines[first - 1][1]:  # commas are between columns here
        return None
    has_units = first > 1 and widths[first - 2] == widths[first] and all(_is_unit(cell) for cell in rows[first - 1])
    return Layout(separator, first - 1 - has_units, int(has_units))


def _is_unit(cell: str) -> bool:
    text = cell.strip("[]() ")
    known = text in ("", "-", "s", "ms", "us", "µs")
    return known or acceleration_factor(text) is not None or voltage_factor(text) is not None


__all__ = ["Layout", "Line", "data_lines", "layout_of"]
