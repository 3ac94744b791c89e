"""Where a table stands in a text file: separator, decimals, header and units, as programs of all kinds write them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

from multilayer.bounds import TEXT_BYTES, TEXT_LINES
from multilayer.errors import InputError, Problem
from multilayer.files import refuse_endless
from multilayer.measurements.accelerometers import acceleration_factor, voltage_factor
from multilayer.writing.manifest import note_input

_SEPARATORS = (";", "\t", ",", None)
_HINT = re.compile(r"sep=.?")  # ahead of the header, for spreadsheets
_QUOTED = r'(?:^|(?<=[,;\t]))\s*"(?:[^"]|"")*"'  # a cell in quotes
_DATA = re.compile(rf"(?:{_QUOTED}|[^#])*+")  # of a line, ahead of a comment
_PREAMBLE = 60  # lines that programs write ahead of a header, at most

Line = tuple[int, str]  # its number from 1, and its text


@dataclass(frozen=True)
class Layout:
    """Where a table stands: its separator, the index of its header, and how many lines of units follow."""

    separator: str | None
    header: int
    n_units: int = 0

    @property
    def first(self) -> int:
        """Index of the first line of samples."""
        return self.header + 1 + self.n_units

    def cells(self, line: str) -> list[str]:
        """Return the cells of a line, without blanks and quotes around them."""
        return [cell.strip().strip('"').strip() for cell in line.split(self.separator)]

    def pointed(self, text: str) -> str:
        """Return numbers with decimal points, as they are written where no comma separates columns."""
        return text if self.separator == "," else text.replace(",", ".")

    def is_number(self, cell: str) -> bool:
        """Tell whether a cell is a number."""
        try:
            float(self.pointed(cell))
        except ValueError:
            return False
        return True

    def is_row(self, cells: Sequence[str]) -> bool:
        """Tell whether cells are a row of numbers, some of them missing perhaps."""
        return any(cells) and all(not cell or self.is_number(cell) for cell in cells)


def data_lines(file: Path) -> list[Line]:
    """Return the lines that are neither blank nor comments; a ``#`` in a quoted cell begins no comment."""
    note_input(file)
    try:
        refuse_endless(file)
        TEXT_BYTES.check(file.stat().st_size, file, "save it in a binary format")
        raw = file.read_bytes()
        TEXT_LINES.check(raw.count(b"\n"), file, "save it in a binary format")
        text = _decoded(raw)
    except FileNotFoundError:
        raise InputError(Problem("there is no such file", file=file)) from None
    except (OSError, UnicodeDecodeError) as error:
        message = f"is no text that can be read ({error}); export it again as UTF-8"
        raise InputError(Problem(message, file=file)) from None
    stripped = ((number, _data(line).strip(" ")) for number, line in enumerate(text.splitlines(), start=1))
    return [(number, line) for number, line in stripped if line.strip() and not _HINT.fullmatch(line)]


def _data(line: str) -> str:
    before, hash_sign, _ = line.partition("#")
    if not hash_sign or '"' not in before:
        return before
    data = _DATA.match(line)
    assert data is not None  # it matches nothing, too
    return data[0]


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
