"""Base of everything that is read from an input: immutable, strict, with mistakes worded for the user."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, get_args, get_origin

from pydantic import BaseModel, BeforeValidator, ConfigDict, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from multilayer.errors import FieldError, Problem, show, suggest
from multilayer.units import field_unit

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass
else:
    ModelMetaclass = type(BaseModel)


class Model(BaseModel):
    """A frozen pydantic model that refuses unknown fields and names the nearest one it has."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True, defer_build=True
    )

    also_written: ClassVar[tuple[str, ...]] = ()  # keys of files beside the fields, which are read before them

    @model_validator(mode="wrap")
    @classmethod
    def _tell_in_words(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(data)
        except ValidationError as error:
            errors = [details for details in error.errors(include_url=False) if not _is_long_enough(details)]
            meant = {_meant(details, cls) for details in errors}
            errors = [details for details in errors if not (details["type"] == "missing" and details["loc"] in meant)]
            problems = [_reworded(details, cls) for details in errors]
            raise ValidationError.from_exception_data(cls.__name__, problems) from None

    def __repr_args__(self) -> Iterator[tuple[str | None, Any]]:
        """Give the fields that are set and not constant, as text; quantities with their units."""
        for name, info in type(self).model_fields.items():
            value = getattr(self, name, None)
            is_constant = get_origin(info.annotation) is Literal and len(get_args(info.annotation)) == 1
            if value is not None and not is_constant:
                yield name, _Shown(shown_value(value, field_unit(info)))


def _refuse_bool(value: Any) -> Any:
    if isinstance(value, bool):  # which is a whole number in Python, and to pydantic
        raise PydanticCustomError("int_type", "must be a whole number")
    return value


NO_BOOL = BeforeValidator(_refuse_bool)
"""Annotation of whole numbers, after their bounds, which schemas would not show otherwise."""


class InWords(ModelMetaclass):
    """Metaclass of models that people make in Python: a mistake in ``Stack(...)`` is an `InputError`.

    Where pydantic makes such a model inside another, the mistakes stay pydantic's, with their places.
    """

    def __call__(cls, *args: Any, **fields: Any) -> Any:  # noqa: N805
        """Return the model.

        Raises
        ------
        FieldError
            An `InputError` with every mistake found, each with its path.
        """
        try:
            return super().__call__(*args, **fields)
        except ValidationError as error:
            found = error.errors(include_url=False)
        texts = [details["msg"].removeprefix("Value error, ") for details in found]  # of validators of whole models
        places = [".".join(map(str, details["loc"])) for details in found]
        raise FieldError([Problem(text, place) for text, place in zip(texts, places, strict=True)])


class _Shown(str):
    """A text that is its own representation."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def shown_value(value: Any, unit: str | None) -> str:
    """Return a field's value as text, a quantity with its unit; for an array only its shape."""
    if getattr(value, "shape", ()):
        return f"array{value.shape} {unit or ''}".rstrip()
    if isinstance(value, float | int | complex) and not isinstance(value, bool):
        return f"{value:.6g} {unit or ''}".rstrip()
    return repr(value)


# pydantic's kind of error -> what the user reads; `value` is what was written, the rest pydantic's context
_WORDS = {
    "extra_forbidden": "there is no such field; {suggestion}",
    "missing": "is missing; it is required",
    "greater_than": "{value} is not allowed: it must be above {gt}",
    "greater_than_equal": "{value} is not allowed: it must be at least {ge}",
    "less_than": "{value} is not allowed: it must be below {lt}",
    "less_than_equal": "{value} is not allowed: it must be at most {le}",
    "literal_error": "{value} is not allowed; allowed: {expected}",
    "too_short": "must have at least {min_length} entries",
    "too_long": "must have at most {max_length} entries",
    "value_error": "{error}",
    **dict.fromkeys(("model_type", "model_attributes_type", "dict_type"), "must be a mapping of fields, not {value}"),
    **dict.fromkeys(("list_type", "tuple_type"), "must be a list, not {value}"),
    **dict.fromkeys(("int_type", "int_parsing", "int_from_float"), "must be a whole number, not {value}"),
    **dict.fromkeys(("float_type", "float_parsing"), "must be a number, not {value}"),
    **dict.fromkeys(("bool_type", "bool_parsing"), "must be true or false, not {value}"),
    "string_type": "must be text, in quotes, not {value}",
    "union_tag_invalid": "'{tag}' is not allowed as {discriminator}; allowed: {expected_tags}",
    "union_tag_not_found": "has no {discriminator}",
}

# the two kinds of errors whose place is that of a name, not of a value: `config.validate` must recognise them
_LOCATED_BY_NAME = ("missing", "extra_forbidden")


def _is_long_enough(error: ErrorDetails) -> bool:
    # of a tuple pydantic counts the good entries only: a bad one is no missing one
    written = error["input"]
    return (
        error["type"] == "too_short"
        and isinstance(written, list | tuple)
        and len(written) >= error["ctx"]["min_length"]
    )


def _meant(error: ErrorDetails, model: type[Model]) -> tuple[int | str, ...] | None:
    """Return the path of the field that an unknown one is meant to be; it is missing, but that is no second mistake."""
    if error["type"] != "extra_forbidden" or len(error["loc"]) != 1:
        return None
    near = get_close_matches(str(error["loc"][0]), model.model_fields, n=1)
    return tuple(near) or None


def _reworded(error: ErrorDetails, model: type[Model]) -> InitErrorDetails:
    kind = error["type"] if error["type"] in _LOCATED_BY_NAME else "input"
    return mistake(kind, error["loc"], _words(error, model), error["input"])


def _words(error: ErrorDetails, model: type[Model]) -> str:
    context = error.get("ctx", {})
    if "reason" in context:  # worded already, by a field or by a model inside this one
        return str(context["reason"])
    if context.get("min_length") == 1:
        return "must not be empty"
    words = _WORDS.get(error["type"])
    if words is None:
        return error["msg"]
    last = str(error["loc"][-1]) if error["loc"] else ""
    suggestion = suggest(last, {*model.model_fields, *model.also_written} - {last})
    return words.format_map({**context, "value": show(error["input"]), "suggestion": suggestion})


def mistake(kind: Any, place: tuple[str | int, ...], reason: str, value: Any) -> InitErrorDetails:
    """Return one mistake for a pydantic error, worded already.

    Parameters
    ----------
    kind : str
        ``missing`` and ``extra_forbidden`` are located by the field's name, others by its value.
    place : tuple
        Path into the data.
    reason : str
        What the user reads.
    value : Any
        What was written.
    """
    return InitErrorDetails(type=PydanticCustomError(kind, "{reason}", {"reason": reason}), loc=place, input=value)


def misspelt(place: tuple[str | int, ...], meant: str) -> InitErrorDetails:
    """Return the mistake of a key that is no field, and another one was meant.

    Parameters
    ----------
    place : tuple
        Path into the data, the key its last.
    meant : str
    """
    return mistake("extra_forbidden", place, f"there is no such field; did you mean '{meant}'?", place[-1])


def as_mistakes(errors: Iterable[ErrorDetails]) -> list[InitErrorDetails]:
    """Return the mistakes of a pydantic error that is worded already, to raise them again among others."""
    return [mistake(details["type"], details["loc"], details["msg"], details["input"]) for details in errors]


def refuse_unknown_keys(model: type[Model], data: Any, known: Sequence[str], suggested: Sequence[str] = ()) -> None:
    """Refuse keys of a mapping that are no fields, for a model whose fields are written by other names.

    Pydantic would place such a mistake, but `suggest` the names that the fields have in Python.

    Parameters
    ----------
    model : type
    data : Any
        What was written; anything but a mapping is left to pydantic.
    known : sequence of str
        The names that may be written.
    suggested : sequence of str
        Further names to suggest, as of a model that takes the same place.
    """
    if not isinstance(data, Mapping):
        return
    unknown = [
        mistake("extra_forbidden", (key,), f"there is no such field; {suggest(str(key), (*known, *suggested))}", key)
        for key in data
        if key not in (*known, *model.model_fields)
    ]
    if unknown:
        raise ValidationError.from_exception_data(model.__name__, unknown)


def refuse(model: Model, mistakes: Iterable[tuple[tuple[str | int, ...], str, Any]]) -> None:
    """Raise a ValidationError that places each mistake at its own field; nothing when there is none.

    Parameters
    ----------
    model : Model
        Whose validator this is called from.
    mistakes : iterable of (path, text, value)
        Path into the model, what is wrong with a remedy, and what was written.
    """
    errors = [mistake("input", path, text, value) for path, text, value in mistakes]
    if errors:
        raise ValidationError.from_exception_data(type(model).__name__, errors)
