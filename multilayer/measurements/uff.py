"""Universal files: dataset 58, time records and functions of frequency, of analysers and modal programs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.errors import InputError, Problem
from multilayer.measurements.accelerometers import acceleration_ratio
from multilayer.measurements.readers import Reader
from multilayer.measurements.reading import damaged, library, reads
from multilayer.measurements.spectra import Spectra
from multilayer.signals.channels import Channel, Channels, as_samples, different, rate_of_step
from multilayer.tables import Header

_KIND = "a universal file"
_TIME_RESPONSE = 1
_UNKNOWN, _FREQUENCY = 0, 18  # types of an abscissa
_OF_FREQUENCY = (2, 3, 4, 5, 6, 9, 10, 12, 21, 26)  # types of functions: spectra, transfer functions, coherences
_MARK = b"    -1"  # opens and closes a dataset; behind binary data it does not start a line
_START = 10_000  # bytes within which the first dataset opens
_DIRECTIONS = {1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}


def read_uff(path: Path | str) -> Channels:
    """Read the time records (dataset 58, text or binary, function type 1) of a ``.uff`` or ``.unv`` file through pyuff.

    A channel is called by the first identification line of its record, or by name, node and direction of its response
    where that line is ``NONE`` or the same for two records.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When pyuff is not installed, or the file is damaged, cut short, or holds no time record at even steps.
    """
    file = Path(path)
    with reads(file, _KIND):
        records = [
            record
            for record in _records(file)
            if record["func_type"] == _TIME_RESPONSE and not np.iscomplexobj(record["data"])
        ]
        channels = tuple(_channel(file, name, record) for name, record in zip(_names(records), records, strict=True))
    if not channels:
        raise InputError(Problem("holds no time record (dataset 58, function type 1)", file=file))
    return Channels(file, channels)


def read_uff_spectra(path: Path | str) -> Spectra:
    """Read the functions of frequency (dataset 58, text or binary) of a ``.uff`` or ``.unv`` file through pyuff.

    Functions of frequency have a frequency as their abscissa, or an unknown abscissa and the type of a spectrum:
    transfer functions, power spectra, coherences. They are named as channels are in `read_uff`; their unit is the label
    of the ordinate, over that of its denominator.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When pyuff is not installed, or the file is damaged, cut short, or holds no such function, or some at different
        frequencies.
    """
    file = Path(path)
    with reads(file, _KIND):
        records = [record for record in _records(file) if _is_spectrum(record)]
        spectra = [(name, _whole(file, name, record)) for name, record in zip(_names(records), records, strict=True)]
    if not records:
        raise InputError(Problem("holds no function of frequency (dataset 58, abscissa of type 18)", file=file))
    frequency, label = np.asarray(records[0]["x"], dtype=float), _label(records[0], "abscissa") or "Hz"
    for record in records[1:]:
        if record["x"].shape != frequency.shape or not np.allclose(record["x"], frequency, rtol=1e-9):
            text = "holds functions at different frequencies; export those of one measurement into a file of their own"
            raise InputError(Problem(text, file=file))
    try:
        hertz = Header("frequency", "frequency", label).factor("Hz")
    except ValueError as error:
        raise InputError(Problem(str(error), file=file)) from None
    units = {name: unit for (name, _), record in zip(spectra, records, strict=True) if (unit := _unit(record))}
    return Spectra(frequency * hertz, dict(spectra), units)


def _is_spectrum(record: Any) -> bool:
    abscissa = int(record["abscissa_spec_data_type"])
    return abscissa == _FREQUENCY or (abscissa == _UNKNOWN and record["func_type"] in _OF_FREQUENCY)


def _label(record: Any, axis: str) -> str:
    return _unless_none(str(record.get(f"{axis}_axis_units_lab", "")).strip())


def _unit(record: Any) -> str:
    above, below = _label(record, "ordinate"), _label(record, "orddenom")
    if not below:
        return above
    if above == below:
        return "1"
    return acceleration_ratio(above, below) or f"{above or 1}/({below})"


def _records(file: Path) -> list[Any]:
    """Return all datasets 58."""
    pyuff = library("pyuff", file)
    _refuse_cut_short(file)
    uff = pyuff.UFF(str(file))
    return [uff.read_sets(i) for i, kind in enumerate(uff.get_set_types()) if str(kind).startswith("58")]


def _names(records: Sequence[Any]) -> list[str]:
    places = [_place(record) for record in records]
    ids = [_unless_none(str(record.get("id1", "")).strip()) for record in records]
    return different([name or place for name, place in zip(ids, places, strict=True)], places)


def _refuse_cut_short(file: Path) -> None:
    """Refuse a file whose last dataset is not closed, which pyuff would leave out without a word."""
    content = file.read_bytes()
    if not re.search(rb"^\s*-1\s*$", content[:_START], re.MULTILINE):
        raise damaged(file, _KIND, "there is no dataset in it")
    if not content.rstrip().endswith(_MARK):
        raise damaged(file, _KIND, "its last dataset is not closed")


def _unless_none(text: str) -> str:
    return "" if text.upper() == "NONE" else text


def _place(record: Any) -> str:
    name = _unless_none(str(record.get("rsp_ent_name", "")).strip())
    where = f"{record.get('rsp_node', 0)}{_DIRECTIONS.get(int(record.get('rsp_dir', 0)), '')}"
    return f"{name} {where}".strip()


def _whole(file: Path, name: str, record: Any) -> NDArray[Any]:
    values = np.asarray(record["data"]).ravel()
    if values.size != int(record["num_pts"]):
        raise damaged(file, _KIND, f"'{name}' has {values.size} of {record['num_pts']} samples")
    return values


def _channel(file: Path, name: str, record: Any) -> Channel:
    samples = as_samples(_whole(file, name, record))
    if not record["abscissa_spacing"]:
        raise InputError(Problem(f"'{name}' is sampled at uneven steps; export it at even ones", file=file))
    step, start = float(record["abscissa_inc"]), float(record["abscissa_min"])
    rate = rate_of_step(step) if step > 0 else None
    return Channel(name, samples, _label(record, "ordinate") or None, rate, start)


UFF = Reader(read_uff, read_uff_spectra)
