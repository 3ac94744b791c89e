"""A reader of bursts in NumPy's `.npy` files: one array, base and top."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from multilayer.errors import InputError, Problem
from multilayer.signals.recording import Waveforms


def read_npy(path: Path) -> Waveforms:
    """Read an array of shape (2, samples) or (repeats, 2, samples): base and top in m/s2; the campaign says the rate.

    Raises
    ------
    InputError
        For a file that is none of NumPy's, holds objects (which would run code when read), or has another shape.
    """
    try:
        held = np.load(path, allow_pickle=False)
    except (OSError, ValueError, EOFError) as error:
        raise InputError(Problem(f"holds no array of numbers ({error})", file=path)) from None
    if not isinstance(held, np.ndarray) or held.dtype.kind not in "fiu":
        raise InputError(Problem("holds no array of real numbers", file=path))
    if held.ndim not in (2, 3) or held.shape[-2] != 2:
        text = f"has the shape {held.shape}; it must be (2, samples) or (repeats, 2, samples), base and top"
        raise InputError(Problem(text, file=path))
    bursts = held if held.ndim == 3 else held[None]
    return Waveforms(base=bursts[:, 0].astype(float), top=bursts[:, 1].astype(float))
