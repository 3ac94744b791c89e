"""MATLAB files."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from multilayer.measurements.hdf5 import SIGNATURE, read_hdf5
from multilayer.measurements.named_arrays import channels_of
from multilayer.measurements.reading import reads
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
    file = Path(path)
    if _is_version_73(file):
        return read_hdf5(file)
    from scipy.io import loadmat

    with reads(file, _KIND):
        held = loadmat(file, simplify_cells=True)
        flat = _flat({name: value for name, value in held.items() if not name.startswith("__")})
    units = {name.removeprefix("units/"): str(text) for name, text in flat.items() if isinstance(text, str)}
    arrays = {name: np.asarray(value) for name, value in flat.items() if not isinstance(value, str)}
    return channels_of(file, arrays, units)


def _is_version_73(file: Path) -> bool:
    with file.open("rb") as stream:
        stream.seek(_SIGNATURE_AT)
        return stream.read(len(SIGNATURE)) == SIGNATURE


def _flat(values: dict[str, Any], above: str = "") -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, value in values.items():
        found |= _flat(value, f"{above}{name}/") if isinstance(value, dict) else {f"{above}{name}": value}
    return found
