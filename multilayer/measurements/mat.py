"""MATLAB files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.measurements.hdf5 import SIGNATURE, hdf5_arrays
from multilayer.measurements.mat_structure import refuse_unsound
from multilayer.measurements.named_arrays import channels_of, spectra_of
from multilayer.measurements.readers import Reader
from multilayer.measurements.reading import reads
from multilayer.measurements.spectra import Spectra
from multilayer.signals.channels import Channels

_KIND = "a MATLAB file"
_SIGNATURE_AT = 512  # of version 7.3, which is HDF5 behind a header of MATLAB's


def read_mat(path: Path | str) -> Channels:
    """Read the arrays of a ``.mat`` file through SciPy, or h5py where it is of version 7.3.

    Fields of structs are channels called ``STRUCT/FIELD``; a struct ``units`` holds units by name of the array.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When the file is damaged, cut short, or holds no arrays of samples; see `named_arrays.channels_of` for rates.
    """
    return channels_of(Path(path), *_arrays(Path(path)))


def read_mat_spectra(path: Path | str) -> Spectra:
    """Read the arrays of a ``.mat`` file that have as many values as its array ``frequency``; see `read_mat`.

    Raises
    ------
    InputError
        When the file is damaged, cut short, or holds no such arrays; see `named_arrays.spectra_of`.
    """
    return spectra_of(Path(path), *_arrays(Path(path)))


def _arrays(file: Path) -> tuple[dict[str, NDArray[Any]], dict[str, str]]:
    """Return all arrays, and the units of those that have them, by name."""
    if _is_version_73(file):
        return hdf5_arrays(file)
    from scipy.io import loadmat

    with reads(file, _KIND):
        refuse_unsound(file)
        content = loadmat(file, simplify_cells=True)
        flat = _flat({name: value for name, value in content.items() if not name.startswith("__")})
    units = {name.removeprefix("units/"): str(text) for name, text in flat.items() if isinstance(text, str)}
    return {name: np.asarray(value) for name, value in flat.items() if not isinstance(value, str)}, units


def _is_version_73(file: Path) -> bool:
    with file.open("rb") as stream:
        stream.seek(_SIGNATURE_AT)
        return stream.read(len(SIGNATURE)) == SIGNATURE


def _flat(values: dict[str, Any], above: str = "") -> dict[str, Any]:
    flat: dict[str, Any] = {}
    for name, value in values.items():
        flat |= _flat(value, f"{above}{name}/") if isinstance(value, dict) else {f"{above}{name}": value}
    return flat


MAT = Reader(read_mat, read_mat_spectra)
