"""JSON Schema of materials in a stack file: the key `library`, and layers with a `material`."""

from __future__ import annotations

from typing import Any

from multilayer.json_schema import Handler, Schema, loaded, model_schema
from multilayer.layers.base import LAYERS
from multilayer.materials import load_library

_LIBRARY = "A library file with materials of one's own, relative to this file."
_MATERIAL = "A material of the library, built in or one's own; other fields stand in place of the material's."


def with_materials_written(properties: dict[str, Any], handler: Handler) -> None:
    """Add to a stack's properties the keys that `expand_materials` replaces before the validation."""
    properties["library"] = {"type": "string", "description": _LIBRARY}
    layers = properties["layers"]
    layers["items"] = {"if": {"required": ["material"]}, "then": _of_material(handler), "else": layers["items"]}


def _of_material(handler: Handler) -> Schema:
    """Return the schema of a layer with a material, which may set any of the fields: so none is required."""
    fields: dict[str, list[Schema]] = {}
    for _, model in loaded(LAYERS):
        layer_schema = handler.resolve_ref_schema(model_schema(model, handler))
        for name, schema in layer_schema["properties"].items():
            known = fields.setdefault(name, [])
            known += [schema] if schema not in known else []
    properties = {name: schemas[0] if len(schemas) == 1 else {"anyOf": schemas} for name, schemas in fields.items()}
    names = {"anyOf": [{"enum": sorted(load_library())}, {"type": "string"}], "description": _MATERIAL}
    return {
        "title": "layer of a material",
        "type": "object",
        "properties": {**properties, "material": names},
        "required": ["material"],
        "additionalProperties": False,
    }
