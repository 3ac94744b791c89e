"""WAV files of audio interfaces."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray
from multilayer.bounds import CHANNELS, DATA_VALUES
from multilayer.errors import InputError, Problem
from multilayer.measurements.reading import damaged, reads
from multilayer.signals.channels import Channel, Channels, as_samples

_KIND = "a WAV file"
_HEAD = 12  # bytes ahead of the first chunk
_UNKNOWN = 0xFFFFFFFF  # the length of RF64 stands elsewhere


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
    with reads(file, _KIND):
        _refuse_claims(file)
        rate, data = wavfile.read(file)
    samples = _of_full_scale(data).reshape(len(data), -1).T
    if not samples.size:
        raise InputError(Problem("holds no samples", file=file))
    numbered = enumerate(samples, start=1)
    return Channels(file, tuple(Channel(f"channel_{i}", as_samples(row), None, float(rate)) for i, row in numbered))


def _refuse_claims(file: Path) -> None:
    """Refuse a file that claims to hold more than it does, or more channels and samples than are taken."""
    size = file.stat().st_size
    with file.open("rb") as stream:
        order = ">" if stream.read(_HEAD)[:4] == b"RIFX" else "<"
        while len(head := stream.read(8)) == 8:
            name, length = struct.unpack(f"{order}4sI", head)
            if name == b"fmt " and length >= 16:
                _, channels, _, _, _, bits = struct.unpack(f"{order}HHIIHH", stream.read(16))
                CHANNELS.check(channels, file)
                DATA_VALUES.check(size // max(1, bits // 8), file)
                length -= 16
            if name == b"data":
                if length != _UNKNOWN and stream.tell() + length > size:
                    raise damaged(file, _KIND, f"it holds {size - stream.tell()} of {length} bytes of samples")
                return
            stream.seek(length + length % 2, 1)


def _of_full_scale(data: NDArray[np.generic]) -> RealArray:
    with np.errstate(invalid="ignore"):  # of bits that are no number
        values = data.astype(float)
    if data.dtype.kind == "f":
        return values
    half = 2.0 ** (8 * data.dtype.itemsize - 1)
    return values / half - 1.0 if data.dtype.kind == "u" else values / half
