"""WAV files of audio interfaces."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.errors import InputError, Problem
from multilayer.measurements.reading import reads
from multilayer.signals.channels import Channel, Channels, as_samples


def read_wav(path: Path | str) -> Channels:
    """Read a ``.wav`` file through SciPy: channels ``channel_1``, ``channel_2``, ..., as fractions of full scale.

    WAV files have no units: the user states what full scale (1) is.

    Parameters
    ----------
    path : Path or str

    Raises
    ------
    InputError
        When the file is no WAV file, is cut short, or is empty.
    """
    from scipy.io import wavfile

    file = Path(path)
    with reads(file, "a WAV file"):
        rate, data = wavfile.read(file)
    samples = _of_full_scale(data).reshape(len(data), -1).T
    if not samples.size:
        raise InputError(Problem("holds no samples", file=file))
    numbered = enumerate(samples, start=1)
    return Channels(file, tuple(Channel(f"channel_{i}", as_samples(row), None, float(rate)) for i, row in numbered))


def _of_full_scale(data: NDArray[np.generic]) -> RealArray:
    values = data.astype(float)
    if data.dtype.kind == "f":
        return values
    half = 2.0 ** (8 * data.dtype.itemsize - 1)
    return values / half - 1.0 if data.dtype.kind == "u" else values / half
