"""The table of several fits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from multilayer.report.console import console


def fit_summary(rows: Sequence[dict[str, Any]]) -> None:
    """Print one row per campaign; moduli are medians over its frequencies."""
    table = Table(box=None, pad_edge=False)
    for heading in ("campaign", "fit", "median E1 / Pa", "median E2 / Pa", "accepted", "remark"):
        right = heading.startswith("median") or heading == "accepted"
        table.add_column(heading, justify="right" if right else "left")
    for row in rows:
        table.add_row(
            Text(row["campaign"]), row["fit"], f"{row['E1_pa']:.4g}", f"{row['E2_pa']:.4g}",
            f"{row['accepted']} of {row['of']}", Text(row["remark"]),
        )  # fmt: skip
    console().print(table)
