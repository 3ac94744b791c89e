"""What ``multilayer diagnose`` prints: the verdict, then short tables."""

from __future__ import annotations

from rich.console import Console
from rich.table import Table
from rich.text import Text

from multilayer.diagnosis.result import Diagnosis
from multilayer.report.console import console
from multilayer.report.diagnosis_rows import (
    absorbed_names,
    cause_rows,
    gap_numbers,
    in_words,
    next_rows,
    unknown_rows,
    where_rows,
)
from multilayer.report.listing import Listing

_MOST_ROWS = 5


def diagnosis_table(diagnosis: Diagnosis) -> None:
    """Print a diagnosis."""
    record, out = diagnosis.record, console()
    # as Text: names may hold what rich takes for markup
    out.print(Text.assemble((diagnosis.campaign, "italic"), ": ", (str(record["sentence"]), "bold")))
    numbers = "; ".join(f"{name} {value}" for name, value in gap_numbers(record).items())
    held_out = record["gap"].get("held_out") if diagnosis.verdict != "no_gap" else ""
    out.print(Text(f"{numbers} (1: noise alone" + (f"; {held_out})" if held_out else ")")))
    _print(out, "Where", where_rows(record, _MOST_ROWS))
    _print(out, "Which", cause_rows(record, _MOST_ROWS))
    _print(out, "Unknowns", unknown_rows(record))
    experiments = next_rows(record, _MOST_ROWS)
    if record["causes"] and not experiments.rows:
        out.print("\nNothing to measure next: no other known effect comes near to the first", style="italic")
    elif separates := experiments.common(1):
        _print(out, f"What to measure next, to separate {separates}", experiments.without(1))
    else:
        _print(out, "What to measure next", experiments)
    if absorbed := absorbed_names(diagnosis.similarity):
        names = ", ".join(in_words([name]) for name in absorbed)
        out.print(Text(f"Hidden in these data, absorbed by the unknowns: {names}"))


def _print(out: Console, title: str, listing: Listing) -> None:
    if not listing.rows:
        return
    out.print()
    out.print(Text(title, style="italic"))
    table = Table(box=None, pad_edge=False)
    for i, heading in enumerate(listing.headings):
        numeric = i in listing.numeric
        table.add_column(heading, justify="right" if numeric else "left", no_wrap=numeric, overflow="fold")
    for row in listing.rows:
        table.add_row(*map(Text, row))
    out.print(table)
