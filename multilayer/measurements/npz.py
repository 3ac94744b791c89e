"""NumPy archives."""

from __future__ import annotations

import warnings
import zipfile
from math import prod
from pathlib import Path

import numpy as np

from multilayer.arrays import RealArray
from multilayer.bounds import CHANNELS, DATA_VALUES
from multilayer.errors import InputError, MultilayerError, Problem
from multilayer.measurements.named_arrays import spectra_of
from multilayer.measurements.readers import Reader
from multilayer.measurements.spectra import Spectra
from multilayer.signals.recording import Waveforms

_CHANNELS = ("base", "top")
_WANTED = (*_CHANNELS, "sampling_rate")
_NOT_READ = np.empty(0)
_SUFFIX = ".npy"


def read_npz(path: Path | str) -> Waveforms:
    """Read a ``.npz`` file with the arrays `base` and `top`.

    Parameters
    ----------
    path : Path or str
        The file. Each array has the shape (repeats, samples) or (samples,); accelerations in m/s^2. A number
        `sampling_rate`, Hz, may stand beside them.

    Raises
    ------
    InputError
        When the file is no such archive (or is cut short), an array is missing, holds no real numbers, is
        empty, or the two differ in shape. Pickled objects are refused: they could run code.
    """
    file = Path(path)
    arrays = _load(file, _WANTED)
    base, top = (_channel(arrays, name, file) for name in _CHANNELS)
    if base.shape != top.shape:
        raise _error(file, f"base has shape {base.shape} but top {top.shape}; they must be recorded together")
    return Waveforms(base, top, _sampling_rate(arrays, file))


def read_npz_spectra(path: Path | str) -> Spectra:
    """Read the arrays of a ``.npz`` file that have as many values as its array ``frequency``.

    Raises
    ------
    InputError
        When the file is no such archive, or holds no such arrays; see `named_arrays.spectra_of`.
    """
    return spectra_of(Path(path), _load(Path(path)), {})


def _error(file: Path, message: str) -> InputError:
    return InputError(Problem(message, file=file))


def _load(file: Path, wanted: tuple[str, ...] = ()) -> dict[str, np.ndarray]:
    """Return the arrays of the archive by name; with `wanted`, the others are listed but not read."""
    if not file.exists():
        raise _error(file, "there is no such file")
    if not zipfile.is_zipfile(file):
        raise _error(file, "is no .npz archive, or one that is cut short; copy or export it again")
    try:
        with warnings.catch_warnings(), zipfile.ZipFile(file) as archive:
            warnings.simplefilter("ignore")  # of headers that are no Python, ahead of the error
            entries = [entry for entry in archive.infolist() if entry.filename.endswith(_SUFFIX)]
            chosen = {entry.filename.removesuffix(_SUFFIX): entry for entry in entries}
            read = {name: entry for name, entry in chosen.items() if name in (wanted or [name])}
            CHANNELS.check(len(chosen), file)
            DATA_VALUES.check(sum(_claimed(archive, entry) for entry in read.values()), file)
            return {name: _array(archive, read[name]) if name in read else _NOT_READ for name in chosen}
    except MultilayerError:
        raise
    except Exception as error:  # a damaged archive fails in many ways
        raise _error(file, f"cannot be read as an .npz archive ({error}); copy or export it again") from None


def _claimed(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> int:
    """Return how many numbers of 8 bytes an array has by its header, or its entry in the archive if that says more."""
    with archive.open(entry) as stream:
        version = np.lib.format.read_magic(stream)
        read_header = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
        shape, _, dtype = read_header(stream)
    return max(prod(shape), prod(shape) * dtype.itemsize // 8, entry.file_size // 8)


def _array(archive: zipfile.ZipFile, entry: zipfile.ZipInfo) -> np.ndarray:
    with archive.open(entry) as stream:
        array = np.lib.format.read_array(stream, allow_pickle=False)
        stream.read()  # to its end, where the checksum is
    return np.asarray(array)


def _channel(arrays: dict[str, np.ndarray], name: str, file: Path) -> RealArray:
    if name not in arrays:
        names = ", ".join(arrays) or "none"
        raise _error(file, f"has no array '{name}'; it must hold 'base' and 'top', and holds: {names}")
    values = arrays[name]
    if values.dtype.kind not in "fiu":
        raise _error(file, f"array '{name}' is of type {values.dtype}; it must hold real numbers, in m/s^2")
    if values.ndim not in (1, 2):
        raise _error(file, f"array '{name}' has shape {values.shape}; it must be (repeats, samples)")
    if values.size == 0:
        raise _error(file, f"array '{name}' is empty: its shape is {values.shape}")
    return np.atleast_2d(values).astype(np.float64)


def _sampling_rate(arrays: dict[str, np.ndarray], file: Path) -> float | None:
    if "sampling_rate" not in arrays:
        return None
    value = arrays["sampling_rate"]
    if value.size != 1 or value.dtype.kind not in "fiu" or not float(value.reshape(())) > 0:
        raise _error(file, "sampling_rate must be one number above 0, in Hz")
    return float(value.reshape(()))


NPZ = Reader(read_npz, read_npz_spectra)
