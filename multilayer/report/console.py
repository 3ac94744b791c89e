"""What a terminal shows of a report."""

from __future__ import annotations

import shutil
from typing import TYPE_CHECKING, Literal

from rich.cells import cell_len
from rich.console import Console
from rich.measure import Measurement
from rich.table import Table
from rich.text import Text

from multilayer.errors import readable
from multilayer.report.listing import Listing, Tinted

if TYPE_CHECKING:
    from multilayer.report.report import Report, Section

_WIDTH_IN_A_FILE = 150
_ANY_WIDTH = 10_000


def console() -> Console:
    """Return the console of standard output; wide enough for the tables when it is a file or a pipe."""
    plain = Console()
    if plain.is_terminal:
        return plain
    return Console(width=max(_WIDTH_IN_A_FILE, shutil.get_terminal_size().columns))


def show(report: Report) -> None:
    """Print a report: how it begins, then what its sections have for a terminal, an empty line before each heading."""
    lines: list[Text | Table] = []
    for text in report.opening:
        lines.append(_text(text, "" if lines else "bold"))
    for section in report.sections:
        heading = section.title
        for listing in _listings(section):
            lines += _heading(listing.caption or heading)
            lines += [*([_table(listing)] if listing.rows else []), *map(_text, listing.notes)]
            heading = ""
        bullet = "- " if len(section.remarks) > 1 else ""
        lines += [*(_heading(heading) if section.remarks else ()), *(_text(r, before=bullet) for r in section.remarks)]
    out = console()
    width = out.width
    if lines and not lines[0]:
        del lines[0]
    for line in lines:
        if isinstance(line, Table):
            out.width = max(width, _least_width(line, out))  # too wide rather than without some of its digits
            out.print(line)
            out.width = width
        else:
            out.print(line, soft_wrap=not out.is_terminal)  # in a file a sentence stays whole


def _least_width(table: Table, out: Console) -> int:
    """Return the width below which numbers or words would be cut."""
    return Measurement.get(out, out.options.update(width=_ANY_WIDTH), table).minimum


def _listings(section: Section) -> list[Listing]:
    folded = section.folded
    inner = folded.listings if folded and folded.listings else section.listings
    beside = section.beside.listings if section.beside else ()
    return [listing for listing in (*beside, *inner) if listing.only != "page" and (listing.rows or listing.notes)]


def _heading(text: str) -> list[Text | Table]:
    return [Text(""), _text(text, "italic")] if text else []


def _text(text: str, style: str = "", before: str = "") -> Text:
    """Return a text as messages have it, not looked through for markup: names may be long, and hold what rich takes."""
    return Text(before + readable(text), style=text.colour if isinstance(text, Tinted) else style)


def _table(listing: Listing) -> Table:
    table = Table(box=None, pad_edge=False)
    for i, heading in enumerate(listing.headings):
        number = i in listing.numeric
        lines = [line for text in (heading, *(row[i] for row in listing.rows)) for line in readable(text).split("\n")]
        least = max(map(cell_len, lines)) if number else None
        justify: Literal["right", "left"] = "right" if number else "left"
        table.add_column(_text(heading), justify=justify, no_wrap=number, overflow="fold", min_width=least)
    for row in listing.rows:
        table.add_row(*map(_text, row))
    return table
