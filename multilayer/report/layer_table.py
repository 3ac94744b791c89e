"""The table of layer types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic.fields import FieldInfo
from rich.table import Table
from rich.text import Text

from multilayer.layers.base import LAYERS
from multilayer.registry import RegistryError
from multilayer.report.console import console
from multilayer.units import field_unit

_PLAIN_FIELDS = {"type", "name"}


def describe_layers(types: Sequence[str] | None = None) -> list[dict[str, Any]]:
    """Return layer types, all or some: name, origin, summary and fields; of a plugin that fails, its error."""
    described = []
    for name in LAYERS.chosen(types):
        entry: dict[str, Any] = {"type": name, "origin": LAYERS.origins(name)}
        try:
            layer = LAYERS[name]
        except RegistryError as error:
            entry["error"] = str(error)
        else:
            fields = {k: v for k, v in layer.model_fields.items() if k not in _PLAIN_FIELDS}
            entry["summary"] = layer.summary
            entry["fields"] = [_describe_field(key, info) for key, info in fields.items()]
        described.append(entry)
    return described


def _describe_field(name: str, info: FieldInfo) -> dict[str, Any]:
    return {
        "name": name,
        "unit": field_unit(info) or "",
        "required": info.is_required(),
        "default": None if info.is_required() else info.default,
        "allowed": ", ".join(_bounds(info)),
    }


def _bounds(info: FieldInfo) -> list[str]:
    signs = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}
    found = []
    for item in _annotations(info):
        for constraint in (item, *getattr(item, "metadata", [])):
            found += [f"{sign} {getattr(constraint, k):g}" for k, sign in signs.items() if hasattr(constraint, k)]
    return found


def _annotations(info: FieldInfo) -> list[Any]:
    """Return what annotates a field, also inside ``T | None``."""
    arguments = getattr(info.annotation, "__args__", ())
    inner = [item for argument in arguments for item in getattr(argument, "__metadata__", ())]
    return [*info.metadata, *inner]


def layer_table(described: list[dict[str, Any]]) -> None:
    """Print what `describe_layers` returns."""
    out = console()
    for entry in described:
        if "error" in entry:
            out.print(Text.assemble((entry["type"], "bold"), ": ", (entry["error"], "red")))
            continue
        out.print(Text.assemble((entry["type"], "bold"), "  ", entry["summary"]))
        table = Table(box=None)
        for heading in ("field", "unit", "default", "allowed"):
            table.add_column(heading, min_width=12)
        for field in entry["fields"]:
            default = (
                "required" if field["required"] else "optional" if field["default"] is None else str(field["default"])
            )
            table.add_row(field["name"], field["unit"] or "-", default, field["allowed"])
        out.print(table)
        out.print()
    out.print("Wherever a modulus stands, a number, a complex number ('1.2e5+2e4j Pa') or a law may stand.")
