"""Moduli from a table, as measured."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field, GetJsonSchemaHandler, ValidationInfo, model_validator
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.bounds import TEXT_BYTES
from multilayer.errors import InputError
from multilayer.files import ENDLESS, is_endless
from multilayer.media.laws.base import LossModulus, ModulusLaw
from multilayer.units import Frequency, Pressure
from multilayer.writing.manifest import note_input


class Table(ModulusLaw):
    """E1 and E2 from a table, linear in the logarithm of frequency; no extrapolation.

    It is as causal as its values are (`kramers_kronig.check_kramers_kronig`).

    In an input, `file` may name a CSV file (beside the YAML file) with the columns frequency (Hz), E1, E2 (Pa);
    its values then stand in the fields.
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
        folder = (info.context or {}).get("folder", Path())
        columns = read_modulus_table(Path(folder) / str(data["file"]))
        names = ("frequency", "storage_modulus", "loss_modulus")
        rest = {key: value for key, value in data.items() if key != "file"}
        return {**rest, **{name: column.tolist() for name, column in zip(names, columns, strict=True)}}

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

    Raises
    ------
    ValueError
        When the file is missing or is not such a table.
    """
    wanted = "a modulus table has one header line and the columns frequency (Hz), E1 and E2 (Pa)"
    note_input(path)
    try:
        if is_endless(path):
            raise ValueError(f"it {ENDLESS}")
        if (size := path.stat().st_size) > TEXT_BYTES.most:
            raise ValueError(str(TEXT_BYTES.refusal(size)))
        lines = path.read_text(encoding="utf-8").splitlines()[1:]
        rows = [[float(cell) for cell in line.split(",")] for line in lines if line.strip() and line[0] != "#"]
        columns = np.array(rows, dtype=float).reshape(len(rows), 3)
    except OSError:
        raise ValueError(f"there is no file {path}; the path is relative to the YAML file") from None
    except ValueError as error:
        raise ValueError(f"{path} is no table ({error}); {wanted}") from None
    for number, row in enumerate(columns, start=1):
        if not (np.all(np.isfinite(row)) and row[0] > 0 and row[1] > 0 and row[2] >= 0):
            raise ValueError(f"{path}, row {number}: frequency and E1 must be above 0, E2 at least 0")
    if len(columns) < 2:
        raise ValueError(f"{path} has {len(columns)} rows, at least two are needed; {wanted}")
    return columns[:, 0], columns[:, 1], columns[:, 2]
