"""Units at the doors: text with a unit becomes an SI number, and nothing inside knows units.

Field types such as `Length` are plain numbers for pydantic and for the rest of the code; in an input they may also
be written as ``"1 mm"``. Their unit can be read back from the annotation (`Unit`) to print tables of fields.
"""

from __future__ import annotations

import cmath
import math
import re
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Annotated, Any

from pydantic import Field, GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticCustomError, core_schema

if TYPE_CHECKING:
    import pint

DIMENSIONLESS = ""


@cache
def _registry() -> pint.UnitRegistry[Any]:
    import pint  # heavy: only when some text carries a unit

    # "0.5 dB" is then a plain product of number and unit, and "20 degC" may be parsed at all
    return pint.UnitRegistry(autoconvert_offset_to_baseunit=True)


_NUMBER = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(.*?)\s*$", re.DOTALL)
_COMPLEX = re.compile(r"\s*\(?([-+0-9.eE]+[-+][0-9.eE+-]*[ij])\)?\s*(.*?)\s*$")


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
        When the text is no quantity or its unit does not fit, with what is allowed.
    """
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"{_show(value)} is no number{_in(unit)}")
    if not isinstance(value, str):
        return float(value)
    match = _NUMBER.match(value)
    if match is None:
        raise ValueError(f"{_show(value)} is no number{_in(unit)}; write {_example(unit)}")
    return float(match[1]) if not match[2] else _convert(float(match[1]), match[2], unit, value)


def parse_complex_quantity(value: object, unit: str) -> complex | float:
    """Return a number in SI that may be complex, as ``"1.2e5+2e4j Pa"``; see `parse_quantity`."""
    if isinstance(value, complex):
        return value
    match = _COMPLEX.match(value) if isinstance(value, str) else None
    if match is None:
        return parse_quantity(value, unit)
    try:
        number = complex(match[1].replace("i", "j"))
    except ValueError:
        raise ValueError(f"{_show(value)} is no complex number; write '1.2e5+2e4j {unit}'") from None
    return number if not match[2] else number * _convert(1.0, match[2], unit, str(value))


def _convert(number: float, written: str, unit: str, text: str) -> float:
    import pint

    registry = _registry()
    try:
        factor = registry.Quantity(number, written.replace("%", "percent").replace("°C", "degC"))
        return float(factor.to(unit or "dimensionless").magnitude)
    except pint.DimensionalityError:
        what = f"a quantity{_in(unit)}" if unit else "a pure number"
        raise ValueError(f"'{text}' has the wrong unit: this is {what}, as {_example(unit)}") from None
    except Exception:  # pint raises many kinds for text that is no unit
        raise ValueError(f"'{written}' in '{text}' is no unit known here; write {_example(unit)}") from None


def _in(unit: str) -> str:
    return f" in {unit}" if unit else ""


def _show(value: object) -> str:
    return f"'{value}'" if isinstance(value, str) else repr(value)


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
class Unit:
    """Annotation of a field: its SI unit, and the door through which text becomes a number.

    Parameters
    ----------
    symbol : str
        SI unit as pint writes it; empty for a pure number.
    allow_complex : bool
        Whether a complex number may stand here.
    """

    symbol: str
    allow_complex: bool = False

    def __get_pydantic_core_schema__(self, source: object, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_before_validator_function(self._parse, handler(source))

    def _parse(self, value: object) -> object:
        parse = parse_complex_quantity if self.allow_complex else parse_quantity
        try:
            number = parse(value, self.symbol)
        except ValueError as error:
            raise PydanticCustomError("quantity", "{reason}", {"reason": str(error)}) from None
        finite = cmath.isfinite(number) if isinstance(number, complex) else math.isfinite(number)
        if not finite:
            raise PydanticCustomError("quantity", "{reason}", {"reason": f"{value} is not finite"})
        return number


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
