"""Units of inputs: text with a unit becomes a number in SI, and the rest of the code has SI numbers only.

Field types such as `Length` are plain numbers for pydantic and for the rest of the code; in an input they may
also be written as ``"1 mm"``. Their unit can be read back from the annotation (`UnitLabel`), to print tables.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import TYPE_CHECKING, Annotated, Any, get_args

import numpy as np
from pydantic import Field, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic.fields import FieldInfo
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

from multilayer.bounds import NUMBER_CHARACTERS, magnitudes
from multilayer.errors import show
from multilayer.json_schema import QUANTITY_TEXT, UNSIGNED_TEXT

if TYPE_CHECKING:
    import pint

DIMENSIONLESS = ""
DB_PER_NEPER = 20 / math.log(10)
"""Of levels; of a power it is half as much per unit of its logarithm."""


@cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint  # heavy: only when some text carries a unit

    # without it pint refuses "20 degC"
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


_DIGITS = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
_NUMBER = re.compile(rf"[-+]?{_DIGITS}")
_COMPLEX = re.compile(rf"\(?\s*(?:([-+]?{_DIGITS})\s*(?=[-+]))?([-+]?)\s*({_DIGITS})?[ij](?!\w)\s*\)?")

# What may stand in a unit: pint evaluates it as a formula, and "m**9**9**9" would keep it busy for ever.
_SPELLINGS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻.·⋅", "0123456789-***") | {ord("°"): "degree", ord("%"): "percent"}
_POWER = re.compile(r"(?<=[^\W\d_])(-?[1-9])(?!\w)")  # kg/m3, N s m-4
_UNIT = re.compile(r"(?:[^\W\d]\w*+(?:\s*(?:\*\*|\^)\s*-?[1-9])?|1(?=\s*/)|[*/()\s])+")
_LONGEST_UNIT = 60
_COMMA = re.compile(r",([0-9]+)")
_THOUSANDS = re.compile(r"[-+]?[1-9][0-9]{0,2}((?:,[0-9]{3})+)(?![0-9,])")
_RAYL = re.compile(r"\brayls?\b", re.IGNORECASE)
_RAYLS = {  # what takes its place
    "N*s/m^3": "Pa s/m",
    "N*s/m^4": "N s/m^4: 1 rayl/cm is 100 of them (MKS) or 1000 (CGS)",
}


def parse_quantity(value: object, unit: str) -> float:
    """Return a number in SI.

    Parameters
    ----------
    value : float or str
        A number, taken as SI, or text such as ``"70 GPa"``.
    unit : str
        The SI unit wanted, as pint writes it; empty for a pure number.

    Raises
    ------
    ValueError
        When the text is no quantity, its unit does not fit, or it is far from anything physical (`bounds.MAGNITUDES`),
        with what is allowed.
    """
    number = _parse_real(value, unit)
    _refuse_extreme(value, number, unit)
    return number


def _refuse_extreme(value: object, number: complex, unit: str) -> None:
    """Refuse a number, written as `value`, that is larger or smaller than its unit allows."""
    if refusal := magnitudes(unit).refusal(number, unit):
        raise ValueError(f"{show(value)} is not allowed: it {refusal}")


def _parse_real(value: object, unit: str) -> float:
    if isinstance(value, int | float) and not isinstance(value, bool):
        return _real(value)
    if isinstance(value, str):
        _refuse_long(value)
    match = _NUMBER.match(value.strip()) if isinstance(value, str) else None
    if match is None:
        raise ValueError(f"{show(value)} is no number{_in(unit)}; write {_example(unit)}")
    number, written = float(match[0]), match.string[match.end() :].strip()
    if comma := _COMMA.match(written):
        remedy = f"'{match[0]}.{comma[1]}{written[comma.end() :]}'"
        if thousands := _THOUSANDS.match(match.string):
            decimals = remedy if thousands[1].count(",") == 1 else "as in '1.5'"
            whole = thousands[0].replace(",", "") + match.string[thousands.end() :]
            remedy = f"{decimals}, and thousands have no mark, '{whole}'"
        raise ValueError(f"{show(value)} has a comma: decimals follow a point, {remedy}")
    return _convert(number, written, unit, match.string) if written else number


def _real(value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        return math.inf if value > 0 else -math.inf


def parse_complex_quantity(value: object, unit: str) -> complex | float:
    """Return a number in SI that may be complex, as ``"1.2e5+2e4j Pa"``; see `parse_quantity`."""
    number = _parse_complex(value, unit)
    _refuse_extreme(value, number, unit)
    return number


def _parse_complex(value: object, unit: str) -> complex | float:
    if isinstance(value, complex):
        return value
    if isinstance(value, str):
        _refuse_long(value)
    match = _COMPLEX.match(value.strip()) if isinstance(value, str) else None
    if match is None:
        return _parse_real(value, unit)
    real, sign, imaginary = match.groups()
    number = complex(float(real or 0), float(f"{sign}{imaginary or 1}"))
    written = match.string[match.end() :].strip()
    return number * _convert(1.0, written, unit, match.string) if written else number


def _refuse_long(text: str) -> None:
    # ahead of the patterns above, which go back and forth over digits
    if len(text) > NUMBER_CHARACTERS.most:
        raise ValueError(f"{show(text)} is too long for a number: at most {NUMBER_CHARACTERS.most} characters")


def _convert(number: float, written: str, unit: str, text: str) -> float:
    factor = _factor(written, unit)
    if factor is None and _RAYL.search(written):
        raise ValueError(f"{show(text)}: a rayl is 1 Pa s/m (MKS) or 10 Pa s/m (CGS); write {_RAYLS.get(unit, unit)}")
    if factor is None:
        raise ValueError(f"{show(written)} in {show(text)} is no unit known here; write {_example(unit)}")
    if factor == 0:
        what = f"a quantity{_in(unit)}" if unit else "a pure number"
        raise ValueError(f"{show(text)} has the wrong unit: this is {what}, as {_example(unit)}")
    return number * factor if math.isfinite(factor) else _in_si(number, _spelled(written), unit)


def _spelled(written: str) -> str:
    """Return a unit as pint spells it."""
    return _POWER.sub(r"^\1", written.translate(_SPELLINGS))


@lru_cache(maxsize=1000)  # pint takes 0.2 ms for what a file says a hundred times
def _factor(written: str, unit: str) -> float | None:
    """Return a unit as written in `unit`: 0 when it does not fit, NaN when its zero is another, None when unknown."""
    spelled = _spelled(written)
    if len(spelled) > _LONGEST_UNIT or not _UNIT.fullmatch(spelled):
        return None
    registry = _registry()
    try:
        # base units, not dimensions: for pint rad/s and Hz are of one dimension, and 2 pi would be lost
        if registry.get_root_units(spelled)[1] != registry.get_root_units(unit)[1]:
            return 0.0
        with np.errstate(divide="ignore"):  # a share in dB: of nothing there is no level
            zero = _in_si(0.0, spelled, unit)
        if zero != 0:
            return math.nan if unit and math.isfinite(zero) else 0.0  # dB: of power or of amplitude?
        return _in_si(1.0, spelled, unit)
    except Exception:  # pint raises many kinds for text that is no unit
        return None


def base_unit(unit: str) -> str:
    """Return what a unit is in units of the SI without prefixes, as pint writes it: ``kilogram / meter ** 3`` of g/cm3.

    Raises
    ------
    ValueError
        When the unit is not known.
    """
    import pint

    try:
        return str(_registry().get_base_units(_spelled(unit))[1])
    except (pint.PintError, TypeError) as error:
        raise ValueError(f"{show(unit)} is no unit known here") from error


def _in_si(number: float, spelled: str, unit: str) -> float:
    return float(_registry().Quantity(number, spelled).to(unit).magnitude)


def _in(unit: str) -> str:
    return f" in {unit}" if unit else ""


_EXAMPLES = {
    "m": "0.05 or '50 mm'",
    "kg/m^3": "2700 or '2700 kg/m^3'",
    "Pa": "1.2e5 or '120 kPa'",
    "K": "293.15 or '20 degC'",
    "N*s/m^4": "15000 or '15 kN s/m^4'",
    "Pa*s": "1.84e-5 or '18.4 uPa s'",
    "s": "1e-3 or '1 ms'",
    "Hz": "1000 or '1 kHz'",
    "m/s": "343 or '343 m/s'",
    "kg": "0.001 or '1 g'",
    "m/s^2": "5 or '5 m/s^2'",
    "": "0.98 or '98 %'",
}


def _example(unit: str) -> str:
    return _EXAMPLES.get(unit, f"a number or a text such as '1 {unit}'")


@dataclass(frozen=True)
class UnitLabel:
    """Annotation of a field: its SI unit as pint writes it, empty for a pure number; it parses nothing.

    Powers may be written as in files, kg/m3 for kg/m^3.
    """

    symbol: str

    def __post_init__(self) -> None:
        object.__setattr__(self, "symbol", _spelled(self.symbol))


@dataclass(frozen=True)
class Unit(UnitLabel):
    """Annotation of a real field: its SI unit, and the validator that turns text into a number."""

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._parse, handler(source))

    def __get_pydantic_json_schema__(self, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        number = handler(core)  # its bounds hold for numbers; of text the pattern can only check the sign
        least = max(number.get("minimum", -1), number.get("exclusiveMinimum", -1))
        pattern = UNSIGNED_TEXT if least >= 0 and self.symbol != "K" else QUANTITY_TEXT  # -5 degC is above 0 K
        return {**number, "type": ["number", "string"], "pattern": pattern, "description": self.described}

    @property
    def described(self) -> str:
        """Description for the reader of a schema: the unit, and examples."""
        return f"In {self.symbol}: {_example(self.symbol)}." if self.symbol else f"A pure number: {_example('')}."

    def _parse(self, value: object) -> object:
        try:
            number = parse_quantity(value, self.symbol)
        except ValueError as error:
            raise PydanticCustomError("quantity", "{reason}", {"reason": str(error)}) from None
        if not math.isfinite(number):
            raise PydanticCustomError("quantity", "{reason}", {"reason": f"{show(value)} is not finite"})
        return number


def field_unit(info: FieldInfo) -> str | None:
    """Return the unit that a field of a model is annotated with, also inside ``T | None``; None for no quantity."""
    return next((item.symbol for item in annotated_with(info) if isinstance(item, UnitLabel)), None)


def annotated_with(info: FieldInfo) -> Iterator[Any]:
    """Give what a field of a model is annotated with, also inside ``T | None`` and of the entries of a list."""
    inner = (item for part in get_args(info.annotation) for item in getattr(part, "__metadata__", ()))
    for item in (*info.metadata, *inner):
        yield from item.metadata if isinstance(item, FieldInfo) else [item]


def field_bounds(info: FieldInfo) -> list[tuple[str, float]]:
    """Return what bounds a field of a model, also inside ``T | None``, as ``("gt", 0.0)``: gt, ge, lt or le."""
    return [(key, getattr(c, key)) for c in annotated_with(info) for key in ("gt", "ge", "lt", "le") if hasattr(c, key)]


def field_limits(info: FieldInfo) -> tuple[float, float]:
    """Return the least and the largest value of a model's field, infinite without bounds; both may be excluded."""
    bounds = field_bounds(info)
    least = max((float(end) for side, end in bounds if side in ("gt", "ge")), default=-math.inf)
    return least, min((float(end) for side, end in bounds if side in ("lt", "le")), default=math.inf)


