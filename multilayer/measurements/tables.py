"""Text tables of measured values: columns named in the first line, with their units; every mistake with its line."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.units import parse_quantity

_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_SUFFIX_UNITS = {
    "hz": "Hz", "khz": "kHz", "db": "dB", "deg": "deg", "rad": "rad",
    "pa": "Pa", "kpa": "kPa", "mpa": "MPa", "gpa": "GPa",
}  # fmt: skip


@dataclass(frozen=True)
class TextTable:
    """A table of text as it stands in a file.

    Attributes
    ----------
    file : Path
    line : int
        Of the header, from 1.
    names : tuple of str
        What the header calls the columns.
    rows : tuple of (int, tuple of str)
        Line number and cells of every row.
    """

    file: Path
    line: int
    names: tuple[str, ...]
    rows: tuple[tuple[int, tuple[str, ...]], ...]

    def error(self, message: str, line: int | None = None) -> InputError:
        """Return an error placed in this file."""
        return InputError(Problem(message, file=self.file, line=line))

    def text(self, index: int) -> list[str]:
        """Return the cells of a column; rows that end before it have an empty one."""
        return [cells[index].strip().strip('"') if index < len(cells) else "" for _, cells in self.rows]

    def numbers(self, columns: Mapping[int, float]) -> RealArray:
        """Return some columns as numbers, each times its factor, shape (n_columns, n_rows).

        Raises
        ------
        InputError
            With the line, for a row that lacks a column and a cell that is no finite number.
        """
        items = columns.items()
        rows = [[self._number(line, cells, i, columns) * factor for i, factor in items] for line, cells in self.rows]
        return np.array(rows, dtype=float).reshape(len(rows), len(columns)).T

    def refuse_not_positive(self, frequency: RealArray) -> None:
        """Refuse frequencies (Hz, one per row) that are not above 0."""
        for f, (line, _) in zip(frequency, self.rows, strict=True):
            if f <= 0:
                raise self.error(f"a frequency of {f:g} Hz is not allowed; frequencies must be above 0", line)

    @cached_property
    def _decimal_commas(self) -> bool:
        """Whether decimals have a comma, as many spreadsheets write them: some cell has one, and none a point."""
        cells = [cell for _, row in self.rows for cell in row]
        return any("," in cell for cell in cells) and not any(re.search(r"\d\.\d", cell) for cell in cells)

    def _number(self, line: int, cells: tuple[str, ...], index: int, columns: Mapping[int, float]) -> float:
        if len(cells) <= max(columns):
            raise self.error(f"has {len(cells)} cells and lacks some of the columns that the header names", line)
        cell = cells[index]
        try:
            written = cell.strip().strip('"')
            value = float(written.replace(",", ".") if self._decimal_commas else written)
        except ValueError:
            comma = "; write decimals with a point" if "," in cell else ""
            raise self.error(f"'{cell.strip()}' is no number{comma}", line) from None
        if not np.isfinite(value):
            raise self.error(f"'{cell.strip()}' is not finite; leave such rows out", line)
        return value


def read_table(path: Path | str, needed: str) -> TextTable:
    """Read a table whose columns are separated by commas, semicolons or tabs; what follows a ``#`` is no data.

    Where no comma separates columns, decimals may have one.

    Parameters
    ----------
    path : Path or str
    needed : str
        Which columns there must be, for messages.

    Raises
    ------
    InputError
        When the file is not there, is no text, or holds no row.
    """
    file = Path(path)
    lines = _lines(file, needed)
    number, header = lines[0]
    separator = next((mark for mark in (";", "\t", ",") if mark in header), ",")
    names = tuple(name.strip().strip('"') for name in header.split(separator))
    rows = tuple((at, tuple(line.split(separator))) for at, line in lines[1:])
    return TextTable(file, number, names, rows)


def _lines(file: Path, needed: str) -> list[tuple[int, str]]:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise InputError(Problem("there is no such file", file=file)) from None
    except (OSError, UnicodeDecodeError) as error:
        message = f"is no text that can be read ({error}); export it again as UTF-8"
        raise InputError(Problem(message, file=file)) from None
    numbered = enumerate((line.partition("#")[0].strip(" ") for line in text.splitlines()), start=1)
    lines = [(number, line) for number, line in numbered if line]
    if not lines:
        raise InputError(Problem(f"is empty; {needed}", file=file))
    return lines


def split_header(header: str) -> tuple[str, str | None] | None:
    """Return what a header calls a quantity, in small letters joined by underscores, and its unit.

    The unit stands in brackets or is a suffix; None where the header says none. None for what is no header.
    """
    match = _HEADER.fullmatch(header)
    if match is None:
        return None
    name, unit = "_".join(match["name"].lower().split()), match["unit"]
    stem, _, suffix = name.rpartition("_")
    return (stem, _SUFFIX_UNITS[suffix]) if unit is None and suffix in _SUFFIX_UNITS else (name, unit)


def unit_factor(header: str, written: str | None, unit: str) -> float:
    """Return what 1 in the unit of a header is in `unit`.

    Parameters
    ----------
    header : str
        For messages.
    written : str or None
        What the header says.
    unit : str
        SI, ``dB``, or empty for a pure number.

    Raises
    ------
    ValueError
        When the header says none where one is needed, or another kind of unit.
    """
    if written is None and unit:
        name = header.strip().lower().replace(" ", "_")
        raise ValueError(f"column '{header}' has no unit; write '{name}_{unit.lower()}' or '{name} [{unit}]'")
    if unit == "dB" or written in (None, "", "-", "1"):
        if unit == "dB" and written != "dB":
            raise ValueError(f"column '{header}' must be in dB; write '[dB]'")
        return 1.0
    try:
        return parse_quantity(f"1 {written}", unit)
    except ValueError as error:
        raise ValueError(f"column '{header}': {error}") from None
