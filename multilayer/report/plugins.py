"""The list of what is registered, and by whom."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from multilayer.plugins.listing import describe_plugins
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Report, Section


def plugins_report() -> Report:
    """Return everything registered with where it comes from, then in full what is broken."""
    described = describe_plugins()
    columns: dict[str, Callable[[dict[str, Any]], str]] = {
        "kind": lambda entry: entry["kind"],
        "name": lambda entry: entry["name"],
        "package": lambda entry: "\n".join(
            f"{origin['package']} {origin['version']}".strip() or "-" for origin in entry["origin"]
        ),
        "defined in": lambda entry: "\n".join(origin["value"] for origin in entry["origin"]),
        "": lambda entry: Tinted("broken", "red") if "error" in entry else "",
    }
    broken = [Tinted(f"broken: {entry['error']}", "red") for entry in described if "error" in entry]
    notes = tuple(line for text in broken for line in ("", text))
    listing = Listing.of(described, columns, notes=notes)
    return Report(kind="plugins", sections=(Section("", listings=(listing,)),), record=described)