Positive = Field(gt=0)
NonNegative = Field(ge=0)

Length = Annotated[float, Positive, Unit("m")]
Area = Annotated[float, Positive, Unit("m^2")]
Density = Annotated[float, Positive, Unit("kg/m^3")]
Speed = Annotated[float, Positive, Unit("m/s")]
Pressure = Annotated[float, Positive, Unit("Pa")]
Temperature = Annotated[float, Positive, Unit("K")]
Viscosity = Annotated[float, Positive, Unit("Pa*s")]
FlowResistivity = Annotated[float, Positive, Unit("N*s/m^4")]
Frequency = Annotated[float, Positive, Unit("Hz")]
Duration = Annotated[float, Positive, Unit("s")]
Acceleration = Annotated[float, Positive, Unit("m/s^2")]
Ratio = Annotated[float, NonNegative, Unit(DIMENSIONLESS)]
PositiveRatio = Annotated[float, Positive, Unit(DIMENSIONLESS)]
PoissonRatio = Annotated[float, Field(gt=-1, lt=0.5), Unit(DIMENSIONLESS)]
Porosity = Annotated[float, Field(gt=0, lt=1), Unit(DIMENSIONLESS)]
Tortuosity = Annotated[float, Field(ge=1), Unit(DIMENSIONLESS)]


def asked_back(what: str, value: float, unit: str, other: str) -> str:
    """Return the question whether a value, hardly ever so in SI, was meant in another unit."""
    return f"{what} of {value:g} {unit}; numbers without a unit are in {unit}: is '{value:g} {other}' meant?"
