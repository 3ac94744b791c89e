"""Base of everything that is read from an input: immutable, strict, and mistakes told in the user's words."""

from __future__ import annotations

from typing import Any, Self

from pydantic import BaseModel, ConfigDict, ModelWrapValidatorHandler, ValidationError, model_validator
from pydantic_core import ErrorDetails, InitErrorDetails, PydanticCustomError

from multilayer.errors import suggest


class Model(BaseModel):
    """A frozen pydantic model that refuses unknown fields and names the nearest one it has."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False, arbitrary_types_allowed=True)

    @model_validator(mode="wrap")
    @classmethod
    def _tell_in_words(cls, data: Any, handler: ModelWrapValidatorHandler[Self]) -> Self:
        try:
            return handler(data)
        except ValidationError as error:
            problems = [_reworded(details, cls) for details in error.errors(include_url=False)]
            raise ValidationError.from_exception_data(cls.__name__, problems) from None


def _reworded(error: ErrorDetails, model: type[Model]) -> InitErrorDetails:
    words = _words(error, model)
    custom = PydanticCustomError("input", "{reason}", {"reason": words})
    return InitErrorDetails(type=custom, loc=error["loc"], input=error["input"])


def _words(error: ErrorDetails, model: type[Model]) -> str:
    bounds = error.get("ctx", {})
    value = error["input"]
    match error["type"]:
        case "extra_forbidden":
            return f"there is no such field; {suggest(str(error['loc'][-1]), model.model_fields)}"
        case "missing":
            return "is missing; it is required"
        case "greater_than":
            return f"{value} is not allowed: it must be above {bounds['gt']}"
        case "greater_than_equal":
            return f"{value} is not allowed: it must be at least {bounds['ge']}"
        case "less_than":
            return f"{value} is not allowed: it must be below {bounds['lt']}"
        case "less_than_equal":
            return f"{value} is not allowed: it must be at most {bounds['le']}"
        case "literal_error":
            return f"{value!r} is not allowed; allowed: {bounds['expected']}"
        case "too_short":
            return "must not be empty"
        case "value_error":
            return str(bounds["error"])
        case "model_type" | "model_attributes_type" | "dict_type":
            return f"must be a mapping of fields, not {value!r}"
        case "list_type" | "tuple_type":
            return f"must be a list, not {value!r}"
        case _:
            return error["msg"]
