"""The values of one measurement of a stack fit, from a table or from the fit file itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import suggest
from multilayer.experiments.stacks.measurements import COMPLEX, POLAR, REAL, SPREADS, Measurement, Stiffness
from multilayer.inference.whitening import ValueNoise
from multilayer.measurements.tables import TextTable, read_table, split_header, unit_factor

_FREQUENCY = ("frequency", "f", "freq")
_NEEDED = "its first line must name the columns"
Columns = dict[str, tuple[int, float]]  # by role: which one, and what 1 in its unit is in ours


@dataclass(frozen=True)
class MeasuredValues:
    """Values over rising frequency, Hz, and their noise."""

    frequency: RealArray
    values: NDArray[Any]
    noise: ValueNoise


def read_values(measurement: Measurement, folder: Path) -> MeasuredValues:
    """Return what was measured.

    Parameters
    ----------
    measurement : Measurement
    folder : Path
        Where its file lies.

    Raises
    ------
    InputError
        With file and line, when a column is missing or has no unit, a row is short, a cell is no number, or nothing
        lies between the frequencies wanted.
    """
    if isinstance(measurement, Stiffness) and measurement.frequency is not None:
        return _with_noise(measurement, np.array([measurement.frequency]), np.array([measurement.stiffness]), {})
    assert measurement.file is not None
    table = read_table(folder / measurement.file, _NEEDED)
    columns = _columns(table, measurement)
    table = _wanted_rows(table, measurement)
    factors = dict(columns.values())
    by_index = dict(zip(factors, table.numbers(factors), strict=True))
    found = {role: by_index[index] for role, (index, _) in columns.items()}
    table.refuse_not_positive(found["frequency"])
    return _chosen(table, measurement, found)


def _columns(table: TextTable, measurement: Measurement) -> Columns:
    columns = {role: found for role in _roles(measurement) if (found := _column(table, measurement, role)) is not None}
    if "frequency" not in columns:
        raise table.error("no column holds the frequency; say under 'columns' what it is called", table.line)
    kinds = (COMPLEX, POLAR) if measurement.is_complex else (REAL,)
    if isinstance(measurement, Stiffness):
        kinds = (*kinds, COMPLEX[:1])
    if not any(set(kind) <= set(columns) for kind in kinds):
        wanted = " or ".join(" and ".join(kind) for kind in kinds)
        called = ", ".join(table.names)
        text = f"say under 'columns' which of these hold {wanted}: {called}"
        raise table.error(f"no columns are known to hold the {measurement.kind}; {text}", table.line)
    return columns


def _roles(measurement: Measurement) -> list[str]:
    parts = (*COMPLEX, *POLAR) if measurement.is_complex else REAL
    return ["frequency", *parts, *SPREADS]


def _column(table: TextTable, measurement: Measurement, role: str) -> tuple[int, float] | None:
    if role in measurement.columns:
        index, unit = _called(table, measurement.columns[role])
    else:
        called = _FREQUENCY if role == "frequency" else measurement.roles.get(role, ())
        splits = [split_header(name) or ("", None) for name in table.names]
        there = [i for i, (name, _) in enumerate(splits) if name in called]
        if not there or (role in COMPLEX and set(POLAR) & set(measurement.columns)):
            return None
        index, unit = there[0], splits[there[0]][1]
    wanted = {"frequency": "Hz", "phase": "radian"}.get(role, measurement.unit)
    try:
        return index, unit_factor(table.names[index], unit, wanted)
    except ValueError as error:
        hint = f", or add it under 'columns', as {{{role}: '{table.names[index]} [...]'}}" if unit is None else ""
        raise table.error(f"{error}{hint}", table.line) from None


def _called(table: TextTable, wanted: str) -> tuple[int, str | None]:
    """Return the column of a name that `columns` gives, and its unit."""
    text = wanted.strip()
    if text in table.names:
        return table.names.index(text), (split_header(text) or ("", None))[1]
    bare, _, unit = text.partition("[")
    if unit and bare.strip() in table.names:
        return table.names.index(bare.strip()), unit.rstrip("] ")
    raise table.error(f"no column is called '{text}'; {suggest(text, table.names)}", table.line)


def _wanted_rows(table: TextTable, measurement: Measurement) -> TextTable:
    rows = table.rows
    for name, text in measurement.rows.items():
        index, _ = _called(table, name)
        cells = dict(zip((line for line, _ in table.rows), table.text(index), strict=True))
        kept = tuple(row for row in rows if cells[row[0]] == text.strip())
        if not kept:
            raise table.error(f"no row has '{text}' as {name}; {suggest(text, set(cells.values()))}", table.line)
        rows = kept
    if not rows:
        raise table.error("holds no values below its header")
    return replace(table, rows=rows)


def _chosen(table: TextTable, measurement: Measurement, found: dict[str, RealArray]) -> MeasuredValues:
    f = found["frequency"]
    low, high = measurement.start or 0.0, measurement.to or np.inf
    order = np.argsort(f, kind="stable")
    order = order[(f[order] >= low) & (f[order] <= high)]
    if not order.size:
        raise table.error(f"holds no frequency from {low:g} to {high:g} Hz, only from {f.min():g} to {f.max():g} Hz")
    kept = {role: values[order] for role, values in found.items()}
    _refuse_twice(table, kept["frequency"])
    return _with_noise(measurement, kept["frequency"], _values(kept), kept)


def _refuse_twice(table: TextTable, frequency: RealArray) -> None:
    same = frequency[1:][np.diff(frequency) == 0]
    if same.size:
        raise table.error(f"holds {same[0]:g} Hz more than once; choose the rows of one series under 'rows'")


def _values(kept: dict[str, RealArray]) -> NDArray[Any]:
    if "value" in kept:
        return kept["value"]
    if "real" in kept:
        return kept["real"] + 1j * kept["imag"] if "imag" in kept else kept["real"]
    return np.asarray(kept["amplitude"] * np.exp(1j * kept["phase"]))


def _with_noise(
    measurement: Measurement, frequency: RealArray, values: NDArray[Any], given: dict[str, RealArray]
) -> MeasuredValues:
    share, amount = measurement.spread
    variance = (share * np.abs(values)) ** 2 + amount**2
    parts = []
    for names in (("std", "std_real"), ("std", "std_imag")):
        own = sum((given[name] ** 2 for name in names if name in given), np.zeros(len(frequency)))
        parts.append(np.sqrt(variance + own))
    return MeasuredValues(frequency, values, ValueNoise(*parts))


def zero_noise(measured: MeasuredValues) -> Iterator[float]:
    """Yield the frequencies, Hz, at which a value would have no noise at all."""
    parts = [measured.noise.real, *([measured.noise.imaginary] if np.iscomplexobj(measured.values) else [])]
    for f, *spreads in zip(measured.frequency, *parts, strict=True):
        if not min(spreads) > 0:
            yield float(f)
