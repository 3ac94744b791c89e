"""HDF5 files."""

from __future__ import annotations

import struct
from math import prod
from mmap import ACCESS_READ, mmap
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.bounds import CHANNELS, DATA_VALUES
from multilayer.errors import InputError, Problem, show
from multilayer.measurements.named_arrays import ATTRIBUTE, channels_of, spectra_of
from multilayer.measurements.readers import Reader
from multilayer.measurements.reading import library, reads
from multilayer.measurements.spectra import Spectra
from multilayer.signals.channels import Channels

SIGNATURE = b"\x89HDF\r\n\x1a\n"
_KIND = "an HDF5 file"
_HEAP = b"GCOL\1\0\0\0"
_UNITS = ("units", "unit")
_NUMBERS = "biufcV"  # kinds of types; V: complex numbers of MATLAB's


def read_hdf5(path: Path | str) -> Channels:
    """Read the datasets of an ``.h5`` file through h5py, called by their paths.

    A unit is an attribute ``units`` or ``unit`` of its dataset. Rates (see `named_arrays.channels_of`) may be
    attributes of the file or of a dataset, too.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When h5py is not installed, or the file is damaged, cut short, or holds no arrays of samples.
    """
    return channels_of(Path(path), *hdf5_arrays(Path(path)))


def read_hdf5_spectra(path: Path | str) -> Spectra:
    """Read the datasets of an ``.h5`` file that have as many values as its dataset ``frequency``; see `read_hdf5`.

    Raises
    ------
    InputError
        When h5py is not installed, or the file is damaged, cut short, or holds no such datasets; see
        `named_arrays.spectra_of`.
    """
    return spectra_of(Path(path), *hdf5_arrays(Path(path)))


def hdf5_arrays(file: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Return the datasets of numbers and their attributes (named as in `named_arrays.channels_of`), and units, by path.

    How many numbers there are, the headers tell ahead of the data: unwritten and compressed ones take hardly any room.
    """
    h5py = library("h5py", file)
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}

    numbers = 0

    def count(more: int) -> None:
        nonlocal numbers
        numbers += more
        DATA_VALUES.check(numbers, file)

    def visit(path: str | bytes, item: Any) -> None:
        name = _text(path)  # bytes that are no UTF-8 stay bytes
        CHANNELS.check(len(arrays), file)
        for key in item.attrs:
            count(prod(item.attrs.get_id(key).shape))
            arrays[f"{name}{ATTRIBUTE}{_text(key)}"] = np.asarray(item.attrs[key])
        is_text = _text(item.attrs.get("MATLAB_class", "")) == "char"
        if not isinstance(item, h5py.Dataset) or is_text or item.shape is None or item.dtype.kind not in _NUMBERS:
            return
        if item.is_virtual or item.external:
            text = f"{show(name)} takes its numbers from other files, which are not read; copy them into this one"
            raise InputError(Problem(text, file=file))
        count(max(item.size, item.nbytes // 8))
        arrays[name] = np.asarray(item)
        unit_texts = [_text(item.attrs[key]) for key in _UNITS if key in item.attrs]
        units.update({name: unit_texts[0]} if unit_texts else {})

    with reads(file, _KIND):
        _refuse_broken_heaps(file)
        with h5py.File(file, "r") as opened:
            visit("", opened)
            opened.visititems(visit)
    return arrays, units


def _refuse_broken_heaps(file: Path) -> None:
    """Refuse a file whose heaps of texts do not add up: the library follows them for ever, or takes gigabytes.

    HDF5 File Format Specification 3.0, section III.E: global heap collections.
    """
    with file.open("rb") as stream, mmap(stream.fileno(), 0, access=ACCESS_READ) as content:
        start = content.find(_HEAP)
        while start >= 0:
            (size,) = struct.unpack_from("<Q", content, start + len(_HEAP)) if start + 16 <= len(content) else (0,)
            at, end = start + 16, start + size
            if end > len(content):
                raise ValueError("it ends within a heap of texts")
            while at + 16 <= end:
                index, _, _, length = struct.unpack_from("<HHIQ", content, at)
                taken = length if index == 0 else 16 + length + -length % 8  # 0: free space, its head included
                if not 16 <= taken <= end - at:
                    raise ValueError("a heap of texts does not add up")
                at += taken
            start = content.find(_HEAP, start + len(_HEAP))


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


HDF5 = Reader(read_hdf5, read_hdf5_spectra)
