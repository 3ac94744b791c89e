"""Modulus laws: Young's modulus E1 + i E2 as a function of frequency, and the field type that takes one.

Wherever a modulus stands in an input, a number, a complex number (``"1.2e5+2e4j Pa"``) or a law (``{law:
fractional_zener, ...}``) may stand. Laws come from the registry `LAWS`, fed by the entry points
``multilayer.modulus_laws``.
"""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, ValidationInfo, model_validator
from pydantic_core import PydanticCustomError

from multilayer.arrays import ArrayLike, ComplexArray, Numeric, RealArray
from multilayer.errors import InputError, suggest
from multilayer.models import Model
from multilayer.registry import Registry, RegistryError
from multilayer.units import (
    DIMENSIONLESS,
    Duration,
    Frequency,
    NonNegative,
    Pressure,
    Ratio,
    Unit,
    UnitLabel,
    Viscosity,
    parse_complex_quantity,
)

LossModulus = Annotated[float, NonNegative, Unit("Pa")]


class ModulusLaw(Model):
    """A modulus law: subclass it, give ``law`` a `Literal` name, and define `__call__`.

    Time exp(+i w t): a passive law has Re(E) > 0 and Im(E) >= 0 at every frequency.
    """

    law: str

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        """Return E1 + i E2, Pa, at `frequency` in Hz (any shape); parameter arrays broadcast against it."""
        raise NotImplementedError


LAWS: Registry[type[ModulusLaw]] = Registry("multilayer.modulus_laws", "modulus law")


class Constant(ModulusLaw):
    """E = E1: no loss, no dispersion."""

    law: Literal["constant"] = "constant"
    young_modulus: Pressure

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus + 0j * np.asarray(frequency))


class Complex(ModulusLaw):
    """E = E1 + i E2, both constant."""

    law: Literal["complex"] = "complex"
    storage_modulus: Pressure
    loss_modulus: LossModulus

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.storage_modulus + 1j * self.loss_modulus + 0j * np.asarray(frequency))


class LossFactor(ModulusLaw):
    """E = E1 (1 + i eta): structural damping."""

    law: Literal["loss_factor"] = "loss_factor"
    young_modulus: Pressure
    loss_factor: Ratio

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus * (1 + 1j * self.loss_factor) + 0j * np.asarray(frequency))


class KelvinVoigt(ModulusLaw):
    """E = E1 + i w eta: a spring beside a dashpot of `viscosity` eta."""

    law: Literal["kelvin_voigt"] = "kelvin_voigt"
    young_modulus: Pressure
    viscosity: Viscosity

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        return np.asarray(self.young_modulus + 2j * np.pi * np.asarray(frequency) * self.viscosity)


class FractionalZener(ModulusLaw):
    """E = (E0 + Einf s)/(1 + s), s = (i w tau)^alpha.

    Four-parameter fractional standard solid: T. Pritz, J. Sound Vib. 195 (1996) 103-115. Causal and passive for
    0 < alpha <= 1 and Einf >= E0.
    """

    law: Literal["fractional_zener"] = "fractional_zener"
    relaxed_modulus: Pressure
    unrelaxed_modulus: Pressure
    relaxation_time: Duration
    order: Annotated[float, Field(gt=0, le=1), Unit(DIMENSIONLESS)]

    @model_validator(mode="after")
    def _passive(self) -> Self:
        if self.unrelaxed_modulus < self.relaxed_modulus:
            raise ValueError("unrelaxed_modulus must be at least relaxed_modulus, or the law creates energy")
        return self

    def __call__(self, frequency: ArrayLike) -> ComplexArray:
        inverse = (2j * np.pi * np.asarray(frequency) * self.relaxation_time) ** -self.order
        rise = self.unrelaxed_modulus - self.relaxed_modulus
        return np.asarray(self.relaxed_modulus + rise / (1 + inverse))  # rounding cannot make Im(E) negative


class Table(ModulusLaw):
    """E1 and E2 from a table, linear in the logarithm of frequency; no extrapolation.

    In an input, `file` may name a CSV file (beside the YAML file) with the columns frequency (Hz), E1, E2 (Pa);
    its values then stand in the fields.
    """

    law: Literal["table"] = "table"
    frequency: Annotated[tuple[Frequency, ...], Field(min_length=2)]
    storage_modulus: Annotated[tuple[Pressure, ...], Field(min_length=2)]
    loss_modulus: Annotated[tuple[LossModulus, ...], Field(min_length=2)]

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
        f = np.asarray(frequency, dtype=float)
        low, high = self.frequency[0], self.frequency[-1]
        if f.size and (f.min() < low * (1 - 1e-12) or f.max() > high * (1 + 1e-12)):
            raise InputError(
                f"the modulus table holds {low:g} to {high:g} Hz and {f.min():g} to {f.max():g} Hz are asked for; "
                "extend the table or narrow the frequencies"
            )
        x, grid = np.log(f), np.log(self.frequency)
        return np.asarray(np.interp(x, grid, self.storage_modulus) + 1j * np.interp(x, grid, self.loss_modulus))


def read_modulus_table(path: Path) -> tuple[RealArray, RealArray, RealArray]:
    """Return frequency (Hz), E1 and E2 (Pa) from a CSV file with one header line and three columns.

    Raises
    ------
    ValueError
        When the file is missing or is not such a table.
    """
    wanted = "a modulus table has one header line and the columns frequency (Hz), E1 and E2 (Pa)"
    try:
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


Modulus = Annotated[
    float | complex | ModulusLaw,
    PlainValidator(_parse_modulus),
    PlainSerializer(_serialise_modulus, when_used="json"),
    UnitLabel("Pa"),
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


__all__ = [
    "LAWS",
    "Complex",
    "Constant",
    "FractionalZener",
    "KelvinVoigt",
    "LossFactor",
    "Modulus",
    "ModulusLaw",
    "Table",
    "complex_modulus",
    "read_modulus_table",
]
