"""Which columns of a table hold the wanted quantities, by name or as the user says, and their values in SI units."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import suggest
from multilayer.tables import Header, Table


@dataclass(frozen=True)
class Column:
    """A column that is wanted.

    Attributes
    ----------
    role : str
        The key under which the caller gets it, as ``frequency``.
    names : tuple of str
        Names that headers may give it, see `tables.Header`; empty where only the user can name it.
    unit : str or None
        SI, ``dB``, or empty for a pure number; None where values are taken as they are written.
    """

    role: str
    names: tuple[str, ...]
    unit: str | None = ""


FREQUENCY = Column("frequency", ("frequency", "f", "freq"), "Hz")
Places: TypeAlias = Mapping[str, tuple[int, float]]
"""By role: index of the column, and the factor from its unit to the wanted one."""


def complex_columns(role: str, names: Sequence[str], unit: str | None = "") -> tuple[Column, Column]:
    """Return the real and imaginary part of a complex quantity, in columns ``NAME_re`` and ``NAME_im``."""
    real, imaginary = (
        Column(f"{role}_{part}", tuple(f"{name}_{part}" for name in names), unit) for part in ("re", "im")
    )
    return real, imaginary


def complex_values(values: Mapping[str, RealArray], role: str) -> ComplexArray:
    """Return the complex values of a role whose parts `complex_columns` asked for."""
    return np.asarray(values[f"{role}_re"] + 1j * values[f"{role}_im"])


def find_columns(
    table: Table,
    wanted: Sequence[Column],
    needed: str,
    called: Mapping[str, str] | None = None,
    *,
    single: bool = False,
) -> dict[str, tuple[int, float]]:
    """Return index and unit factor of every wanted column that a table has; the caller refuses what is missing.

    Parameters
    ----------
    table : Table
    wanted : sequence of Column
    needed : str
        Which columns there must be, for messages.
    called : mapping, optional
        By role, the column's name as the user gives it, where an input file has such a field ('columns').
    single : bool
        Whether a second column of a role is refused; else the first is taken.

    Raises
    ------
    InputError
        With the line of the header, for an empty file, a name in `called` that is not there, and a unit that is missing
        or wrong.
    """
    if not table.headers:
        raise table.error(f"is empty; {needed}")
    places = {}
    for column in wanted:
        matches = [(index, header) for index, header in enumerate(table.headers) if header.name in column.names]
        if called and column.role in called:
            matches = [called_column(table, called[column.role])]
        if single and len(matches) > 1:
            raise table.error(f"two columns hold {column.role}; keep one of them", table.line)
        if matches:
            index, header = matches[0]
            places[column.role] = index, _factor(table, header, column, called is not None)
    return places


def called_column(table: Table, name: str) -> tuple[int, Header]:
    """Return index and header of the column that a user names, perhaps with its unit in brackets at the end.

    Raises
    ------
    InputError
        When there is none of that name.
    """
    text = name.strip()
    if text in table.names:
        index = table.names.index(text)
        return index, table.headers[index]
    bare, _, unit = text.partition("[")
    if unit and bare.strip() in table.names:
        index = table.names.index(bare.strip())
        return index, Header(table.names[index], "", unit.rstrip("] "))
    raise table.error(f"no column is called '{text}'; {suggest(text, table.names)}", table.line)


def _factor(table: Table, header: Header, column: Column, may_be_called: bool) -> float:
    if column.unit is None:
        return 1.0
    try:
        return header.factor(column.unit)
    except ValueError as error:
        hint = f", or add it under 'columns', as {{{column.role}: '{header.text} [...]'}}"
        text = f"{error}{hint}" if may_be_called and header.unit is None else str(error)
        raise table.error(text, table.line) from None


def column_values(table: Table, places: Places) -> dict[str, RealArray]:
    """Return the values of columns by role, in the wanted units, in the order of rising frequency.

    Parameters
    ----------
    table : Table
    places : mapping
        See `find_columns`; the role ``frequency`` must be among them.

    Raises
    ------
    InputError
        With the line, when there is no row, a row is short, a cell is no number, or a frequency is not above 0.
    """
    if not table.rows:
        raise table.error("holds no values below its header")
    written = table.numbers({index for index, _ in places.values()})
    numbers = {role: written[index] * factor for role, (index, factor) in places.items()}
    table.refuse_not_positive(numbers["frequency"])
    order = np.argsort(numbers["frequency"], kind="stable")
    return {role: values[order] for role, values in numbers.items()}
