"""The list of layer types."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, get_args

from pydantic.fields import FieldInfo
from pydantic_core import to_jsonable_python

from multilayer.layers.base import LAYERS, Layer
from multilayer.layers.field_sets import FieldSets
from multilayer.layers.meanings import MEANINGS
from multilayer.registry import RegistryError
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Report, Section
from multilayer.units import field_bounds, field_unit

_PLAIN_FIELDS = {"type", "name"}
_FIELDS = ("field", "unit", "default", "allowed", "meaning")
_WIDTH = 12  # of these columns at least: those of all layers stand below each other
_MODULUS = "Wherever a modulus stands, a number, a complex number ('1.2e5+2e4j Pa') or a law may stand."
_SIGNS = {"gt": ">", "ge": ">=", "lt": "<", "le": "<="}


def layers_report(types: Sequence[str] | None = None) -> Report:
    """Return layer types, all or some: name, origin, summary and fields; of a plugin that fails, its error."""
    described = [_layer(name) for name in LAYERS.chosen(types)]
    listings = tuple(listing for entry in described for listing in (_fields(entry), *_choices(entry, types)))
    sections = (Section("", listings=listings), Section("Moduli", remarks=(_MODULUS,)))
    return Report(kind="layer types", sections=sections, record=described)


def _layer(name: str) -> dict[str, Any]:
    entry: dict[str, Any] = {"type": name, "origin": LAYERS.origins(name)}
    try:
        layer = LAYERS[name]
    except RegistryError as error:
        return {**entry, "error": str(error)}
    fields = {key: info for key, info in layer.model_fields.items() if key not in _PLAIN_FIELDS}
    described = [_field(key, info) for key, info in fields.items()]
    return {**entry, "summary": layer.summary, "fields": described, "models": _models(layer)}


def _models(layer: type[Layer]) -> dict[str, list[list[str]]]:
    """Return which fields each choice of a layer with choices takes: sets, of which one must be complete."""
    if not issubclass(layer, FieldSets) or not layer.chooser:
        return {}
    choices = get_args(layer.model_fields[layer.chooser].annotation)
    return {name: [list(fields) for fields in layer.field_sets({layer.chooser: name})[1]] for name in choices}


def _field(name: str, info: FieldInfo) -> dict[str, Any]:
    return {
        "name": name,
        "unit": field_unit(info) or "",
        "required": info.is_required(),
        "default": _default(info),
        "allowed": ", ".join(_bounds(info)),
        "meaning": info.description or MEANINGS.get(name, ""),
    }


def _default(info: FieldInfo) -> Any:
    """Return the default of a field in plain data; None where there is none, or it depends on other fields."""
    if info.is_required() or info.default_factory_takes_validated_data:
        return None
    return to_jsonable_python(info.get_default(call_default_factory=True), fallback=str)


def _bounds(info: FieldInfo) -> list[str]:
    return [f"{_SIGNS[key]} {bound:g}" for key, bound in field_bounds(info)]


def _choices(entry: dict[str, Any], asked: Sequence[str] | None) -> tuple[Listing, ...]:
    """Return the fields that each model of a layer takes, where somebody asks for the layer by name."""
    if not (asked and entry.get("models")):
        return ()
    rows = tuple((name, " or ".join(", ".join(fields) for fields in sets)) for name, sets in entry["models"].items())
    return (Listing(("model", "takes"), rows, caption=f"{entry['type']}: what each model takes"),)


def _fields(entry: dict[str, Any]) -> Listing:
    if "error" in entry:
        return Listing((), (), notes=(Tinted(f"{entry['type']}: {entry['error']}", "red"),))
    rows = tuple(
        (
            field["name"],
            field["unit"] or "-",
            "required" if field["required"] else "optional" if field["default"] is None else str(field["default"]),
            field["allowed"],
            field["meaning"],
        )
        for field in entry["fields"]
    )
    headings = tuple(f"{heading:{_WIDTH}}" for heading in _FIELDS)
    return Listing(headings, rows, caption=f"{entry['type']}  {entry['summary']}")
