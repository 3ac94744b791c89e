"""Units of the fields of layers and laws."""

from __future__ import annotations

from collections.abc import Iterator

from pydantic import BaseModel

from multilayer.units import base_unit, field_unit, parse_quantity

_TAKEN_AS_THEY_ARE = ("degree", "dB")  # formulae say what they make of them
_ROUNDING = 1e-12


def wrong_units(model: type[BaseModel]) -> Iterator[str]:
    """Give what is wrong with the units of a model's fields: those that are unknown, and those that are not SI."""
    for name, info in model.model_fields.items():
        symbol = field_unit(info) or ""
        try:
            parse_quantity(f"1 {symbol}", symbol)
            size = 1.0 if symbol in _TAKEN_AS_THEY_ARE else parse_quantity(f"1 {symbol}", base := base_unit(symbol))
        except ValueError:
            yield f"the unit '{symbol}' of field '{name}' is unknown, so that it takes no text; write it as 'kg/m^3'"
            continue
        if abs(size - 1) > _ROUNDING:
            yield (
                f"the unit '{symbol}' of field '{name}' is not SI: 1 {symbol} is {size:g} {base}, and numbers are SI "
                "in files and formulae; state that unit, as 'Pa' or 'kg/m^3', and convert nothing"
            )
