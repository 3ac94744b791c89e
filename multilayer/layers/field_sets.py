"""Layers whose fields come in sets, of which one must be given: those of a model, or alternatives for one property."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, ClassVar, Self, get_args

from pydantic import GetJsonSchemaHandler, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, InitErrorDetails

from multilayer.json_schema import having
from multilayer.layers.base import Layer
from multilayer.models import as_mistakes, mistake


class FieldSets(Layer):
    """A layer whose `field_sets` states which of its optional fields go together.

    Attributes
    ----------
    chooser : str
        The field on whose value the sets depend; empty where they are always the same.
    """

    chooser: ClassVar[str] = ""

    @classmethod
    def field_sets(cls, data: Mapping[str, Any]) -> tuple[str, tuple[tuple[str, ...], ...]]:
        """Return the owner of the sets, for messages, and the sets; none for data that other checks refuse."""
        raise NotImplementedError

    @classmethod
    def governed_fields(cls) -> frozenset[str]:
        """Return every field that stands in some set; the others are free."""
        raise NotImplementedError

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        reference = handler(core)
        if not cls.__abstractmethods__:
            handler.resolve_ref_schema(reference).update(cls._sets_written())
        return reference

    @classmethod
    def _sets_written(cls) -> dict[str, Any]:
        """Return which sets a JSON Schema allows, by the choice that they belong to."""
        info = cls.model_fields[cls.chooser] if cls.chooser else None
        if info is None:
            return _one_of(cls.governed_fields(), cls.field_sets({})[1])
        return {
            "allOf": [
                {
                    "if": having(cls.chooser, name, default=name == info.default),
                    "then": _one_of(cls.governed_fields(), cls.field_sets({cls.chooser: name})[1]),
                }
                for name in get_args(info.annotation)
            ]
        }

    @classmethod
    def fields_taken(cls, data: Mapping[str, Any]) -> frozenset[str]:
        """Return the fields that a layer of such data may have."""
        _, sets = cls.field_sets(data)
        taken = _nearest(cls._given(data), sets) if sets else ()
        return super().fields_taken(data) - cls.governed_fields() | set(taken)

    @classmethod
    def _given(cls, data: Mapping[str, Any]) -> set[str]:
        return {name for name in cls.governed_fields() if data.get(name) is not None}

    @model_validator(mode="wrap")
    @classmethod
    def _one_set(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        problems = cls._misfits(data) if isinstance(data, Mapping) else []
        try:
            layer = handler(data)
        except ValidationError as error:
            problems = [*as_mistakes(error.errors(include_url=False)), *problems]
        if problems:
            raise ValidationError.from_exception_data(cls.__name__, problems)
        return layer

    @classmethod
    def _misfits(cls, data: Mapping[str, Any]) -> list[InitErrorDetails]:
        what, sets = cls.field_sets(data)
        if not sets:
            return []
        given = cls._given(data)
        wanted = _nearest(given, sets)
        takes = f"{what} takes {', or '.join(_listed(fields) for fields in sets)}"
        absent, extra = set(wanted) & cls.governed_fields() - given, given.difference(wanted)
        return [
            *(mistake("missing", (name,), f"is missing; {takes}", data) for name in wanted if name in absent),
            *(
                mistake("extra_forbidden", (name,), f"does not belong here; {takes}", data[name])
                for name in data
                if name in extra
            ),
        ]


def _one_of(governed: frozenset[str], sets: Iterable[tuple[str, ...]]) -> dict[str, Any]:
    """Return the JSON Schema of mappings with one of the sets, and nothing governed beside it."""
    return {
        "anyOf": [
            {
                "required": list(fields),
                "properties": {name: {"type": "null"} for name in sorted(governed.difference(fields))},
            }
            for fields in sets
        ]
    }


def _nearest(given: set[str], sets: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    """Return the set with the fewest fields missing or too many."""
    return min(sets, key=lambda fields: len(given.symmetric_difference(fields)))


def _listed(fields: tuple[str, ...]) -> str:
    return fields[0] if len(fields) == 1 else f"{', '.join(fields[:-1])} and {fields[-1]}"
