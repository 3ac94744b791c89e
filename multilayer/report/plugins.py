"""The list of what is registered, and by whom."""

from __future__ import annotations

from multilayer.plugins.listing import describe_plugins
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Report, Section


def plugins_report() -> Report:
    """Return everything registered with where it comes from, then in full what is broken."""
    described = describe_plugins()
    rows = tuple(
        (
            entry["kind"],
            entry["name"],
            "\n".join(f"{origin['package']} {origin['version']}".strip() or "-" for origin in entry["origin"]),
            "\n".join(origin["value"] for origin in entry["origin"]),
            Tinted("broken", "red") if "error" in entry else "",
        )
        for entry in described
    )
    broken = [Tinted(f"broken: {entry['error']}", "red") for entry in described if "error" in entry]
    notes = tuple(line for text in broken for line in ("", text))
    listing = Listing(("kind", "name", "package", "defined in", ""), rows, notes=notes)
    return Report(kind="plugins", sections=(Section("", listings=(listing,)),), record=described)
