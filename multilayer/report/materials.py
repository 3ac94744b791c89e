"""The list of materials."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from multilayer.errors import InputError, suggest
from multilayer.materials import TEXTS, load_library
from multilayer.report.listing import Listing
from multilayer.report.report import Report, Section


def materials_report(
    names: Sequence[str] | None = None,
    library: Path | None = None,
    known: Mapping[str, Mapping[str, Any]] | None = None,
) -> Report:
    """Return materials: all of a library in a table, or all values of some.

    Parameters
    ----------
    names : sequence of str, optional
        Names or parts of names.
    library : Path, optional
        The built-in one when left out.
    known : mapping, optional
        Materials in place of those of a library.

    Raises
    ------
    InputError
        For a name that no material has, or a library that cannot be read.
    """
    if known is None:
        known = load_library(library)
    chosen = _chosen(names or [], known) if names else list(known)
    listings = [_values(name, known[name]) for name in chosen] if names else [_table(known)]
    record = [{"name": name, **known[name]} for name in chosen]
    return Report(kind="materials", sections=(Section("", listings=tuple(listings)),), record=record)


def _chosen(names: Sequence[str], known: Mapping[str, Any]) -> list[str]:
    found: dict[str, None] = {}
    for name in names:
        near = [name] if name in known else [one for one in known if name.casefold() in one.casefold()]
        if not near:
            raise InputError(f"there is no material '{name}'; {suggest(name, known)}")
        found |= dict.fromkeys(near)
    return list(found)


def _table(known: Mapping[str, Mapping[str, Any]]) -> Listing:
    columns: dict[str, Callable[[str], str]] = {
        "material": str,
        "type": lambda name: str(known[name].get("type", "")),
        "source": lambda name: str(known[name].get("source", "")),
    }
    return Listing.of(known, columns, notes=("A layer takes one by `material: NAME`; its own fields come first.",))


def _values(name: str, material: Mapping[str, Any]) -> Listing:
    rows = tuple((field, str(value)) for field, value in material.items() if field not in TEXTS)
    notes = tuple(f"{text}: {material[text]}" for text in TEXTS if text in material)
    return Listing(("field", "value"), rows, caption=name, notes=notes)
