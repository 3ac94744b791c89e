"""Moduli from a table, as measured."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.files import exists
from multilayer.media.laws.base import LossModulus, ModulusLaw
from multilayer.tables import Header, read_text_table
from multilayer.text_lines import Layout
from multilayer.units import Frequency, Pressure

_UNITS = {"frequency": "Hz", "storage_modulus": "Pa", "loss_modulus": "Pa"}  # of the columns, in this order


class Table(ModulusLaw):
    """E1 and E2 from a table, linear in the logarithm of frequency; no extrapolation.

    It is as causal as its values are (`kramers_kronig.check_kramers_kronig`).

    In an input, `file` may name a CSV file (beside the YAML file) with the columns frequency, E1, E2; its values then
    stand in the fields. See `read_modulus_table`.
    """

    causal: ClassVar[bool] = False
    grid: ClassVar[tuple[str, ...]] = ("frequency",)
    law: Literal["table"] = "table"
    frequency: Annotated[tuple[Frequency, ...], Field(min_length=2)]
    storage_modulus: Annotated[tuple[Pressure, ...], Field(min_length=2)]
    loss_modulus: Annotated[tuple[LossModulus, ...], Field(min_length=2)]

    @classmethod
    def __get_pydantic_json_schema__(cls, core: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        reference = handler(core)
        schema = handler.resolve_ref_schema(reference)
        columns = [name for name in schema.pop("required") if name != "law"]
        schema["properties"]["file"] = {"type": "string", "description": "A CSV file with the three columns."}
        schema["oneOf"] = [{"required": ["file"]}, {"required": columns}]
        return reference

    @model_validator(mode="before")
    @classmethod
    def _read_file(cls, data: Any, info: ValidationInfo) -> Any:
        if not isinstance(data, Mapping) or "file" not in data:
            return data
        if beside := [name for name in _UNITS if name in data]:
            raise ValueError(f"file stands beside {', '.join(beside)}; give the file, or the three columns")
        folder = (info.context or {}).get("folder", Path())
        columns = read_modulus_table(Path(folder) / str(data["file"]))
        rest = {key: value for key, value in data.items() if key != "file"}
        return {**rest, **{name: column.tolist() for name, column in zip(_UNITS, columns, strict=True)}}

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if not len(self.frequency) == len(self.storage_modulus) == len(self.loss_modulus):
            raise ValueError("frequency, storage_modulus and loss_modulus must have the same length")
        if any(b <= a for a, b in zip(self.frequency, self.frequency[1:], strict=False)):
            raise ValueError("the frequencies of a table must increase")
        return self

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        f = np.abs(np.asarray(frequency, dtype=float))
        low, high = self.frequency[0], self.frequency[-1]
        if f.size and (f.min() < low * (1 - 1e-12) or f.max() > high * (1 + 1e-12)):
            raise InputError(
                f"the modulus table holds {low:g} to {high:g} Hz and {f.min():g} to {f.max():g} Hz are asked for; "
                "extend the table or narrow the frequencies"
            )
        x, grid = np.log(f), np.log(self.frequency)
        loss = np.copysign(np.interp(x, grid, self.loss_modulus), frequency)
        return np.asarray(np.interp(x, grid, self.storage_modulus) + 1j * loss)


def read_modulus_table(path: Path) -> tuple[RealArray, RealArray, RealArray]:
    """Return frequency (Hz), E1 and E2 (Pa) from a CSV file with one header line and these three columns.

    Their units stand in the header, as ``E1 [MPa]``; where it has none, they are Hz and Pa.

    Raises
    ------
    ValueError
        When the file is missing or is not such a table.
    """
    if not exists(path):
        raise ValueError(f"there is no file {path}; the path is relative to the YAML file")
    try:
        frequency, storage, loss = _columns(path)
    except InputError as error:
        raise ValueError(str(error)) from None
    return frequency, storage, loss


def _columns(path: Path) -> list[RealArray]:
    table = read_text_table(path)
    wanted = "the first line that is no comment must name three columns, as 'frequency [Hz], E1 [Pa], E2 [Pa]'"
    if len(table.headers) != len(_UNITS):
        raise table.error(f"has {len(table.headers)} columns; {wanted}", table.line)
    if Layout(None, 0).is_row(table.names):
        raise table.error(f"begins with numbers; {wanted}", table.line)
    try:
        factors = [_factor(header, unit) for header, unit in zip(table.headers, _UNITS.values(), strict=True)]
    except ValueError as error:
        raise table.error(str(error), table.line) from None
    numbers = table.numbers(range(len(factors)))
    columns = [numbers[i] * factor for i, factor in enumerate(factors)]
    for (line, _), frequency, storage, loss in zip(table.rows, *columns, strict=True):
        if not (frequency > 0 and storage > 0 and loss >= 0):
            raise table.error("frequency and E1 must be above 0, E2 at least 0", line)
    if len(table.rows) < 2:
        raise table.error("needs two rows of values at least")
    return columns


def _factor(header: Header, unit: str) -> float:
    """Return what 1 in a column is in SI, which its numbers are in where the header tells no unit."""
    return replace(header, unit=header.unit or header.text.partition("/")[2].strip()).factor(unit)
