"""A table for another program: values over frequency, and over angle or trace wavenumber, as CSV, MAT, HDF5 or UFF."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.csv_table import csv_table
from multilayer.doors import ascii_line, for_log
from multilayer.errors import InputError, Problem
from multilayer.measurements.reading import library

_DIGITS = 12  # a difference of two entries may be small beside them
_LINE, _LABEL = 80, 20  # characters of an identification line and of a label of UFF
_FREQUENCY, _GENERAL, _RESPONSE = 18, 0, 4  # types of an abscissa, and of functions, of UFF
_MAT_TEXT, _MAT_HEADER = b"MATLAB 5.0 MAT-file, written by multilayer", 116
_UNITS_OF_DIRECTION = {"angle": "deg", "trace_wavenumber": "rad/m"}


@dataclass(frozen=True)
class Exported:
    """Values for another program.

    Attributes
    ----------
    name : str
        Of the stack.
    kind : str
        What it is, see `exchange.quantities`.
    frequency : array, shape (n_frequency,)
        Hz.
    along : str
        ``angle`` (degrees) or ``trace_wavenumber`` (rad/m); empty in a diffuse field.
    directions : array, shape (n_directions,)
        Values of `along`; one NaN where there is none.
    values : mapping
        By name, of shape (n_frequency, n_directions), real or complex.
    units : mapping
        By name, where there is one.
    remarks : tuple of str
        What a reader must know: time dependence, signs, what touches the faces.
    """

    name: str
    kind: str
    frequency: RealArray
    along: str
    directions: RealArray
    values: Mapping[str, NDArray[Any]]
    units: Mapping[str, str]
    remarks: tuple[str, ...]

    def squeezed(self) -> dict[str, NDArray[Any]]:
        """Return the values, of shape (n_frequency,) where there is one direction only."""
        return {
            name: np.asarray(values[:, 0] if self.directions.size == 1 else values)
            for name, values in self.values.items()
        }

    def content(self, file: Path) -> bytes:
        """Return the table in the format that a file's suffix stands for.

        Raises
        ------
        InputError
            For a suffix that none is written for, or a library that is not installed.
        """
        return _writer(file)(self, file)


def refuse_unknown_suffix(file: Path) -> None:
    """Refuse a file whose suffix stands for no format of tables, ahead of all computing.

    Raises
    ------
    InputError
    """
    _writer(file)


def _writer(file: Path) -> Callable[[Exported, Path], bytes]:
    writer = _WRITERS.get(file.suffix.lower())
    if writer is None:
        known = ", ".join(_WRITERS)
        raise InputError(Problem(f"no table is written as '{file.suffix}'; allowed: {known}", file=file))
    return writer


def _csv(table: Exported, _file: Path) -> bytes:
    columns: dict[str, RealArray] = {"frequency_hz": np.tile(table.frequency, table.directions.size)}
    if table.along:
        unit = _UNITS_OF_DIRECTION[table.along]
        columns[f"{table.along} [{unit}]"] = np.repeat(table.directions, table.frequency.size)
    for name, values in table.values.items():
        unit = f" [{table.units[name]}]" if name in table.units else ""
        flat = values.T.ravel()
        parts = {"_re": flat.real, "_im": flat.imag} if np.iscomplexobj(flat) else {"": flat}
        columns |= {f"{name}{suffix}{unit}": part for suffix, part in parts.items()}
    rows = zip(*(column.tolist() for column in columns.values()), strict=True)
    head = "".join(f"# {for_log(text)}\n" for text in (f"{table.name}: {table.kind}", *table.remarks))
    return (head + csv_table([*columns], rows, digits=_DIGITS)).encode()


def _axes(table: Exported) -> dict[str, RealArray]:
    return {"frequency": table.frequency} | ({table.along: table.directions} if table.along else {})


def _all_units(table: Exported) -> dict[str, str]:
    units = {"frequency": "Hz", **table.units}
    return units | {table.along: _UNITS_OF_DIRECTION[table.along]} if table.along else units


def _mat(table: Exported, _file: Path) -> bytes:
    from scipy.io import savemat

    stream = io.BytesIO()
    arrays = {name: np.asarray(values) for name, values in (_axes(table) | table.squeezed()).items()}
    remarks = np.array([for_log(text) for text in table.remarks], dtype=object)
    savemat(cast(Any, stream), {**arrays, "units": _all_units(table), "remarks": remarks}, oned_as="column")
    content = bytearray(stream.getvalue())
    content[:_MAT_HEADER] = _MAT_TEXT.ljust(_MAT_HEADER)  # in place of the time: the same values make the same bytes
    return bytes(content)


def _hdf5(table: Exported, file: Path) -> bytes:
    h5py, stream = library("h5py", file, "written"), io.BytesIO()
    with h5py.File(stream, "w") as written:
        written.attrs["kind"] = table.kind
        written.attrs["remarks"] = "\n".join(map(for_log, table.remarks))
        for name, values in (_axes(table) | table.squeezed()).items():
            written[name] = values
            if unit := _all_units(table).get(name):
                written[name].attrs["units"] = unit
    return stream.getvalue()


def _uff(table: Exported, file: Path) -> bytes:
    pyuff = library("pyuff", file, "written")
    if table.frequency.size < 2:
        raise InputError(Problem("a universal file needs two frequencies or more; write .csv, .mat or .h5", file=file))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "table.uff"
        opened = pyuff.UFF(str(path))
        for record in _records(table):
            opened.write_sets(pyuff.prepare_58(**record), mode="add")
        return path.read_bytes()


def _records(table: Exported) -> Iterator[dict[str, Any]]:
    """Give the functions of frequency, one for each value and direction, as pyuff takes them."""
    # behind the kind: a line of -1 alone would end the dataset
    lines = [ascii_line(text, _LINE) for text in (f"{table.kind} of {table.name}", *table.remarks)][:4]
    lines += ["NONE"] * (4 - len(lines))
    for name, values in table.values.items():
        for j, direction in enumerate(table.directions):
            where = f" at {direction:g} {_UNITS_OF_DIRECTION[table.along]}" if table.directions.size > 1 else ""
            data = values[:, j]
            yield {
                "binary": 0, "func_type": _RESPONSE if np.iscomplexobj(data) else _GENERAL,
                "rsp_ent_name": "NONE", "rsp_node": 0, "rsp_dir": 0,
                "ref_ent_name": "NONE", "ref_node": 0, "ref_dir": 0,
                "id1": f"{name}{where}", **{f"id{i}": line for i, line in enumerate(lines, start=2)},
                "data": data, "x": table.frequency, "abscissa_spacing": 0, "abscissa_spec_data_type": _FREQUENCY,
                "abscissa_axis_units_lab": "Hz", "ordinate_axis_units_lab": table.units.get(name, "NONE")[:_LABEL],
                "ordinate_spec_data_type": 0, "orddenom_spec_data_type": 0, "z_axis_spec_data_type": 0,
            }  # fmt: skip


_WRITERS: dict[str, Callable[[Exported, Path], bytes]] = {
    ".csv": _csv, ".mat": _mat, ".h5": _hdf5, ".hdf5": _hdf5, ".uff": _uff, ".unv": _uff,
}  # fmt: skip
