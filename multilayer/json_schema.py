"""JSON Schemas of inputs: annotations for fields with validators of this package, which pydantic cannot read.

Draft 7, which every YAML language server knows: so no ``prefixItems``, and no keywords beside a ``$ref``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Any, TypeAlias

from pydantic import BaseModel, GetJsonSchemaHandler, TypeAdapter
from pydantic.json_schema import GenerateJsonSchema, JsonSchemaValue
from pydantic_core import CoreSchema, core_schema

from multilayer.registry import Registry, RegistryError

Handler: TypeAlias = GetJsonSchemaHandler
Schema: TypeAlias = dict[str, Any]

_OPEN: ContextVar[frozenset[str]] = ContextVar("titles of schemas that are being made", default=frozenset())
_PART = "x-part"  # a reference by title under a key that pydantic does not know, and so does not try to follow
_DIGITS = r"([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?"
_UNIT = r"\s*([^-+0-9.\s].*)?$"  # any text that may be a unit: whether it is known and fits, parsing decides
NUMBER_TEXT = rf"^\s*[-+]?{_DIGITS}"
QUANTITY_TEXT = rf"{NUMBER_TEXT}{_UNIT}"
UNSIGNED_TEXT = rf"^\s*\+?{_DIGITS}{_UNIT}"
_REAL_FIRST = rf"^(?!\s*\(?\s*[-+]?({_DIGITS})?\s*[ij](?!\w))"  # 1e5+2e4j, not 2e4j+1e5
COMPLEX_TEXT = rf"{_REAL_FIRST}({QUANTITY_TEXT}|{NUMBER_TEXT}\s*[-+]\s*[0-9.eE]*[-+]?[0-9]*[ij]|^\s*\()"


@dataclass(frozen=True)
class Written:
    """Annotation: the JSON Schema of a field's input, in place of the one that pydantic derives from a validator.

    Attributes
    ----------
    schema : callable or dict
        The JSON Schema, or a function that makes it from a handler, which turns core schemas into JSON Schemas.
    """

    schema: Callable[[Handler], Schema] | Schema

    def __get_pydantic_json_schema__(self, _core: CoreSchema, handler: Handler) -> JsonSchemaValue:
        return self.schema(handler) if callable(self.schema) else dict(self.schema)

    def __hash__(self) -> int:
        return id(self)


def any_of(*options: Schema | type[BaseModel]) -> Written:
    """Return the annotation of a field whose input matches one of several schemas or models."""
    return Written(lambda handler: {"anyOf": [_schema_of(option, handler) for option in options]})


def _schema_of(option: Schema | type[BaseModel], handler: Handler) -> Schema:
    return option if isinstance(option, dict) else model_schema(option, handler)


def model_schema(model: type[BaseModel], handler: Handler) -> Schema:
    """Return the schema of another model, with the additions of its ``__get_pydantic_json_schema__``."""
    # called with the model alone, an annotation's handler passes over `__get_pydantic_json_schema__`
    return handler(core_schema.union_schema([model.__pydantic_core_schema__]))


def loaded(registry: Registry[Any]) -> Iterator[tuple[str, type[BaseModel]]]:
    """Yield names and models of a registry; a plugin that does not load is left out."""
    for name in registry:
        try:
            yield name, registry[name]
        except RegistryError:
            continue


def by_name(registry: Registry[Any], key: str, handler: Handler) -> Schema:
    """Return the schema of a mapping whose `key` names one of the models of a registry, plugins included."""
    title, open_titles = f"{registry.kind} by name", _OPEN.get()
    if title in open_titles:  # one of the models holds another of its kind, as a graded layer does
        return {_PART: title}
    models = dict(loaded(registry))
    before = _OPEN.set(open_titles | {title})
    try:
        options = [{"if": having(key, name), "then": model_schema(model, handler)} for name, model in models.items()]
    finally:
        _OPEN.reset(before)
    return {
        "title": title,
        "type": "object",
        "properties": {key: {"enum": list(models)}},
        "required": [key],
        "allOf": options,
    }


def having(key: str, value: str, *, default: bool = False) -> Schema:
    """Return the schema of a mapping whose `key` has a value; a `default` value may also be left out."""
    schema: Schema = {"properties": {key: {"const": value}}}
    return schema if default else {**schema, "required": [key]}


def schema_of(model: Any) -> Schema:
    """Return the JSON Schema of the inputs of a model or a union, with titled parts once each, in its ``$defs``."""
    generated = TypeAdapter(model).json_schema(schema_generator=Draft7)
    shared: Schema = {}
    whole = _hoisted(generated, shared, inside=False)
    whole["$defs"] = {
        name: whole.get("$defs", {}).get(name, shared.get(name)) for name in sorted({*whole.get("$defs", {}), *shared})
    }
    return {"$schema": Draft7.schema_dialect, **whole}


def _hoisted(value: Any, shared: Schema, *, inside: bool = True) -> Any:
    """Return a schema with references in place of its titled parts, which go to `shared`."""
    if isinstance(value, list):
        return [_hoisted(inner, shared) for inner in value]
    if not isinstance(value, dict):
        return value
    if _PART in value:
        return _reference(value[_PART])
    plain = {
        key: {name: _hoisted(inner, shared, inside=False) for name, inner in part.items()}
        if key == "$defs"
        else _hoisted(part, shared)
        for key, part in value.items()
    }
    if not inside or not isinstance(value.get("title"), str):
        return plain
    shared[value["title"]] = plain
    return _reference(value["title"])


def _reference(title: str) -> Schema:
    return {"$ref": f"#/$defs/{title.replace(' ', '%20')}"}


class Draft7(GenerateJsonSchema):
    """Pydantic's generator, without the titles that it makes of every name, and in draft 7."""

    schema_dialect = "http://json-schema.org/draft-07/schema#"

    def field_title_should_be_set(self, schema: Any) -> bool:
        """Leave out titles of fields, which would only repeat their names."""
        return False

    def handle_invalid_for_json_schema(self, schema: Any, error_info: str) -> JsonSchemaValue:
        """Return the schema that allows anything, for a plugin's validator without a schema."""
        return {}

    def tuple_schema(self, schema: core_schema.TupleSchema) -> JsonSchemaValue:
        """Return the schema of a tuple in draft 7: one schema for all entries where they are alike, else a list."""
        generated = super().tuple_schema(schema)
        entries = generated.pop("prefixItems", None)
        if entries:
            generated["items"] = entries[0] if all(entry == entries[0] for entry in entries) else entries
        return generated
