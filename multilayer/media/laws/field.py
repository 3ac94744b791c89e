"""The field type that takes a modulus: a number, a complex number or a law."""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import PlainSerializer, PlainValidator, ValidationInfo
from pydantic_core import PydanticCustomError

from multilayer.arrays import ArrayLike, Numeric
from multilayer.errors import suggest
from multilayer.json_schema import COMPLEX_TEXT, Handler, Schema, Written, by_name
from multilayer.media.laws.base import LAWS, ModulusLaw
from multilayer.registry import RegistryError
from multilayer.units import UnitLabel, parse_complex_quantity


def _parse_modulus(value: Any, info: ValidationInfo) -> Any:
    if isinstance(value, ModulusLaw):
        return value
    if isinstance(value, Mapping):
        return _parse_law(value, info)
    try:
        number = parse_complex_quantity(value, "Pa")
    except ValueError as error:
        raise _refused(f"{error}, or a law such as {{law: loss_factor, ...}}") from None
    if not cmath.isfinite(number) or number.real <= 0 or number.imag < 0:
        raise _refused(f"{value} is no modulus: its real part must be above 0 and its imaginary part at least 0")
    return number


def _parse_law(value: Mapping[str, Any], info: ValidationInfo) -> ModulusLaw:
    name = value.get("law")
    if name not in LAWS:
        raise _refused(f"law {name!r} is not known; {suggest(str(name), LAWS.names())}")
    try:
        law = LAWS[str(name)]
    except RegistryError as error:
        raise _refused(str(error)) from None
    return law.model_validate(dict(value), context=info.context)


def _refused(reason: str) -> PydanticCustomError:
    return PydanticCustomError("modulus", "{reason}", {"reason": reason})


def _serialise_modulus(value: Any) -> Any:
    if isinstance(value, ModulusLaw):
        return value.model_dump(mode="json")
    return f"{value.real!r}{value.imag:+}j" if isinstance(value, complex) else value


def _written(handler: Handler) -> Schema:
    number = {"type": ["number", "string"], "exclusiveMinimum": 0, "pattern": COMPLEX_TEXT}
    described = "In Pa: a number, text such as '120 kPa' or '1.2e5+2e4j Pa', or a law {law: NAME, ...}."
    return {
        "title": "modulus",
        "description": described,
        "if": {"type": "object"},
        "then": by_name(LAWS, "law", handler),
        "else": number,
    }


Modulus = Annotated[
    float | complex | ModulusLaw,
    PlainValidator(_parse_modulus),
    PlainSerializer(_serialise_modulus, when_used="json"),
    UnitLabel("Pa"),
    Written(_written),
]


def complex_modulus(modulus: Any, loss_factor: Numeric, frequency: ArrayLike) -> Numeric:
    """Return E (1 + i eta), Pa, of a number, an array or a law at `frequency`, Hz.

    Parameters
    ----------
    modulus : float, complex, array or ModulusLaw
        Arrays broadcast against `frequency`.
    loss_factor : float or array
        Structural loss factor on top of it.
    frequency : array
        Hz.
    """
    value = modulus(frequency) if isinstance(modulus, ModulusLaw) else modulus
    scaled: Numeric = value * (1 + 1j * loss_factor)
    return scaled
