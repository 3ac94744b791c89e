"""The table of plugins."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rich.table import Table
from rich.text import Text

from multilayer.report.console import console


def plugin_table(described: Sequence[dict[str, Any]]) -> None:
    """Print one row per plugin, then in full what is broken."""
    table = Table(box=None, pad_edge=False)
    for heading in ("kind", "name", "package", "defined in", ""):
        table.add_column(heading, overflow="fold")
    for entry in described:
        packages = "\n".join(f"{one['package']} {one['version']}".strip() or "-" for one in entry["origin"])
        places = "\n".join(one["value"] for one in entry["origin"])
        state = Text("broken", style="red") if "error" in entry else ""
        table.add_row(entry["kind"], Text(entry["name"]), Text(packages), Text(places), state)
    out = console()
    out.print(table)
    for entry in described:
        if "error" in entry:
            out.print()
            out.print(Text(f"broken: {entry['error']}", style="red"), soft_wrap=True)
