"""The effects of the virtual rig, one per file, by name; and the field type that takes one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, ValidationError, ValidationInfo

from multilayer.errors import show, suggest
from multilayer.json_schema import Written, by_name
from multilayer.models import mistake
from multilayer.registry import Registry, RegistryError, subclass_fault
from multilayer.rig.effect_base import Effect

EFFECTS: Registry[type[Effect]] = Registry("multilayer.rig_effects", "rig effect", subclass_fault(Effect, "effect"))


def _parse(value: Any, info: ValidationInfo) -> Effect:
    if isinstance(value, Effect):
        return value
    if not isinstance(value, Mapping):
        hint = f"write {{effect: {value}}}" if value in EFFECTS else "write {effect: NAME, ...}"
        raise _refused(f"must be a mapping of fields, not {show(value)}; {hint}", ())
    name = value.get("effect")
    if name is None:
        raise _refused(f"has no 'effect'; allowed: {', '.join(EFFECTS.names())}", ())
    if name not in EFFECTS:
        raise _refused(f"there is no effect {show(name)}; {suggest(str(name), EFFECTS.names())}", ("effect",))
    try:
        kind = EFFECTS[str(name)]
    except RegistryError as error:
        raise _refused(str(error), ("effect",)) from None
    return kind.model_validate(dict(value), context=info.context)


def _refused(reason: str, path: tuple[str, ...]) -> ValidationError:
    return ValidationError.from_exception_data("effect", [mistake("effect", path, reason, None)])


EffectField = Annotated[
    Effect,
    PlainValidator(_parse),
    PlainSerializer(lambda effect: effect.model_dump(mode="json", exclude_none=True)),
    Written(lambda handler: by_name(EFFECTS, "effect", handler)),
]

__all__ = ["EFFECTS", "Effect", "EffectField"]
