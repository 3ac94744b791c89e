"""What a page shows of a layer: every field it may have, with its value, unit, meaning and the range of its slider.

It is told from the data as they are written: mistakes in them are no obstacle, for somebody is about to correct them.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, Literal, get_args, get_origin

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from multilayer.doors import for_log
from multilayer.errors import InputError
from multilayer.explore.edits import borrowed_fields, contacts_behind
from multilayer.layers.base import LAYERS, Layer
from multilayer.layers.field_sets import FieldSets
from multilayer.layers.meanings import MEANINGS
from multilayer.materials.expand import expand_materials
from multilayer.media.laws import LAWS
from multilayer.number_text import plain_unit
from multilayer.registry import Registry, RegistryError
from multilayer.stack import Ambient, FluidHalfSpace
from multilayer.units import field_bounds, field_unit, parse_quantity

Place = tuple[str | int, ...]
_ZERO_OF_CELSIUS = 273.15
_AS_TYPED = str.maketrans({"²": "^2", "³": "^3", "⁴": "^4", "µ": "u"})
_TOLD_ELSEWHERE = ("type", "name", "law")
_SIGNS = {"gt": "above", "ge": "at least", "lt": "below", "le": "at most"}
_USUAL = {  # ranges of sliders that a decade on either side would make useless
    "temperature": (253.15, 333.15),
    "pressure": (7e4, 1.1e5),
    "azimuth": (-90.0, 90.0),
    "angle": (0.0, 89.0),
    "max_angle": (30.0, 90.0),
}
_EMPTY_AT = {  # where the slider of a field that nobody has given begins: SI, of the right size
    "m": 1e-2, "m^2": 1e-9, "kg/m^3": 100.0, "kg/m^2": 1.0, "Pa": 1e6, "m/s": 343.0, "s": 1e-5, "N*s/m^4": 1e4,
    "N*s/m^3": 100.0, "Pa*s": 1.8e-5, "N/m": 100.0, "K": 293.15,
}  # fmt: skip


def described_layers(data: Mapping[str, Any], folder: Path) -> list[dict[str, Any]]:
    """Return what a page shows of every layer.

    Parameters
    ----------
    data : mapping
        As written.
    folder : Path
        To which the path of the user's library is relative.
    """
    layers, contacts = expand_materials(data, folder).data["layers"], contacts_behind(data)
    return [
        _layer(layer, written, i, _of_material(data, written, folder)) | {"contact": contacts.get(i, "bonded")}
        for i, (layer, written) in enumerate(zip(layers, data["layers"], strict=True))
    ]


def _of_material(data: Mapping[str, Any], layer: Mapping[str, Any], folder: Path) -> set[str]:
    try:
        return set(borrowed_fields(data, layer, folder))
    except InputError:  # told where the data are validated
        return set()


def _layer(layer: Mapping[str, Any], written: Mapping[str, Any], i: int, offered: set[str]) -> dict[str, Any]:
    type_name = str(layer.get("type"))
    shown: dict[str, Any] = {
        "type": type_name,
        "name": written.get("name") or "",
        "title": for_log(written.get("name") or written.get("material") or type_name.replace("_", " ")),
        "material": written.get("material") or "",
        "thickness": None,
        "look": "other",
        "summary": "",
        "fields": [],
    }
    try:
        kind = LAYERS[type_name]
    except RegistryError:
        return shown
    fields = _fields(kind, layer, ("layers", i), offered - set(written), offered)
    lengths = {field["name"]: field["value"] for field in fields if field["kind"] == "quantity"}
    thickness = lengths.get("thickness")
    return {
        **shown,
        "fields": fields,
        "summary": kind.summary,
        "look": _look(kind),
        "thickness": thickness if thickness is not None else lengths.get("cavity_depth"),
    }


def _look(kind: type[Layer]) -> str:
    """Return how a layer is drawn."""
    fields = kind.model_fields
    if "perforation" in fields and "porosity" not in fields:
        return "holes"
    if "porosity" in fields:
        return "porous"
    if any(name.startswith("young_modulus") for name in fields):
        return "solid"
    return "fluid" if "sound_speed" in fields else "sheet" if "thickness" not in fields else "other"


def described_ambient(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what a page shows of the ambient gas."""
    written = data.get("ambient")
    return _fields(Ambient, written if isinstance(written, dict) else {}, ("ambient",), begin=vars(Ambient().gas))


