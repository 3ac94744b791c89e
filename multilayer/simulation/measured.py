"""Measured spectra from text tables."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError, suggest
from multilayer.measurements.tables import TextTable, read_table, split_header, unit_factor
from multilayer.response.bands import nearest_centres
from multilayer.simulation.bands import Grid, band_grid
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import Bands, FrequencyRange

_HELP = (
    "name the columns 'frequency_hz' (or 'frequency [Hz]', 'f [kHz]') and one or more of 'absorption', "
    "'transmission_loss_db', 'insertion_loss_db', 'normalised_impedance_re' and '..._im', 'reflection_re' and '..._im'"
)
_OTHER_NAMES = {
    "f": "frequency",
    "freq": "frequency",
    "alpha": "absorption",
    "tl": "transmission_loss",
    "stl": "transmission_loss",
    "il": "insertion_loss",
}
_FREQUENCY = "frequency"
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
        By name, as in `QUANTITIES`.
    """

    name: str
    frequency: RealArray
    quantities: Mapping[str, NDArray[Any]]

    def grid(self, wanted: FrequencyRange | Bands | tuple[float, ...]) -> Grid:
        """Return the measured frequencies as a grid: as bands where a simulation wants such.

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


@dataclass(frozen=True)
class _Column:
    """What a header says: a quantity, which part of it, and what one of its unit is in ours."""

    quantity: str
    part: str
    factor: float


def read_measured(path: Path | str, quantity: str | None = None) -> Measured:
    """Read a table of measured spectra.

    Columns are separated by commas, semicolons or tabs and named, with their units, in the first line; what follows a
    ``#`` is no data. Other columns than those below are left alone.

    Parameters
    ----------
    path : Path or str
    quantity : str, optional
        The one wanted, of `QUANTITIES`; columns called ``re`` and ``im`` are then its parts.

    Raises
    ------
    InputError
        With file and line, when the file is not text, a unit is missing, no known quantity is there, a cell is no
        number, or a frequency is not above 0.
    """
    table = read_table(path, _HELP)
    columns = _columns(table, quantity)
    if "case" in table.names and len(set(table.text(table.names.index("case")))) > 1:
        raise table.error("holds several cases of a simulation; keep the rows of one", table.line)
    if not table.rows:
        raise table.error("holds no values below its header")
    values = table.numbers({i: column.factor for i, column in columns.items()})
    return _collect(table, values, list(columns.values()))


def _columns(table: TextTable, wanted: str | None) -> dict[int, _Column]:
    found = {i: column for i, name in enumerate(table.names) if (column := _column(name, wanted, table)) is not None}
    kinds = [(column.quantity, column.part) for column in found.values()]
    for kind in kinds:
        if kinds.count(kind) > 1:
            raise table.error(f"two columns hold {' '.join(kind).strip()}; keep one of them", table.line)
    quantities = {name for name, _ in kinds}
    if _FREQUENCY not in quantities:
        raise table.error(f"no column holds the frequency; {_HELP}", table.line)
    if wanted is not None and wanted not in quantities:
        raise table.error(f"no column holds the {wanted}; {_HELP}", table.line)
    if quantities == {_FREQUENCY}:
        near = f" ('re' and 'im' need --quantity {'|'.join(n for n, q in QUANTITIES.items() if q.is_complex)})"
        said = near if "re" in table.names else ""
        raise table.error(f"no column holds a quantity to compare{said}; {_HELP}", table.line)
    for name in quantities - {_FREQUENCY}:
        if QUANTITIES[name].is_complex and not {(name, "re"), (name, "im")} <= set(kinds):
            raise table.error(f"{name} needs two columns, {name}_re and {name}_im", table.line)
    return found


def _column(header: str, wanted: str | None, table: TextTable) -> _Column | None:
    split = split_header(header)
    if split is None:
        return None
    name, unit = split
    stem, _, suffix = name.rpartition("_")
    part = suffix if suffix in ("re", "im") else ""
    if part:
        name = stem or (wanted or "")
    name = _OTHER_NAMES.get(name, name)
    if name in ("impedance", "surface_impedance", "z"):
        remedy = "divide it by rho c and write 'normalised_impedance_re' and '..._im'"
        text = f"column '{header}' does not say whether it is divided by rho c of the air; {remedy}"
        raise table.error(text, table.line)
    if name == _FREQUENCY:
        return _Column(name, "", _factor(header, unit, "Hz", table))
    if name not in QUANTITIES or (wanted is not None and name != wanted) or bool(part) != QUANTITIES[name].is_complex:
        return None
    return _Column(name, part, _factor(header, unit, QUANTITIES[name].unit, table))


def _factor(header: str, written: str | None, unit: str, table: TextTable) -> float:
    try:
        return unit_factor(header, written, unit)
    except ValueError as error:
        raise table.error(str(error), table.line) from None


def _collect(table: TextTable, numbers: RealArray, columns: Sequence[_Column]) -> Measured:
    values = {(column.quantity, column.part): row for column, row in zip(columns, numbers, strict=True)}
    frequency = values[_FREQUENCY, ""]
    table.refuse_not_positive(frequency)
    order = np.argsort(frequency, kind="stable")
    names = dict.fromkeys(column.quantity for column in columns if column.quantity != _FREQUENCY)
    quantities: dict[str, NDArray[Any]] = {}
    for name in names:
        whole = values[name, "re"] + 1j * values[name, "im"] if QUANTITIES[name].is_complex else values[name, ""]
        quantities[name] = whole[order]
    return Measured(table.file.stem, frequency[order], quantities)


def known_quantity(name: str | None) -> str | None:
    """Return the name of a quantity that ``--quantity`` gives.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    if name is None:
        return None
    found = _OTHER_NAMES.get(name.lower(), name.lower())
    if found not in QUANTITIES:
        raise InputError(f"--quantity: there is no '{name}'; {suggest(name, QUANTITIES)}")
    return found
