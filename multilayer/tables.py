"""Tables in text files: columns named, with their units, in a header; every mistake with its line."""

from __future__ import annotations

import csv
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import TypeAlias
from warnings import warn

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.bounds import OF_OTHER_UNITS
from multilayer.doors import from_cell
from multilayer.errors import InputError, PlausibilityWarning, Problem, show
from multilayer.text_lines import Layout, Line, data_lines
from multilayer.units import parse_quantity

_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_SUFFIX_UNITS = {
    "hz": "Hz", "khz": "kHz", "db": "dB", "deg": "deg", "rad": "rad",
    "pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa",
}  # fmt: skip
_NUMERAL = re.compile(r"[-+]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][-+]?\d+)?")
_THOUSANDS = re.compile(r"[-+]?[1-9]\d{0,2}(?:[.,]\d{3})+")
_SMALL = re.compile(r"[-+]?\d{1,3}")  # whole numbers that need no separator between thousands
_PURE = ("-", "1")  # what stands in place of a unit
_IS_FALSE = ("false", "0")  # in our tables, and of logical arrays in other formats
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
            suffix = f"'{name}_{unit.lower()}' or " if unit.lower() in _SUFFIX_UNITS else ""
            raise ValueError(f"column '{self.text}' has no unit; write {suffix}'{name} [{unit}]'")
        if unit == "dB":
            if self.unit != "dB":
                raise ValueError(f"column '{self.text}' must be in dB; write '[dB]'")
            return 1.0
        if unit and self.unit in _PURE:
            raise ValueError(f"column '{self.text}' holds no pure numbers; write its unit, as '[{unit}]'")
        if not self.unit or self.unit in _PURE:
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
    separator : str or None
        Of the columns of a text.
    """

    file: Path
    headers: tuple[Header, ...]
    rows: tuple[Row, ...]
    line: int | None = None
    separator: str | None = None

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
            With the line, for a row that lacks a column or has more than are named, a cell that is no finite number,
            and cells that may have separators between thousands.
        """
        width = len(self.names)  # columns without a name, as of intermediate results, may stand beside those with one
        for line, cells in self.rows:
            if any(self.cell(cell) for cell in cells[width:]):
                raise self.error(other_width(len(cells), width), line)
        rows = [[self._number(line, cells, index, max(columns)) for index in columns] for line, cells in self.rows]
        for index in columns:
            if thousands := self.thousands(index):
                line, text = thousands
                raise self.error(text, line)
        return dict(zip(columns, np.array(rows, dtype=float).reshape(len(rows), len(columns)).T, strict=True))

    def thousands(self, index: int) -> tuple[int | None, str] | None:
        """Return line and text of a cell of which nothing tells whether its mark is before decimals or thousands.

        Such a cell is '1,250' beside whole numbers below 1000, if no other cell of the table has decimals behind the
        same mark. '1,000' is one anyway: a zero would not be written there and left out of the whole numbers.

        Parameters
        ----------
        index : int
            Of the column.
        """
        rows = [(line, row[index]) for line, row in self.rows if index < len(row)]
        cells = [(line, _text(cell)) for line, cell in rows if isinstance(cell, str)]
        marked = [(line, cell) for line, cell in cells if is_thousands(cell)]
        others = [cell for _, cell in cells if cell.strip("-–")] if marked else []
        whole = [cell for cell in others if _SMALL.fullmatch(cell)]
        if not whole or len(marked) + len(whole) < len(others):
            return None
        line, cell = next(((line, cell) for line, cell in marked if cell.endswith("0")), marked[0])
        if not cell.endswith("0") and any(mark in cell for mark in self._decimal_marks):
            return None
        text = f"{show(cell)} stands among whole numbers as {show(whole[0])}: are these thousands, or decimals?"
        return line, f"{text} Write '{_plain(cell)}', or '{cell}0' for decimals"

    def rejected(self, column: str) -> BoolArray:
        """Return which rows hold false in a column of verdicts, shape (n_rows,); none where there is no such column.

        Parameters
        ----------
        column : str
            Its header.
        """
        verdicts = self.text(self.names.index(column)) if column in self.names else [""] * len(self.rows)
        return np.array([verdict.lower() in _IS_FALSE for verdict in verdicts], dtype=bool)

    def without(self, rejected: Mapping[str, BoolArray], purpose: str) -> Table:
        """Return the table without some rows.

        Parameters
        ----------
        rejected : mapping of arrays, shape (n_rows,)
            By the reason, as 'not accepted', which rows are left out.
        purpose : str
            What the others are for, as 'fit'.

        Raises
        ------
        InputError
            When no row is left.

        Warns
        -----
        PlausibilityWarning
            Of how many rows are left out.
        """
        told = ", ".join(f"{np.count_nonzero(rows)} {why}" for why, rows in rejected.items() if np.any(rows))
        if not told:
            return self
        out = np.any([*rejected.values()], axis=0)
        kept = tuple(row for row, is_out in zip(self.rows, out, strict=True) if not is_out)
        if not kept:
            raise self.error(f"holds no row to {purpose}; left out: {told}", self.line)
        warn(f"{self.file}: rows left out of {len(self.rows)}: {told}", PlausibilityWarning, stacklevel=4)
        return replace(self, rows=kept)

    def refuse_not_positive(self, frequency: RealArray) -> None:
        """Refuse frequencies (Hz, one per row) that are not above 0."""
        for f, (line, _) in zip(frequency, self.rows, strict=True):
            if f <= 0:
                raise self.error(f"a frequency of {f:g} Hz is not allowed; frequencies must be above 0", line)

    @cached_property
    def _decimal_commas(self) -> bool:
        """Whether decimals have a comma, as many spreadsheets write them: some cell has one, and no number a point."""
        if self.separator == ",":
            return False
        cells = (cell for _, row in self.rows for cell in row if isinstance(cell, str))
        return any("," in cell for cell in cells) and self._with_point is None

    @cached_property
    def _with_point(self) -> tuple[int | None, str] | None:
        """Line and text of the first number with a point inside."""
        return next(((line, cell) for line, cell in self._numerals if "." in cell), None)

    @cached_property
    def _decimal_marks(self) -> frozenset[str]:
        """Marks that stand in numbers where thousands have none."""
        decimals = "".join(cell for _, cell in self._numerals if not is_thousands(cell))
        return frozenset(".,") & frozenset(decimals)

    @property
    def _numerals(self) -> Iterator[tuple[int | None, str]]:
        """Line and text of the cells that are numbers as a whole; those of names and dates are none."""
        cells = ((line, _text(cell)) for line, row in self.rows for cell in row if isinstance(cell, str))
        return ((line, cell) for line, cell in cells if _NUMERAL.fullmatch(cell) or is_thousands(cell))

    def _number(self, line: int | None, cells: tuple[str | float, ...], index: int, last: int) -> float:
        if len(cells) <= last:
            raise self.error(f"has {len(cells)} cells and lacks some of the columns that the header names", line)
        cell = cells[index]
        try:
            value = cell if isinstance(cell, float) else float(self.pointed(cell))
        except ValueError:
            raise self.error(f"{show(str(cell).strip())} is no number{self._remedy(_text(cell))}", line) from None
        if not np.isfinite(value):
            raise self.error(f"{show(str(cell).strip())} is not finite; leave such rows out", line)
        if abs(value) > OF_OTHER_UNITS.most:
            raise self.error(f"{value:g} is larger than any measured value; correct it, or leave such rows out", line)
        return value

    def _remedy(self, cell: str) -> str:
        """Return what to do about the marks in a cell that is no number."""
        if is_thousands(cell):
            end = f", and thousands without a mark, '{_plain(cell)}'"
        elif "," in cell:
            end = "; a point between thousands must go" if self._with_point else ""
        else:
            return ""
        at, other = self._with_point or (None, "")
        shown = f", as {show(other)} in line {at} has one" if other and other != cell else ""
        return f"; write decimals with a point{shown}{end}"

    def pointed(self, cell: str) -> str:
        """Return the text of a number, its decimals behind a point."""
        written = _text(cell)
        return written.replace(",", ".") if self._decimal_commas else written


def other_width(n_cells: int, n_named: int) -> str:
    """Return what is wrong with a row of fewer or more cells than columns are named."""
    remedy = "; decimals have a point where commas separate columns" if n_cells > n_named else ""
    return f"has {n_cells} cells where {n_named} columns are named{remedy}"


def is_thousands(cell: str) -> bool:
    """Tell whether a number may have separators between thousands, as '1,250' or '12.500.000'."""
    return _THOUSANDS.fullmatch(cell) is not None


def _plain(cell: str) -> str:
    return re.sub("[.,]", "", cell)


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
    rows = tuple((at, _cells(line, separator)) for at, line in lines[1:])
    return Table(file, headers, rows, number, separator)


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
