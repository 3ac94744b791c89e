"""The values of a measurement of a stack fit, from a table or from the fit file itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import PlausibilityWarning, suggest
from multilayer.experiments.stacks.measurements import (
    COMPLEX,
    POLAR,
    REAL,
    SPREADS,
    DynamicModulus,
    Measurement,
    Stiffness,
)
from multilayer.inference.whitening import ValueNoise
from multilayer.measurements.columns import FREQUENCY, Column, Places, called_column, column_values, find_columns
from multilayer.measurements.readers import read_spectra
from multilayer.tables import Table

_VERDICT = "accepted"  # a column of our tables of moduli
_NEEDED = "its first line must name the columns"


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
        Folder of its file.

    Raises
    ------
    InputError
        With file and line, when a column is missing or has no unit, a row is short, a cell is no number, or nothing
        lies between the frequencies wanted.
    """
    if isinstance(measurement, Stiffness) and measurement.frequency is not None:
        return _with_noise(measurement, np.array([measurement.frequency]), np.array([measurement.stiffness]), {})
    assert measurement.file is not None
    table = read_spectra(folder / measurement.file)
    places = find_columns(table, _wanted(measurement), _NEEDED, measurement.columns)
    _refuse_missing(table, places, measurement)
    table = _wanted_rows(table, measurement)
    if isinstance(measurement, DynamicModulus):
        table = _found_rows(table, places, judged=_VERDICT not in measurement.rows)
    return _chosen(table, measurement, column_values(table, places))


def _wanted(measurement: Measurement) -> list[Column]:
    unit = measurement.unit
    if not measurement.is_complex:
        parts = [Column(role, measurement.roles[role], unit) for role in REAL]
    else:  # real and imaginary part are not sought by name where the file names amplitude or phase
        names = {} if set(POLAR) & set(measurement.columns) else measurement.roles
        parts = [Column(role, names.get(role, ()), unit) for role in COMPLEX]
        parts += [Column("amplitude", (), unit), Column("phase", (), "radian")]
    return [FREQUENCY, *parts, *(Column(role, measurement.roles.get(role, ()), unit) for role in SPREADS)]


def _refuse_missing(table: Table, places: Places, measurement: Measurement) -> None:
    if "frequency" not in places:
        raise table.error("no column holds the frequency; say under 'columns' what it is called", table.line)
    kinds = (COMPLEX, POLAR) if measurement.is_complex else (REAL,)
    if isinstance(measurement, Stiffness):
        kinds = (*kinds, COMPLEX[:1])
    if not any(set(kind) <= set(places) for kind in kinds):
        wanted = " or ".join(" and ".join(kind) for kind in kinds)
        called = ", ".join(table.names)
        text = f"say under 'columns' which of these hold {wanted}: {called}"
        raise table.error(f"no columns are known to hold the {measurement.kind}; {text}", table.line)


def _wanted_rows(table: Table, measurement: Measurement) -> Table:
    for name, text in measurement.rows.items():
        index, _ = called_column(table, name)
        cells = table.text(index)
        kept = tuple(row for row, cell in zip(table.rows, cells, strict=True) if cell == text.strip())
        if not kept:
            raise table.error(f"no row has '{text}' as {name}; {suggest(text, set(cells))}", table.line)
        table = replace(table, rows=kept)
    return table


def _found_rows(table: Table, places: Places, *, judged: bool) -> Table:
    """Return the rows with moduli that were found and, if `judged`, accepted: a fit writes the others too."""
    verdicts = table.text(table.names.index(_VERDICT)) if judged and _VERDICT in table.names else [""] * len(table.rows)
    cells = zip(*(table.text(index) for index, _ in places.values()), strict=True)
    rejected = np.array([verdict.lower() == "false" for verdict in verdicts], dtype=bool)
    empty = np.array([not all(row) for row in cells], dtype=bool) & ~rejected
    counts = {"not accepted": int(rejected.sum()), "with an empty cell": int(empty.sum())}
    told = ", ".join(f"{count} {what}" for what, count in counts.items() if count)
    if not told:
        return table
    kept = tuple(row for row, out in zip(table.rows, rejected | empty, strict=True) if not out)
    if not kept:
        raise table.error(f"holds no row to fit; left out: {told}", table.line)
    text = f"{table.file}: rows left out of {len(table.rows)}: {told}"
    warn(text, PlausibilityWarning, stacklevel=3)
    return replace(table, rows=kept)


def _chosen(table: Table, measurement: Measurement, values: dict[str, RealArray]) -> MeasuredValues:
    f = values["frequency"]
    low, high = measurement.start or 0.0, measurement.to or np.inf
    inside = (f >= low) & (f <= high)
    if not inside.any():
        raise table.error(f"holds no frequency from {low:g} to {high:g} Hz, only from {f[0]:g} to {f[-1]:g} Hz")
    kept = {role: column[inside] for role, column in values.items()}
    _refuse_twice(table, kept["frequency"])
    return _with_noise(measurement, kept["frequency"], _values(kept), kept)


def _refuse_twice(table: Table, frequency: RealArray) -> None:
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
    relative, absolute = measurement.spread
    variance = (relative * np.abs(values)) ** 2 + absolute**2
    parts = []
    for names in (("std", "std_real"), ("std", "std_imag")):
        of_columns = sum((given[name] ** 2 for name in names if name in given), np.zeros(len(frequency)))
        parts.append(np.sqrt(variance + of_columns))
    return MeasuredValues(frequency, values, ValueNoise(*parts))


def zero_noise(measured: MeasuredValues) -> Iterator[float]:
    """Yield the frequencies, Hz, at which the stated noise of a value is 0."""
    parts = [measured.noise.real, *([measured.noise.imaginary] if np.iscomplexobj(measured.values) else [])]
    for f, *spreads in zip(measured.frequency, *parts, strict=True):
        if not min(spreads) > 0:
            yield float(f)
