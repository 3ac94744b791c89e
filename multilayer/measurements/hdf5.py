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
from multilayer.limits import memory_bounded
from multilayer.measurements.named_arrays import ATTRIBUTE, channels_of, spectra_of
from multilayer.measurements.readers import Reader
from multilayer.measurements.reading import library, reads
from multilayer.measurements.spectra import Spectra
from multilayer.signals.channels import Channels

SIGNATURE = b"\x89HDF\r\n\x1a\n"
_KIND = "an HDF5 file"
_HEAP = b"GCOL\1\0\0\0"
_UNITS = ("units", "unit")
_NUMBERS, _COMPLEX = "biufc", ("real", "imag")  # kinds of types, and fields of MATLAB's complex numbers
_PACKING = ("scale_factor", "add_offset")  # of netCDF: the number is factor times what is stored, plus offset
_CHECKSUM = 4  # bytes of Fletcher-32


def read_hdf5(path: Path | str) -> Channels:
    """Read the datasets of an ``.h5`` file through h5py, called by their paths.

    A unit is an attribute ``units`` or ``unit`` of its dataset; attributes ``scale_factor`` and ``add_offset`` are
    applied to its numbers. Rates (see `named_arrays.channels_of`) may be attributes of the file, a group or a dataset,
    too.

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
        attributes: dict[str, Any] = {}
        for key in item.attrs:
            attribute = item.attrs.get_id(key)
            # what others are is not needed here, and damaged ones crash the library
            if isinstance(attribute.get_type(), (h5py.h5t.TypeIntegerID, h5py.h5t.TypeFloatID, h5py.h5t.TypeStringID)):
                count(prod(attribute.shape))
                attributes[_text(key)] = item.attrs[key]
        arrays.update({f"{name}{ATTRIBUTE}{key}": np.asarray(value) for key, value in attributes.items()})
        is_text = _text(attributes.get("MATLAB_class", "")) == "char"
        if not isinstance(item, h5py.Dataset) or is_text or item.shape is None or not _is_of_numbers(item.dtype):
            return
        if item.is_virtual or item.external:
            text = f"{show(name)} takes its numbers from other files, which are not read; copy them into this one"
            raise InputError(Problem(text, file=file))
        count(max(item.size, item.nbytes // 8))
        _refuse_broken_chunks(item)
        arrays[name] = _unpacked(np.asarray(item), attributes, name, file)
        unit_texts = [_text(attributes[key]) for key in _UNITS if key in attributes]
        units.update({name: unit_texts[0]} if unit_texts else {})

    with reads(file, _KIND), memory_bounded(2 * 8 * DATA_VALUES.most):
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


def _is_of_numbers(kind: np.dtype[Any]) -> bool:
    return kind.kind in _NUMBERS or kind.names == _COMPLEX


def _unpacked(stored: Any, attributes: dict[str, Any], name: str, file: Path) -> Any:
    """Return the numbers that whole numbers stand for, by the attributes of their dataset."""
    packing = [np.asarray(attributes.get(key, usual)) for key, usual in zip(_PACKING, (1.0, 0.0), strict=True)]
    if not any(key in attributes for key in _PACKING):
        return stored
    if stored.dtype.kind not in _NUMBERS or not all(x.size == 1 and x.dtype.kind in "fiu" for x in packing):
        text = f"{show(name)} has a {' or '.join(_PACKING)} that is no single number; export it without"
        raise InputError(Problem(text, file=file))
    factor, offset = (float(x.ravel()[0]) for x in packing)
    return factor * stored + offset


def _refuse_broken_chunks(dataset: Any) -> None:
    """Refuse a dataset with pieces too short for their checksums: the library reads beyond them and crashes."""
    if not dataset.chunks or not hasattr(dataset.id, "chunk_iter"):  # of HDF5 1.12.3 or later
        return
    sizes: list[int] = []
    dataset.id.chunk_iter(lambda piece: sizes.append(piece.size))
    if min(sizes, default=_CHECKSUM + 1) <= _CHECKSUM * dataset.fletcher32:
        raise ValueError("a piece of its numbers is empty")


def _text(value: Any) -> str:
    return value.decode(errors="replace") if isinstance(value, bytes) else str(value)


HDF5 = Reader(read_hdf5, read_hdf5_spectra)
