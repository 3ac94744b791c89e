"""What reports of several campaigns have in common."""

from __future__ import annotations

from typing import Any, Protocol

from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Draw, Report, Section


class Comparison(Protocol):
    """What comes of comparing several campaigns."""

    @property
    def verdict(self) -> str:
        """In a sentence."""

    @property
    def remarks(self) -> Any:
        """What a reader should know, in sentences."""

    def to_csv(self) -> str:
        """Return the table."""

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""


def closing_notes(scale: float, result: Comparison) -> tuple[str, ...]:
    """Return the lines below a table: by how much deviations are enlarged, remarks, and the verdict."""
    enlarged = f"the values scatter more than stated: standard deviations enlarged by {scale:.2f}"
    return (*([enlarged] if scale > 1 else []), *result.remarks, Tinted(result.verdict, "bold"))


def table_report(kind: str, name: str, result: Comparison, listing: Listing, draw: Draw) -> Report:
    """Return a report of one table and one figure, with its files ``KIND.csv``, ``KIND.json`` and ``KIND.png``."""
    return Report(
        name=name,
        kind=kind,
        sections=(Section("", listings=(listing,)),),
        tables={f"{kind}.csv": result.to_csv()},
        record=result.to_dict(),
        record_file=f"{kind}.json",
        figures={f"{kind}.png": draw},
    )
