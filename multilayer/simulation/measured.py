"""Measured spectra from text tables."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem, suggest
from multilayer.simulation.bands import Grid, band_grid, band_number
from multilayer.simulation.quantities import QUANTITIES
from multilayer.simulation.settings import FrequencyRange, ThirdOctaves
from multilayer.units import parse_quantity

_HELP = (
    "name the columns 'frequency_hz' (or 'frequency [Hz]', 'f [kHz]') and one or more of 'absorption', "
    "'transmission_loss_db', 'insertion_loss_db', 'normalised_impedance_re' and '..._im', 'reflection_re' and '..._im'"
)
_HEADER = re.compile(r"\s*(?P<name>[^\[\]()]+?)\s*(?:[\[(](?P<unit>[^\[\]()]*)[\])])?\s*")
_SUFFIX_UNITS = {"hz": "Hz", "khz": "kHz", "db": "dB"}
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

    def grid(self, wanted: FrequencyRange | ThirdOctaves | tuple[float, ...]) -> Grid:
        """Return the measured frequencies as a grid: as third-octave bands where a simulation wants such.

        Raises
        ------
        InputError
            When bands are wanted and the frequencies are no centres of bands.
        """
        if not isinstance(wanted, ThirdOctaves):
            return Grid(self.frequency, self.frequency)
        grid = band_grid(np.array([band_number(f) for f in self.frequency]))
        off = np.abs(grid.frequency / self.frequency - 1) > _OFF_CENTRE
        if np.any(off) or len(np.unique(grid.frequency)) < len(grid.frequency):
            f = self.frequency[off][0] if np.any(off) else self.frequency[0]
            raise InputError(
                f"{self.name}: {f:g} Hz is no centre of a third-octave band, or stands twice; the simulation asks for "
                "third octaves: give other frequencies there to compare spectra"
            )
        return grid


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
    file = Path(path)
    lines = _lines(file)
    number, header = lines[0]
    separator = next((mark for mark in (";", "\t", ",") if mark in header), ",")
    names = [name.strip().strip('"') for name in header.split(separator)]
    columns = _columns(names, quantity, file, number)
    if "case" in names and len({line.split(separator)[names.index("case")] for _, line in lines[1:]}) > 1:
        raise _error(file, "holds several cases of a simulation; keep the rows of one", number)
    rows = [_row(line, separator, columns, file, at) for at, line in lines[1:]]
    if not rows:
        raise _error(file, "holds no values below its header")
    table = np.array(rows, dtype=float).T
    return _collect(file, table, list(columns.values()), [at for at, _ in lines[1:]])


def _error(file: Path, message: str, line: int | None = None) -> InputError:
    return InputError(Problem(message, file=file, line=line))


def _lines(file: Path) -> list[tuple[int, str]]:
    try:
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise _error(file, "there is no such file") from None
    except (OSError, UnicodeDecodeError) as error:
        raise _error(file, f"is no text that can be read ({error}); export it again as UTF-8") from None
    numbered = enumerate((line.partition("#")[0].strip(" ") for line in text.splitlines()), start=1)
    lines = [(number, line) for number, line in numbered if line]
    if not lines:
        raise _error(file, f"is empty; {_HELP}")
    return lines


def _columns(names: Sequence[str], wanted: str | None, file: Path, line: int) -> dict[int, _Column]:
    found = {i: column for i, name in enumerate(names) if (column := _column(name, wanted, file, line)) is not None}
    kinds = [(column.quantity, column.part) for column in found.values()]
    for kind in kinds:
        if kinds.count(kind) > 1:
            raise _error(file, f"two columns hold {' '.join(kind).strip()}; keep one of them", line)
    quantities = {name for name, _ in kinds}
    if _FREQUENCY not in quantities:
        raise _error(file, f"no column holds the frequency; {_HELP}", line)
    if wanted is not None and wanted not in quantities:
        raise _error(file, f"no column holds the {wanted}; {_HELP}", line)
    if quantities == {_FREQUENCY}:
        near = f" ('re' and 'im' need --quantity {'|'.join(n for n, q in QUANTITIES.items() if q.is_complex)})"
        raise _error(file, f"no column holds a quantity to compare{near if 're' in names else ''}; {_HELP}", line)
    for name in quantities - {_FREQUENCY}:
        if QUANTITIES[name].is_complex and not {(name, "re"), (name, "im")} <= set(kinds):
            raise _error(file, f"{name} needs two columns, {name}_re and {name}_im", line)
    return found


def _column(header: str, wanted: str | None, file: Path, line: int) -> _Column | None:
    match = _HEADER.fullmatch(header)
    if match is None:
        return None
    name, unit = "_".join(match["name"].lower().split()), match["unit"]
    stem, _, suffix = name.rpartition("_")
    if unit is None and suffix in _SUFFIX_UNITS:
        name, unit = stem, _SUFFIX_UNITS[suffix]
        stem, _, suffix = name.rpartition("_")
    part = suffix if suffix in ("re", "im") else ""
    if part:
        name = stem or (wanted or "")
    name = _OTHER_NAMES.get(name, name)
    if name in ("impedance", "surface_impedance", "z"):
        remedy = "divide it by rho c and write 'normalised_impedance_re' and '..._im'"
        raise _error(file, f"column '{header}' does not say whether it is divided by rho c of the air; {remedy}", line)
    if name == _FREQUENCY:
        return _Column(name, "", _factor(header, unit, "Hz", file, line))
    if name not in QUANTITIES or (wanted is not None and name != wanted) or bool(part) != QUANTITIES[name].is_complex:
        return None
    return _Column(name, part, _factor(header, unit, QUANTITIES[name].unit, file, line))


def _factor(header: str, written: str | None, unit: str, file: Path, line: int) -> float:
    """Return what 1 in the unit of a header is in ours."""
    if written is None and unit:
        name = header.strip().lower().replace(" ", "_")
        raise _error(file, f"column '{header}' has no unit; write '{name}_{unit.lower()}' or '{name} [{unit}]'", line)
    if unit == "dB" or written in (None, "", "-", "1"):
        if unit == "dB" and written != "dB":
            raise _error(file, f"column '{header}' must be in dB; write '[dB]'", line)
        return 1.0
    try:
        return parse_quantity(f"1 {written}", unit)
    except ValueError as error:
        raise _error(file, f"column '{header}': {error}", line) from None


def _row(line: str, separator: str, columns: Mapping[int, _Column], file: Path, number: int) -> list[float]:
    cells = line.split(separator)
    if len(cells) <= max(columns):
        raise _error(file, f"has {len(cells)} cells and lacks some of the columns that the header names", number)
    return [_number(cells[i], file, number) * column.factor for i, column in columns.items()]


def _number(cell: str, file: Path, line: int) -> float:
    try:
        value = float(cell.strip().strip('"'))
    except ValueError:
        comma = "; write decimals with a point" if "," in cell else ""
        raise _error(file, f"'{cell.strip()}' is no number{comma}", line) from None
    if not np.isfinite(value):
        raise _error(file, f"'{cell.strip()}' is not finite; leave such rows out", line)
    return value


def _collect(file: Path, table: RealArray, columns: Sequence[_Column], lines: Sequence[int]) -> Measured:
    values = {(column.quantity, column.part): row for column, row in zip(columns, table, strict=True)}
    frequency = values[_FREQUENCY, ""]
    for f, line in zip(frequency, lines, strict=True):
        if f <= 0:
            raise _error(file, f"a frequency of {f:g} Hz is not allowed; frequencies must be above 0", line)
    order = np.argsort(frequency, kind="stable")
    names = dict.fromkeys(column.quantity for column in columns if column.quantity != _FREQUENCY)
    quantities: dict[str, NDArray[Any]] = {}
    for name in names:
        whole = values[name, "re"] + 1j * values[name, "im"] if QUANTITIES[name].is_complex else values[name, ""]
        quantities[name] = whole[order]
    return Measured(file.stem, frequency[order], quantities)


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
