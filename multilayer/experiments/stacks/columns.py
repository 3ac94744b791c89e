"""The values of a measurement of a stack fit, from a table or from the fit file itself."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import suggest
from multilayer.experiments.stacks.measurements import (
    COMPLEX,
    POLAR,
    REAL,
    SPREADS,
    Absorption,
    DynamicModulus,
    Measurement,
    Stiffness,
)
from multilayer.inference.whitening import ValueNoise
from multilayer.measurements.columns import FREQUENCY, Column, Places, called_column, column_values, find_columns
from multilayer.measurements.readers import read_spectra
from multilayer.simulation.measured import IN_RANGE, OUTSIDE, ask_back_absorption
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

    Warns
    -----
    PlausibilityWarning
        Of rows that are left out: outside of the working range of an impedance tube, or of moduli not found or not
        accepted; and of absorption in per cent.
    """
    if isinstance(measurement, Stiffness) and measurement.frequency is not None:
        return _with_noise(measurement, np.array([measurement.frequency]), np.array([measurement.stiffness]), {})
    assert measurement.file is not None
    table = read_spectra(folder / measurement.file)
    places = find_columns(table, _wanted(measurement), _NEEDED, measurement.columns)
    _refuse_missing(table, places, measurement)
    table = _found_rows(_wanted_rows(table, measurement), places, measurement)
    measured = _chosen(table, measurement, column_values(table, places))
    if isinstance(measurement, Absorption):
        ask_back_absorption(table.file, measured.values)
    return measured


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


def _found_rows(table: Table, places: Places, measurement: Measurement) -> Table:
    """Return the rows with values that hold: a fit writes moduli not found or not accepted, a tube what is outside.

    Rows that are chosen by their verdict are kept.
    """
    left_out = {}
    if IN_RANGE not in measurement.rows:
        left_out[OUTSIDE] = table.rejected(IN_RANGE)
    if isinstance(measurement, DynamicModulus):
        cells = zip(*(table.text(index) for index, _ in places.values()), strict=True)
        empty = np.array([not all(row) for row in cells], dtype=bool)
        if _VERDICT not in measurement.rows:
            left_out["not accepted"] = table.rejected(_VERDICT)
            empty &= ~left_out["not accepted"]
        left_out["with an empty cell"] = empty
    return table.without(left_out, "fit")


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
