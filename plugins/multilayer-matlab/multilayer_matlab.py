"""A reader of MATLAB's `.mat` files, which hold `base`, `top` and, if they like, `sampling_rate`."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import loadmat

from multilayer.errors import InputError, Problem
from multilayer.measurements.recording import Waveforms


def read_mat(path: Path) -> Waveforms:
    """Read accelerations, m/s2, from the variables `base` and `top`: vectors, or matrices with a row per repeat.

    `sampling_rate` is in Hz. Files up to version 7.2 are read; save with ``save -v7``.

    Raises
    ------
    InputError
        For a file that is none of MATLAB's, of version 7.3, or that lacks a channel.
    """
    try:
        held: dict[str, Any] = loadmat(path)
    except NotImplementedError:
        raise _error(path, "is of MATLAB's version 7.3; save it with 'save -v7'") from None
    except Exception as error:  # scipy raises many kinds for what is no such file
        raise _error(path, f"is no .mat file that can be read ({error})") from None
    base, top = (_channel(path, held, name) for name in ("base", "top"))
    if "sampling_rate" not in held:
        return Waveforms(base, top)
    rate = np.ravel(held["sampling_rate"])
    if rate.size != 1 or rate.dtype.kind not in "fiu" or not rate[0] > 0:
        raise _error(path, "'sampling_rate' is no single number of Hz above 0")
    return Waveforms(base, top, float(rate[0]))


def _channel(path: Path, held: dict[str, Any], name: str) -> Any:
    if name not in held:
        found = ", ".join(key for key in held if not key.startswith("__")) or "nothing"
        raise _error(path, f"has no variable '{name}'; it holds {found}")
    values = np.atleast_2d(held[name])
    if values.dtype.kind not in "fiu":
        raise _error(path, f"'{name}' holds no real numbers")
    return np.asarray(values.T if values.shape[1] == 1 else values, dtype=float)


def _error(path: Path, message: str) -> InputError:
    return InputError(Problem(message, file=path))
