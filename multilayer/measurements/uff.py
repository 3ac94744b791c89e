"""Universal files: time records of dataset 58, which analysers and modal programs write."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.errors import InputError, Problem
from multilayer.measurements.reading import damaged, library, reads
from multilayer.signals.channels import Channel, Channels, as_samples, different, rate_of_step

_KIND = "a universal file"
_TIME_RESPONSE = 1
_MARK = b"    -1"  # opens and closes a dataset; behind binary data on no line of its own
_START = 10_000  # bytes within which the first dataset opens
_DIRECTIONS = {1: "+X", 2: "+Y", 3: "+Z", -1: "-X", -2: "-Y", -3: "-Z"}


def read_uff(path: Path | str) -> Channels:
    """Read the time records (dataset 58, text or binary, function type 1) of a ``.uff`` or ``.unv`` file through pyuff.

    A channel is called by the first identification line of its record, or by name, node and direction of its response
    where that is ``NONE`` or not its own.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When pyuff is not installed, or the file is damaged, cut short, or holds no time record at even steps.
    """
    file = Path(path)
    pyuff = library("pyuff", file)
    with reads(file, _KIND):
        _refuse_cut_short(file)
        uff = pyuff.UFF(str(file))
        sets = [uff.read_sets(i) for i, kind in enumerate(uff.get_set_types()) if str(kind).startswith("58")]
        records = [one for one in sets if one["func_type"] == _TIME_RESPONSE and not np.iscomplexobj(one["data"])]
        longer = [_place(one) for one in records]
        own = [str(one.get("id1", "")).strip() for one in records]
        names = different([_said(name) or place for name, place in zip(own, longer, strict=True)], longer)
        channels = tuple(_channel(file, name, one) for name, one in zip(names, records, strict=True))
    if not channels:
        raise InputError(Problem("holds no time record (dataset 58, function type 1)", file=file))
    return Channels(file, channels)


def _refuse_cut_short(file: Path) -> None:
    """Refuse a file whose last dataset is not closed, which pyuff would leave out without a word."""
    content = file.read_bytes()
    if not re.search(rb"^\s*-1\s*$", content[:_START], re.MULTILINE):
        raise damaged(file, _KIND, "there is no dataset in it")
    if not content.rstrip().endswith(_MARK):
        raise damaged(file, _KIND, "its last dataset is not closed")


def _said(text: str) -> str:
    return "" if text.upper() == "NONE" else text


def _place(record: Any) -> str:
    name = _said(str(record.get("rsp_ent_name", "")).strip())
    where = f"{record.get('rsp_node', 0)}{_DIRECTIONS.get(int(record.get('rsp_dir', 0)), '')}"
    return f"{name} {where}".strip()


def _channel(file: Path, name: str, record: Any) -> Channel:
    samples = as_samples(record["data"])
    if samples.size != int(record["num_pts"]):
        raise damaged(file, _KIND, f"'{name}' has {samples.size} of {record['num_pts']} samples")
    if not record["abscissa_spacing"]:
        raise InputError(Problem(f"'{name}' is sampled at uneven steps; export it at even ones", file=file))
    step = float(record["abscissa_inc"])
    unit = _said(str(record.get("ordinate_axis_units_lab", "")).strip()) or None
    return Channel(name, samples, unit, rate_of_step(step) if step > 0 else None)
