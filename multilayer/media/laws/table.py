"""Moduli from a table, as measured."""

from __future__ import annotations

import re
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
from multilayer.tables import Table as TextTable
from multilayer.text_lines import Layout
from multilayer.units import Frequency, Pressure

_UNITS = {"frequency": "Hz", "storage_modulus": "Pa", "loss_modulus": "Pa"}  # of the columns, in this order
_SHEAR, _TAN = "shear_modulus", "loss_factor"
_WORDS = {  # words of a header that tell what its column holds, in small letters; the first line with such a word does
    _SHEAR: {"shear", "g", "g1", "g2", "g'", "g''"},
    "frequency": {"frequency", "freq", "f"},
    _TAN: {"tan", "tand", "tanδ", "tandelta", "tangent", "factor", "damping", "eta", "η"},
    "loss_modulus": {"e2", "e''", "loss"},
    "storage_modulus": {"e1", "e'", "storage"},
}
_PRIMES = str.maketrans({"′": "'", "’": "'", "`": "'", "´": "'", "″": "''", "”": "''", '"': "''"})
_TAN_OF = re.compile(r"\btan\s*[\[(]?\s*(?:delta|δ|d)\s*[\])]?", re.IGNORECASE)


class Table(ModulusLaw):
    """E1 and E2 from a table, linear in the logarithm of frequency; no extrapolation.

    It is as causal as its values are (`kramers_kronig.check_kramers_kronig`).

    In an input, `file` may name a CSV file (beside the YAML file) with the columns frequency, E1, and E2 or tan delta;
    its values then stand in the fields. See `read_modulus_table`.
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
    """Return frequency (Hz), E1 and E2 (Pa) from a CSV file with one header line and three columns.

    The header names them, in any order: frequency; E1, E' or storage modulus; E2, E'' or loss modulus, or in its place
    tan delta, eta or loss factor, which E1 is multiplied by. What names tell none of these is, in this order, what is
    missing. Units stand in the header, as ``E1 [MPa]``; where it has none, they are Hz and Pa.

    Raises
    ------
    ValueError
        When the file is missing or is not such a table, or holds shear moduli.
    """
    if not exists(path):
        raise ValueError(f"there is no file {path}; the path is relative to the YAML file")
    try:
        frequency, storage, loss = _columns(path)
    except InputError as error:
        raise ValueError(str(error)) from None
    return frequency, storage, loss


def _columns(path: Path) -> tuple[RealArray, RealArray, RealArray]:
    table = read_text_table(path)
    wanted = "the first line that is no comment must name three columns, as 'frequency [Hz], E1 [Pa], E2 [Pa]'"
    if len(table.headers) != len(_UNITS):
        raise table.error(f"has {len(table.headers)} columns; {wanted}", table.line)
    if Layout(None, 0).is_row(table.names):
        raise table.error(f"begins with numbers; {wanted}", table.line)
    headers = [_with_unit(header) for header in table.headers]
    roles = _roles(table, headers)
    try:
        factors = [_factor(header, _UNITS.get(role, "")) for header, role in zip(headers, roles, strict=True)]
    except ValueError as error:
        raise table.error(str(error), table.line) from None
    numbers = table.numbers(range(len(factors)))
    columns = {role: numbers[i] * factors[i] for i, role in enumerate(roles)}
    frequency, storage = columns["frequency"], columns["storage_modulus"]
    loss, told = (columns[_TAN] * storage, "tan delta") if _TAN in columns else (columns["loss_modulus"], "E2")
    for (line, _), f, e1, e2 in zip(table.rows, frequency, storage, loss, strict=True):
        if not (f > 0 and e1 > 0 and e2 >= 0):
            raise table.error(f"frequency and E1 must be above 0, {told} at least 0", line)
    if len(table.rows) < 2:
        raise table.error("needs two rows of values at least")
    return frequency, storage, loss


def _roles(table: TextTable, headers: list[Header]) -> list[str]:
    """Return what each column holds, by its name, and by its position where that tells nothing."""
    named = [_role(header) for header in headers]
    if _SHEAR in named:
        text = f"column '{headers[named.index(_SHEAR)].text}' holds shear moduli"
        raise table.error(f"{text}; write Young's moduli, E = 2 (1 + nu) G, as 'E1 [Pa]' and 'E2 [Pa]'", table.line)
    loss = _TAN if _TAN in named else "loss_modulus"
    missing = [role for role in ("frequency", "storage_modulus", loss) if role not in named]
    if named.count(None) != len(missing):
        held = ", ".join(f"'{header.text}'" for header in headers)
        text = f"columns {held} hold the same twice; one must be the frequency, one E1, and one E2 or tan delta"
        raise table.error(text, table.line)
    return [role or missing.pop(0) for role in named]


def _role(header: Header) -> str | None:
    words = set(re.split(r"[\s_,;:*|]+", header.name.translate(_PRIMES)))
    return next((role for role, telling in _WORDS.items() if words & telling), None)


def _with_unit(header: Header) -> Header:
    """Return a header whose unit may stand behind a slash, as ``E1 / MPa``, and whose tan may have brackets."""
    plain = Header.of(_TAN_OF.sub("tan delta", header.text))
    before, slash, behind = plain.text.partition("/")
    if not slash or plain.unit is not None:
        return replace(plain, text=header.text)
    return replace(Header.of(before), text=header.text, unit=behind.strip())


def _factor(header: Header, unit: str) -> float:
    """Return what 1 in a column is in SI, which its numbers are in where the header tells no unit."""
    return 1.0 if header.unit is None else header.factor(unit)
