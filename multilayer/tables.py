"""Tables in text files: columns named, with their units, in a header; every mistake with its line."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.bounds import OF_OTHER_UNITS
from multilayer.doors import from_cell
from multilayer.errors import InputError, Problem, show
from multilayer.text_lines import Layout, Line, data_lines
from multilayer.units import parse_quantity

_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_SUFFIX_UNITS = {
    "hz": "Hz", "khz": "kHz", "db": "dB", "deg": "deg", "rad": "rad",
    "pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa",
}  # fmt: skip
Row: TypeAlias = tuple[int | None, tuple[str | float, ...]]


@dataclass(frozen=True)
class Header:
    """Name and unit of a column.

    Attributes
    ----------
    text : str
        As it is written.
    name : str
        Of the quantity, in small letters joined by underscores; empty for text that is no header.
    unit : str or None
        In brackets or as a suffix; None where there is none.
    """

    text: str
    name: str
    unit: str | None

    @classmethod
    def of(cls, text: str) -> Header:
        """Return name and unit from the text of a header."""
        written = name_and_unit(text)
        if written is None:
            return cls(text, "", None)
        name, unit = "_".join(written[0].lower().split()), written[1]
        stem, _, suffix = name.rpartition("_")
        if unit is None and suffix in _SUFFIX_UNITS:
            return cls(text, stem, _SUFFIX_UNITS[suffix])
        return cls(text, name, unit)

    def factor(self, unit: str) -> float:
        """Return what 1 in the unit of the column is in `unit`.

        Parameters
        ----------
        unit : str
            SI, ``dB``, or empty for a pure number.

        Raises
        ------
        ValueError
            When the header has no unit where one is needed, or a unit of another quantity.
        """
        if self.unit is None and unit:
            name = self.text.strip().lower().replace(" ", "_")
            raise ValueError(f"column '{self.text}' has no unit; write '{name}_{unit.lower()}' or '{name} [{unit}]'")
        if unit == "dB" or self.unit in (None, "", "-", "1"):
            if unit == "dB" and self.unit != "dB":
                raise ValueError(f"column '{self.text}' must be in dB; write '[dB]'")
            return 1.0
        try:
            return parse_quantity(f"1 {self.unit}", unit)
        except ValueError as error:
            raise ValueError(f"column '{self.text}': {error}") from None


def name_and_unit(text: str) -> tuple[str, str | None] | None:
    """Return the name in a header, and the unit in brackets behind it; None for text that is no header."""
    match = _HEADER.fullmatch(text)
    return (match["name"], match["unit"]) if match else None


@dataclass(frozen=True)
class Table:
    """A table as it stands in a file.

    Attributes
    ----------
    file : Path
    headers : tuple of Header
        One per column; empty for an empty file.
    rows : tuple of (int or None, tuple)
        Number of the line, where there are lines, and the cells of every row: text, or numbers.
    line : int or None
        Of the header, from 1.
    """

    file: Path
    headers: tuple[Header, ...]
    rows: tuple[Row, ...]
    line: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """What the header calls the columns."""
        return tuple(header.text for header in self.headers)

    def error(self, message: str, line: int | None = None) -> InputError:
        """Return an error placed in this file."""
        return InputError(Problem(message, file=self.file, line=line))

    def text(self, index: int) -> list[str]:
        """Return the cells of a column; rows that end before it have an empty one."""
        return [self.cell(cells[index]) if index < len(cells) else "" for _, cells in self.rows]

    @staticmethod
    def cell(cell: str | float) -> str:
        """Return a cell as a text."""
        return from_cell(_text(cell))

    def numbers(self, columns: Collection[int]) -> dict[int, RealArray]:
        """Return some columns as numbers, shape (n_rows,), by index.

        Raises
        ------
        InputError
            With the line, for a row that lacks a column or has more than are named, and a cell that is no finite
            number.
        """
        width = len(self.names)  # columns without a name, as of intermediate results, may stand beside those with one
        for line, cells in self.rows:
            if any(self.cell(cell) for cell in cells[width:]):
                raise self.error(other_width(len(cells), width), line)
        rows = [[self._number(line, cells, index, max(columns)) for index in columns] for line, cells in self.rows]
        return dict(zip(columns, np.array(rows, dtype=float).reshape(len(rows), len(columns)).T, strict=True))

    def refuse_not_positive(self, frequency: RealArray) -> None:
        """Refuse frequencies (Hz, one per row) that are not above 0."""
        for f, (line, _) in zip(frequency, self.rows, strict=True):
            if f <= 0:
                raise self.error(f"a frequency of {f:g} Hz is not allowed; frequencies must be above 0", line)

    @cached_property
    def _decimal_commas(self) -> bool:
        """Whether decimals have a comma, as many spreadsheets write them: some cell has one, and none a point."""
        cells = (cell for _, row in self.rows for cell in row if isinstance(cell, str))
        return any("," in cell for cell in cells) and self._with_point is None

    @cached_property
    def _with_point(self) -> tuple[int | None, str] | None:
        """Line and text of the first cell with a point inside a number."""
        cells = ((line, cell) for line, row in self.rows for cell in row if isinstance(cell, str))
        return next(((line, cell.strip()) for line, cell in cells if re.search(r"\d\.\d", cell)), None)

    def _number(self, line: int | None, cells: tuple[str | float, ...], index: int, last: int) -> float:
        if len(cells) <= last:
            raise self.error(f"has {len(cells)} cells and lacks some of the columns that the header names", line)
        cell = cells[index]
        try:
            value = cell if isinstance(cell, float) else float(self.pointed(cell))
        except ValueError:
            comma = "; write decimals with a point" if "," in str(cell) else ""
            if comma and self._with_point:
                at, other = self._with_point
                comma += f", as {show(other)} in line {at} has one; a point between thousands must go"
            raise self.error(f"{show(str(cell).strip())} is no number{comma}", line) from None
        if not np.isfinite(value):
            raise self.error(f"{show(str(cell).strip())} is not finite; leave such rows out", line)
        if abs(value) > OF_OTHER_UNITS.most:
            raise self.error(f"{value:g} is larger than any measured value; correct it, or leave such rows out", line)
        return value

    def pointed(self, cell: str) -> str:
        """Return the text of a number, its decimals behind a point."""
        written = _text(cell)
        return written.replace(",", ".") if self._decimal_commas else written


def other_width(n_cells: int, n_named: int) -> str:
    """Return what is wrong with a row of fewer or more cells than columns are named."""
    remedy = "; decimals have a point where commas separate columns" if n_cells > n_named else ""
    return f"has {n_cells} cells where {n_named} columns are named{remedy}"


def _text(cell: str | float) -> str:
    return f"{cell:g}" if isinstance(cell, float) else cell.strip().strip('"')


def read_text_table(path: Path | str) -> Table:
    """Read a table whose columns are separated by commas, semicolons or tabs; what follows a ``#`` is no data.

    Where no comma separates columns, decimals may have one.

    Raises
    ------
    InputError
        When the file is not there, is no text, or separates columns by blanks.
    """
    file = Path(path)
    lines = data_lines(file)
    if not lines:
        return Table(file, (), ())
    number, header = lines[0]
    separator = next((mark for mark in (";", "\t", ",") if mark in header), None)
    if separator is None and _has_blanks_between(lines[1:]):
        text = "has blanks between its columns; columns are separated by commas, semicolons or tabs"
        raise InputError(Problem(text, file=file, line=number))
    separator = separator or ","
    headers = tuple(Header.of(from_cell(_text(name))) for name in _cells(header, separator))
    return Table(file, headers, tuple((at, _cells(line, separator)) for at, line in lines[1:]), number)


def _has_blanks_between(rows: Sequence[Line]) -> bool:
    """Tell whether the first row holds several numbers with blanks between them."""
    blanks = Layout(None, 0)
    cells = blanks.cells(rows[0][1]) if rows else []
    return len(cells) > 1 and blanks.is_row(cells)


def _cells(line: str, separator: str) -> tuple[str, ...]:
    if '"' in line:  # quotes hold separators that separate nothing
        with suppress(csv.Error):
            return tuple(next(csv.reader([line], delimiter=separator, skipinitialspace=True)))
    return tuple(line.split(separator))
