"""Campaigns as text and bytes: what every writer of them shares."""

from __future__ import annotations

import zipfile
from io import BytesIO

import numpy as np

from multilayer.signals.recording import Recording

_FIRST_DATE = (1980, 1, 1, 0, 0, 0)  # of every entry of an archive: the same signals make the same bytes
HEADING = """\
# Two-plate shaker campaign. SI units; accelerations in m/s^2; one .npz per burst and configuration, with the arrays
# 'base' (support plate) and 'top' (top plate), each of shape (repeats, samples). 'uncertainty': one standard deviation.
"""


def signal_name(configuration: str, frequency: float) -> str:
    """Return the file of one burst, relative to the campaign's folder."""
    digits = f"{frequency:.6f}".rstrip("0").rstrip(".")
    whole, point, rest = digits.partition(".")
    return f"signals/{configuration}_{whole:0>4}{point}{rest}Hz.npz"


def signal_bytes(recording: Recording) -> bytes:
    """Return the ``.npz`` archive of a recording, in single precision: the same bytes for the same signals."""
    buffer = BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, channel in (("base", recording.base), ("top", recording.top)):
            array = BytesIO()
            np.lib.format.write_array(array, channel.astype("<f4"), allow_pickle=False)
            entry = zipfile.ZipInfo(f"{name}.npy", _FIRST_DATE)
            entry.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(entry, array.getvalue())
    return buffer.getvalue()
