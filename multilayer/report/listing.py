"""Tables of texts, and plain data as texts: the same for the terminal and for reports."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from multilayer.report.numbers import significant

_HASH, _HASH_SHOWN = re.compile(r"[0-9a-f]{40,}"), 16
_LONGEST = 160


@dataclass(frozen=True)
class Listing:
    """A table of texts.

    Attributes
    ----------
    headings : tuple of str
    rows : tuple of tuple of str
    numeric : tuple of int
        Columns set flush right.
    """

    headings: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    numeric: tuple[int, ...] = ()

    def without(self, column: int) -> Listing:
        """Return the table without a column."""
        kept = [i for i in range(len(self.headings)) if i != column]
        headings, *rows = (tuple(row[i] for i in kept) for row in (self.headings, *self.rows))
        return Listing(headings, tuple(rows), tuple(kept.index(i) for i in self.numeric if i in kept))

    def common(self, column: int) -> str:
        """Return what all cells of a column say, nothing where they differ."""
        texts = {row[column] for row in self.rows}
        return texts.pop() if len(texts) == 1 else ""

    def filled(self) -> Listing:
        """Return the table without the columns in which nothing stands."""
        empty = [i for i in range(len(self.headings)) if not any(row[i] for row in self.rows)]
        found = self
        for column in reversed(empty):
            found = found.without(column)
        return found


def flat_items(values: Mapping[str, Any], before: str = "") -> list[tuple[str, str]]:
    """Return plain data as names and texts; what is nested more than once is written out in a text."""
    found = []
    for key, value in values.items():
        name = f"{before}{str(key).replace('_', ' ')}"
        if isinstance(value, Mapping) and not before:
            found += flat_items(value, f"{name}: ")
        elif _is_list_of_mappings(value):
            found += [(f"{name} {i}", _text(one)) for i, one in enumerate(value, start=1)]
        elif not _is_nothing(value):
            found.append((name, _text(value)))
    return found


def _is_list_of_mappings(value: Any) -> bool:
    return isinstance(value, list | tuple) and bool(value) and all(isinstance(one, Mapping) for one in value)


def _is_nothing(value: Any) -> bool:
    return value is None or (isinstance(value, Mapping | list | tuple | str) and not value)


def _text(value: Any) -> str:
    """Return a number in four digits, and of a long text its beginning: all of it is in the JSON file."""
    if isinstance(value, float):
        return significant(value, 4)
    if isinstance(value, Mapping):
        said = (f"{str(key).replace('_', ' ')} {_text(one)}" for key, one in value.items() if not _is_nothing(one))
        return ", ".join(said)
    text = ", ".join(map(_text, value)) if isinstance(value, list | tuple) else str(value)
    if _HASH.fullmatch(text):
        return f"{text[:_HASH_SHOWN]}…"
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