def described_termination(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return what a page shows of a fluid behind the stack; nothing of another termination."""
    written = data.get("termination")
    return _fields(FluidHalfSpace, written, ("termination",)) if isinstance(written, dict) else []


def _fields(
    model: type[BaseModel],
    data: Mapping[str, Any],
    place: Place,
    borrowed: Collection[str] = (),
    offered: Collection[str] = (),
    begin: Mapping[str, float] = MappingProxyType({}),
) -> list[dict[str, Any]]:
    """Return what a page shows of the fields that a model of these data may have, thickness first.

    Parameters
    ----------
    model : type
    data : mapping
        With the fields of a material.
    place : tuple
        Of the data in the file.
    borrowed, offered : collection of str
        Fields that come from the material, and all that it has.
    begin : mapping
        Where the sliders of fields begin that are not given, SI.
    """
    taken = model.fields_taken(data) if issubclass(model, Layer) else frozenset(model.model_fields)
    wanted = _wanted(model, data)
    shown = [name for name in model.model_fields if (name in taken or name in data) and name not in _TOLD_ELSEWHERE]
    return [
        _field(name, info, data, (*place, name), begin.get(name), required=info.is_required() or name in wanted)
        | {"borrowed": name in borrowed, "offered": name in offered, "chooser": name == getattr(model, "chooser", "")}
        for name in sorted(shown, key=lambda name: name != "thickness")
        for info in (model.model_fields[name],)
    ]


def _wanted(model: type[BaseModel], data: Mapping[str, Any]) -> set[str]:
    """Return the optional fields of which the layer needs these, by what is given."""
    if not issubclass(model, FieldSets):
        return set()
    _, sets = model.field_sets(data)
    given = {name for name, value in data.items() if value is not None}
    return set(min(sets, key=lambda fields: len(set(fields) - given), default=()))


def _field(
    name: str, info: FieldInfo, data: Mapping[str, Any], place: Place, begin: float | None, *, required: bool
) -> dict[str, Any]:
    written, unit = data.get(name), field_unit(info)
    default = None if info.is_required() else info.get_default()
    shown: dict[str, Any] = {
        "name": name,
        "title": name.replace("_", " "),
        "path": list(place),
        "meaning": info.description or MEANINGS.get(name, ""),
        "required": required,
        "given": written is not None,
    }
    nested = _nested(written, place)
    if nested is not None:
        return {**shown, **nested}
    if choices := _choices(info):
        return {**shown, "kind": "choice", "value": default if written is None else written, "choices": choices}
    if unit is None or not _is_number(written, unit):
        text = "" if written is None else for_log(written)
        return {**shown, "kind": "text", "value": text, "unit": unit or "", "plain": isinstance(written, str | None)}
    value = parse_quantity(written, unit) if written is not None else default
    return {**shown, "kind": "quantity", "value": value, **_slider(name, value, begin, unit, dict(field_bounds(info)))}


def _nested(written: Any, place: Place) -> dict[str, Any] | None:
    """Return the fields of a law or a layer that stands in a field."""
    if not isinstance(written, Mapping):
        return None
    registries: tuple[tuple[str, Registry[Any]], ...] = (("law", LAWS), ("type", LAYERS))
    for key, registry in registries:
        if key in written and written[key] in registry:
            try:
                model = registry[str(written[key])]
            except RegistryError:
                break
            return {
                "kind": "nested",
                "value": str(written[key]),
                "whole": dict(written),
                # a part of a layer has that layer's thickness
                "fields": [
                    field
                    for field in _fields(model, written, place)
                    if field["name"] != "thickness" or field["given"] or key != "type"
                ],
            }
    return {"kind": "text", "value": for_log(written), "unit": "", "plain": False}


def _choices(info: FieldInfo) -> list[str]:
    for annotation in (info.annotation, *get_args(info.annotation)):
        if get_origin(annotation) is Literal:
            return [str(choice) for choice in get_args(annotation)]
    return []


def _is_number(written: Any, unit: str) -> bool:
    if written is None:
        return True
    try:
        return math.isfinite(parse_quantity(written, unit))
    except ValueError:
        return False


def _slider(
    name: str, value: float | None, begin: float | None, unit: str, bounds: Mapping[str, float]
) -> dict[str, Any]:
    """Return range and unit of a slider."""
    plain = dict(bounds) != {"gt": 0}  # of lengths and their like nobody has to be told; nor of 0 K
    allowed = ", ".join(f"{_SIGNS[key]} {bound:g}" for key, bound in bounds.items() if plain)
    at = next(number for number in (value, begin, _EMPTY_AT.get(unit, 0.5)) if number is not None)
    low, high, scale = _range(name, min(max(at, bounds.get("ge", at)), bounds.get("le", bounds.get("lt", at))), bounds)
    symbol, factor, offset = _unit(at, unit)
    typed = {"°C": "degC", "°": ""}.get(symbol, symbol.translate(_AS_TYPED))
    return {
        "unit": symbol, "symbol": typed, "factor": factor, "offset": offset, "low": low, "high": high, "scale": scale,
        "allowed": allowed, "start": at,
    }  # fmt: skip


def _unit(value: float, unit: str) -> tuple[str, float, float]:
    """Return the unit in which a value is shown, its size in SI, and where it begins: (25.5 - 0) mm, 293.15 K."""
    if unit == "K":
        return "°C", 1.0, _ZERO_OF_CELSIUS
    if unit == "degree":
        return "°", 1.0, 0.0
    return *plain_unit(value, unit), 0.0


def _range(name: str, value: float, bounds: Mapping[str, float]) -> tuple[float, float, str]:
    """Return ends of a slider inside the field's bounds, with the value between if that is allowed, and its spacing."""
    least, most = bounds.get("ge", bounds.get("gt", -math.inf)), bounds.get("le", bounds.get("lt", math.inf))
    if name in _USUAL:
        low, high, scale = *_USUAL[name], "linear"
    elif most - least <= 2 and (value >= 0.05 * most or "gt" not in bounds or least < 0):  # shares, Poisson's ratios
        margin = 1e-3 * (most - least)
        start = 0.0 if least < 0 <= value else least + margin * ("gt" in bounds)
        low, high, scale = start, most - margin * ("lt" in bounds), "linear"
    elif (least == 0 and "gt" in bounds) or (least == -math.inf and value > 0 and value >= 100):
        centre = 10.0 ** round(math.log10(value)) if value > 0 else 1.0
        low, high, scale = centre / 10, min(10 * centre, most * (1 - 1e-3)), "log"
    elif least >= 0:
        room = 2 * (value - least)
        span = max(10 ** math.ceil(math.log10(room)) if room > 0 else 1.0, 3.0 * (least >= 1))
        low, high = least + 1e-3 * ("gt" in bounds), least + span
        scale = "linear"
    else:
        size = max(1.0, 2 * abs(value))
        low, high, scale = max(least, -size), min(most, size), "linear"
    if least <= value <= most and (value > 0 or scale == "linear"):
        low, high = min(low, value), max(high, value)
    return low, high, scale
