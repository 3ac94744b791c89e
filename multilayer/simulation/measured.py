"""Measured spectra from tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError, PlausibilityWarning, suggest
from multilayer.measurements.columns import (
    FREQUENCY,
    Column,
    Places,
    column_values,
    complex_columns,
    complex_values,
    find_columns,
)
from multilayer.measurements.readers import read_spectra
from multilayer.response.bands import nearest_centres
from multilayer.simulation.bands import Grid, band_grid
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import Bands, FrequencyRange
from multilayer.tables import Table

_HELP = (
    "name the columns 'frequency_hz' (or 'frequency [Hz]', 'f [kHz]') and one or more of 'absorption', "
    "'transmission_loss_db', 'insertion_loss_db', 'normalised_impedance_re' and '..._im', 'reflection_re' and '..._im'"
)
_OTHER_NAMES = {
    "alpha": "absorption",
    "tl": "transmission_loss",
    "stl": "transmission_loss",
    "il": "insertion_loss",
    "ln": "impact_level",
}
IN_RANGE = "in_range"  # a column of our tables of impedance tubes
OUTSIDE = "outside of the working range of the tube"
_MOST_ABSORBED = 2.0  # a reverberation room measures a little more than 1
_OFF_CENTRE = 0.03  # nominal centres differ from the exact ones by less


@dataclass(frozen=True)
class Measured:
    """Measured spectra.

    Attributes
    ----------
    name : str
        Of the file.
    frequency : array
        Hz, rising.
    quantities : mapping
        By name, as in `QUANTITIES`; NaN where the table has nothing of one in a row that holds others.
    """

    name: str
    frequency: RealArray
    quantities: Mapping[str, NDArray[Any]]

    def grid(self, wanted: FrequencyRange | Bands | tuple[float, ...]) -> Grid:
        """Return the measured frequencies as a grid, of bands where the simulation's `frequency` asks for bands.

        Raises
        ------
        InputError
            When bands are wanted and the frequencies are no centres of bands.
        """
        if not isinstance(wanted, Bands):
            return Grid(self.frequency, self.frequency)
        centres = nearest_centres(self.frequency, wanted.width)
        off = np.abs(centres / self.frequency - 1) > _OFF_CENTRE
        off[1:] |= np.diff(centres) == 0
        if np.any(off):
            raise InputError(
                f"{self.name}: {self.frequency[off][0]:g} Hz is no centre among those of {wanted.width}, or stands "
                f"twice; the simulation asks for {wanted.width}: give other frequencies there to compare spectra"
            )
        return band_grid(centres, wanted.width)


def read_measured(path: Path | str, quantity: str | None = None) -> Measured:
    """Read a table of measured spectra.

    Columns of a text table are separated by commas, semicolons or tabs and named, with their units, in the first line;
    what follows a ``#`` is no data. Other columns than those below are left alone, and so are empty cells. Other
    formats are read through the reader of their suffix.

    Parameters
    ----------
    path : Path or str
    quantity : str, optional
        Read this one of `QUANTITIES` only; columns called ``re`` and ``im`` are then its parts.

    Raises
    ------
    InputError
        With file and line, when the file is not text, a unit is missing, no known quantity is there, a cell is no
        number, or a frequency is not above 0.

    Warns
    -----
    PlausibilityWarning
        Of rows outside of the working range of an impedance tube, which are left out, and of absorption in per cent.
    """
    table = read_spectra(path)
    _refuse_unclear_impedance(table)
    wanted = {name: _columns(name, table, whole=name == quantity) for name in QUANTITIES if quantity in (None, name)}
    places = find_columns(
        table, [FREQUENCY, *(part for parts in wanted.values() for part in parts)], _HELP, single=True
    )
    names = _complete(table, places, wanted, quantity)
    if "case" in table.names and len(set(table.text(table.names.index("case")))) > 1:
        raise table.error("holds several cases of a simulation; keep the rows of one", table.line)
    table = table.without({OUTSIDE: table.rejected(IN_RANGE)}, "compare")
    values = _with_empty_cells(table, places)
    whole = {name: complex_values(values, name) if QUANTITIES[name].is_complex else values[name] for name in names}
    there = {name: np.isfinite(column) for name, column in whole.items()}
    rows = np.any([*there.values()], axis=0)
    if not np.any(rows):
        raise table.error(f"holds no values of {', '.join(names)}: all cells are empty", table.line)
    whole = {name: column[rows] for name, column in whole.items() if np.any(there[name])}
    if "absorption" in whole:
        ask_back_absorption(table.file, whole["absorption"])
    return Measured(table.file.stem, values["frequency"][rows], whole)


def ask_back_absorption(file: Path, absorption: NDArray[Any]) -> None:
    """Ask back absorption coefficients that are per cent.

    Parameters
    ----------
    file : Path
        Where they stand.
    absorption : array
        NaN where there is none.

    Warns
    -----
    PlausibilityWarning
    """
    largest = np.nanmax(absorption)
    if largest > _MOST_ABSORBED:
        text = f"{file}: an absorption of {largest:g}; it is a share of 1: are these per cent?"
        warn(text, PlausibilityWarning, stacklevel=3)


def _with_empty_cells(table: Table, places: Places) -> dict[str, RealArray]:
    """Return values as `column_values`, NaN for the empty cells of quantities."""
    ours = {index for role, (index, _) in places.items() if role != FREQUENCY.role}
    filled = [
        (line, tuple(0.0 if i in ours and not table.cell(cell) else cell for i, cell in enumerate(cells)))
        for line, cells in table.rows
    ]
    values = column_values(replace(table, rows=tuple(filled)), places)
    at, factor = places[FREQUENCY.role]
    order = np.argsort(table.numbers({at})[at] * factor, kind="stable")
    empty = {role: np.array([not text for text in table.text(index)])[order] for role, (index, _) in places.items()}
    return {role: np.where(empty[role], np.nan, column) for role, column in values.items()}


def _columns(name: str, table: Table, *, whole: bool) -> tuple[Column, ...]:
    """Return the columns of a quantity; ``re`` and ``im`` are among them where the whole table is about it.

    A column called as our own tables call it, which have units in names of levels and losses alone, is in SI units.
    """
    quantity = QUANTITIES[name]
    names = [name, *(other for other, meant in _OTHER_NAMES.items() if meant == name)]
    ours = any(header.text in quantity.columns and header.unit is None for header in table.headers)
    unit = None if ours else quantity.unit
    if not quantity.is_complex:
        return (Column(name, tuple(names), unit),)
    parts = complex_columns(name, names, unit)
    if not whole:
        return parts
    return tuple(replace(part, names=(*part.names, part.role.rpartition("_")[2])) for part in parts)


def _refuse_unclear_impedance(table: Table) -> None:
    for header in table.headers:
        if header.name.removesuffix("_re").removesuffix("_im") in ("impedance", "surface_impedance", "z"):
            remedy = "divide it by rho c and write 'normalised_impedance_re' and '..._im'"
            text = f"column '{header.text}' does not say whether it is divided by rho c of the air; {remedy}"
            raise table.error(text, table.line)


def _complete(table: Table, places: Places, wanted: Mapping[str, Sequence[Column]], quantity: str | None) -> list[str]:
    """Return the quantities that a table holds, in the order of its columns, with all of their parts."""
    if FREQUENCY.role not in places:
        raise table.error(f"no column holds the frequency; {_HELP}", table.line)
    quantities = {part.role: name for name, parts in wanted.items() for part in parts}
    in_order = sorted(places.items(), key=lambda place: place[1])
    names = list(dict.fromkeys(quantities[role] for role, _ in in_order if role != FREQUENCY.role))
    if quantity is not None and quantity not in names:
        raise table.error(f"no column holds the {quantity}; {_HELP}", table.line)
    if not names:
        near = f" ('re' and 'im' need --quantity {'|'.join(n for n, q in QUANTITIES.items() if q.is_complex)})"
        hint = near if "re" in table.names else ""
        raise table.error(f"no column holds a quantity to compare{hint}; {_HELP}", table.line)
    for name in names:
        if any(part.role not in places for part in wanted[name]):
            raise table.error(f"{name} needs two columns, {name}_re and {name}_im", table.line)
    return names


def known_quantity(name: str | None) -> str | None:
    """Return the name in `QUANTITIES` of what the option ``--quantity`` gives, which may be an abbreviation.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name is None:
        return None
    known = _OTHER_NAMES.get(name.lower(), name.lower())
    if known not in QUANTITIES:
        raise InputError(f"--quantity: there is no '{name}'; {suggest(name, QUANTITIES)}")
    return known
