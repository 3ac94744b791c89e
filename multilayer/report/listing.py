"""Tables of texts, and plain data as texts: the same for the terminal and for reports."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, Literal, Self, TypeVar

from multilayer.csv_table import rows_of
from multilayer.number_text import significant

_DIGITS = 8  # of what was given: conversions of units round the last ones
_HASH, _HASH_SHOWN = re.compile(r"[0-9a-f]{40,}"), 16
_NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)(e[-+]?\d+)?")
_LONGEST = 160
T = TypeVar("T")


class Tinted(str):
    """A text that has a colour on a terminal."""

    __slots__ = ("colour",)
    colour: str

    def __new__(cls, text: str, colour: str) -> Self:
        """Return the text; `colour` by its name, as ``red``."""
        made = super().__new__(cls, text)
        made.colour = colour
        return made


def yes_or_no(value: bool) -> str:
    """Return yes, or no in red."""
    return "yes" if value else Tinted("no", "red")


@dataclass(frozen=True)
class Listing:
    """A table of texts.

    Attributes
    ----------
    headings : tuple of str
        May have several lines.
    rows : tuple of tuple of str
    numeric : tuple of int
        Columns set flush right.
    caption : str
        Above it; on a terminal the title of its section where there is none.
    notes : tuple of str
        Lines below it.
    only : {'', 'console', 'page'}
        Where it stands; both if empty.
    marked : collection of int
        Rows that a page marks.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[int, ...] = ()
    caption: str = ""
    notes: tuple[str, ...] = ()
    only: Literal["", "console", "page"] = ""
    marked: Collection[int] = ()

    @classmethod
    def of(cls, items: Iterable[T], columns: Mapping[str, Callable[[T], str]], **options: Any) -> Listing:
        """Return a row for each item.

        Parameters
        ----------
        items : iterable
        columns : mapping
            What each cell says of an item, by heading; one that begins with ``>`` is of a column set flush right.
        **options
            Other attributes.
        """
        rows = tuple(tuple(cell(item) for cell in columns.values()) for item in items)
        numeric = tuple(i for i, heading in enumerate(columns) if heading.startswith(">"))
        return cls(tuple(heading.removeprefix(">") for heading in columns), rows, numeric, **options)

    def without(self, column: int) -> Listing:
        """Return the table without a column."""
        kept = [i for i in range(len(self.headings)) if i != column]
        headings, *rows = (tuple(row[i] for i in kept) for row in (self.headings, *self.rows))
        numeric = tuple(kept.index(i) for i in self.numeric if i in kept)
        return replace(self, headings=headings, rows=tuple(rows), numeric=numeric)

    def common(self, column: int) -> str:
        """Return what all cells of a column say, nothing where they differ."""
        texts = {row[column] for row in self.rows}
        return texts.pop() if len(texts) == 1 else ""

    def filled(self) -> Listing:
        """Return the table without the columns in which nothing stands."""
        kept = self
        for column in reversed(range(len(self.headings))):
            if not any(row[column] for row in self.rows):
                kept = kept.without(column)
        return kept


def listing_of(table: str, caption: str = "") -> Listing:
    """Return a CSV table with rounded numbers."""
    headings, *rows = rows_of(table)
    numeric = tuple(i for i in range(len(headings)) if any(_is_number(row[i]) for row in rows))
    digits = [_DIGITS if heading.startswith("frequency") else 4 for heading in headings]
    cells = tuple(tuple(map(_rounded, row, digits)) for row in rows)
    return Listing(tuple(headings), cells, numeric, caption)


def _is_number(cell: str) -> bool:
    return _NUMBER.fullmatch(cell) is not None


def _rounded(cell: str, digits: int) -> str:
    """Return a cell with so many digits; whole numbers, which may count or name something, and texts as they are."""
    return significant(float(cell), digits) if _is_number(cell) and not cell.isdecimal() else cell


def flat_items(values: Mapping[str, Any], before: str = "") -> list[tuple[str, str]]:
    """Return plain data as names and texts; what is nested more than once is written out in a text."""
    items = []
    for key, value in values.items():
        name = f"{before}{str(key).replace('_', ' ')}"
        if isinstance(value, Mapping) and not before:
            items += flat_items(value, f"{name}: ")
        elif isinstance(value, list | tuple) and value and all(isinstance(part, Mapping) for part in value):
            items += [(f"{name} {i}", _text(part)) for i, part in enumerate(value, start=1)]
        elif not _is_nothing(value):
            items.append((name, _text(value)))
    return items


def _is_nothing(value: Any) -> bool:
    return value is None or (isinstance(value, Mapping | list | tuple | str) and not value)


def _text(value: Any) -> str:
    """Return a number as it was given, to rounding, and of a long text its beginning: all of it is in the JSON file."""
    if isinstance(value, float):
        return significant(value, _DIGITS)
    if isinstance(value, Mapping):
        parts = (f"{str(key).replace('_', ' ')} {_text(part)}" for key, part in value.items() if not _is_nothing(part))
        return ", ".join(parts)
    text = ", ".join(map(_text, value)) if isinstance(value, list | tuple) else str(value)
    if _HASH.fullmatch(text):
        return f"{text[:_HASH_SHOWN]}…"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
