"""Data files of every format with bits flipped, bytes lost, cut short, through their readers and a campaign's check."""

from __future__ import annotations

import gc
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.errors import InputError, Problem
from multilayer.measurements.readers import read_channels, read_spectra
from multilayer.signals.disturbance import without_disturbances
from multilayer.signals.quality import check_configuration
from multilayer.signals.recording import Recording
from validation.fuzz.watch import DIFFERENT, PASSED, Outcome, own, tried

RATE = 25600.0
_N = 2048


def _signals() -> dict[str, Any]:
    rng, t = np.random.default_rng(5), np.arange(_N) / RATE
    window = np.sin(np.pi * np.clip((t - 0.02) / 0.02, 0, 1)) ** 2
    tone = window * np.sin(2 * np.pi * 500 * t)
    return {"base": 5 * tone + 0.01 * rng.standard_normal(_N), "top": 7 * tone + 0.01 * rng.standard_normal(_N)}


def _spectra() -> dict[str, Any]:
    f = np.linspace(100, 2000, 200)
    return {"frequency": f, "reflection_re": np.cos(f / 300), "reflection_im": np.sin(f / 300)}


def _npz(file: Path, arrays: dict[str, Any]) -> None:
    np.savez(file, **arrays, sampling_rate=RATE)


def _npz_packed(file: Path, arrays: dict[str, Any]) -> None:
    np.savez_compressed(file, **arrays, sampling_rate=RATE)


def _csv(file: Path, arrays: dict[str, Any]) -> None:
    columns = arrays if "frequency" in arrays else {"time": np.arange(_N) / RATE, **arrays}
    names = ["frequency_hz" if name == "frequency" else name for name in columns]
    rows = np.column_stack(list(columns.values()))
    file.write_text("\n".join([",".join(names), *(",".join(f"{x:.9g}" for x in row) for row in rows), ""]))


def _wav(file: Path, arrays: dict[str, Any]) -> None:
    from scipy.io import wavfile

    wavfile.write(file, int(RATE), np.column_stack([arrays["base"], arrays["top"]]).astype(np.float32))


def _wav_short(file: Path, arrays: dict[str, Any]) -> None:
    from scipy.io import wavfile

    wavfile.write(file, int(RATE), (np.column_stack([arrays["base"], arrays["top"]]) * 3000).astype(np.int16))


def _mat(file: Path, arrays: dict[str, Any]) -> None:
    from scipy.io import savemat

    savemat(file, {**arrays, "fs": RATE, "units": {"base": "m/s^2", "top": "m/s^2"}})


def _mat_packed(file: Path, arrays: dict[str, Any]) -> None:
    from scipy.io import savemat

    savemat(file, {**arrays, "fs": RATE}, do_compression=True)


def _h5(file: Path, arrays: dict[str, Any]) -> None:
    import h5py

    with h5py.File(file, "w") as opened:
        opened.attrs["sampling_rate"] = RATE
        for name, values in arrays.items():
            opened[name] = values
            opened[name].attrs["units"] = "Hz" if name == "frequency" else "1"


def _h5_packed(file: Path, arrays: dict[str, Any]) -> None:
    import h5py

    with h5py.File(file, "w") as opened:
        opened.attrs["sampling_rate"] = RATE
        for name, values in arrays.items():
            opened.create_dataset(name, data=values, chunks=True, compression="gzip", fletcher32=True)


def _tdms(file: Path, arrays: dict[str, Any]) -> None:
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(file)) as writer:
        objects = [ChannelObject("rig", name, data, {"wf_increment": 1 / RATE}) for name, data in arrays.items()]
        writer.write_segment(objects)


def _uff(file: Path, arrays: dict[str, Any], binary: int = 1) -> None:
    import pyuff

    sets = [
        pyuff.prepare_58(
            binary=binary, func_type=1, id1=name, rsp_node=i, rsp_dir=3, ref_node=1, ref_dir=3, data=data,
            x=np.arange(len(data)) / RATE, ord_data_type=4, num_pts=len(data), abscissa_spacing=1, abscissa_min=0.0,
            abscissa_inc=1.0 / RATE, abscissa_spec_data_type=17, ordinate_spec_data_type=12, orddenom_spec_data_type=0,
            ordinate_axis_units_lab="m/s^2",
        )
        for i, (name, data) in enumerate(arrays.items(), start=1)
    ]  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ResourceWarning)  # pyuff opens the file twice for binary data
        pyuff.UFF(str(file)).write_sets(sets, mode="add")
        gc.collect()


def _uff_text(file: Path, arrays: dict[str, Any]) -> None:
    _uff(file, arrays, binary=0)


Writer = Callable[[Path, dict[str, Any]], None]
FORMATS: dict[str, tuple[str, Writer, bool]] = {  # suffix, writer, whether it holds spectra, too
    "npz": ("npz", _npz, True),
    "npz, compressed": ("npz", _npz_packed, True),
    "CSV": ("csv", _csv, True),
    "WAV, float": ("wav", _wav, False),
    "WAV, 16 bits": ("wav", _wav_short, False),
    "MAT v5": ("mat", _mat, True),
    "MAT v5, compressed": ("mat", _mat_packed, True),
    "HDF5": ("h5", _h5, True),
    "HDF5, fletcher32": ("h5", _h5_packed, True),
    "UFF, binary": ("uff", _uff, False),
    "UFF, text": ("uff", _uff_text, False),
    "TDMS": ("tdms", _tdms, False),
}


def spoilt(content: bytes, rng: np.random.Generator) -> bytes:
    """Return a file's content with bits flipped, a piece lost or doubled, or cut short; headers more often."""
    raw = bytearray(content)
    at = int(rng.integers(len(raw)))
    match int(rng.integers(10)):
        case 0:
            return bytes(raw[:at])
        case 1:
            return bytes(raw[:at] + raw[at + int(rng.integers(1, 64)) :])
        case 2:
            return bytes(raw[:at] + raw[max(0, at - 16) :])
        case 3:
            size = int(rng.integers(1, 512))
            raw[at : at + size] = bytes(len(raw[at : at + size]))
            return bytes(raw)
    heads = rng.random() < 0.5
    for _ in range(int(rng.choice([1, 1, 2, 4]))):
        at = int(rng.integers(min(len(raw), 1500))) if heads else int(rng.integers(len(raw)))
        raw[at] ^= 1 << int(rng.integers(8)) if rng.random() < 0.7 else 0xFF
    return bytes(raw)


class FlipTarget:
    """Spoiled files of a format by their number, signals and spectra in turn."""

    def __init__(self, name: str, folder: Path, seed: int) -> None:
        self.suffix, self.write, both = FORMATS[name]
        self.folder, self.seed = folder, seed
        self.kinds = [_signals(), _spectra()] if both else [_signals()]
        self.contents, self.truths = [], []
        for i, arrays in enumerate(self.kinds):
            file = folder / f"sound{i}.{self.suffix}"
            self.write(file, arrays)
            self.contents.append(file.read_bytes())
            self.truths.append(self._read(file, i))

    def _read(self, file: Path, which: int) -> list[tuple[str, Any]]:
        if which:
            table = read_spectra(file)
            columns = table.numbers(range(len(table.headers))) if table.headers else {}
            return [(header.text, columns[i]) for i, header in enumerate(table.headers)]
        channels = read_channels(file).channels
        return [(f"{c.name} {c.sampling_rate}", c.samples) for c in channels]

    def content(self, index: int) -> tuple[int, bytes]:
        """Return which content is spoiled, and the spoiled bytes."""
        which = index % len(self.kinds)
        return which, spoilt(self.contents[which], np.random.default_rng([self.seed, index]))

    def __call__(self, index: int) -> Outcome:
        which, content = self.content(index)
        file = self.folder / own(f"spoilt.{self.suffix}")
        file.write_bytes(content)
        return tried(lambda: self._compared(file, which))

    def _compared(self, file: Path, which: int) -> str:
        read, truth = self._read(file, which), self.truths[which]
        if not which:
            _judge(file, dict(read))
        same = len(read) == len(truth) and all(
            a == b and np.array_equal(x, y, equal_nan=True) for (a, x), (b, y) in zip(read, truth, strict=True)
        )
        return PASSED if same else DIFFERENT


def _judge(file: Path, channels: dict[str, Any]) -> None:
    """Look at signals as a campaign does before it is fitted."""
    arrays = list(channels.values())
    if len(arrays) < 2 or arrays[0].shape != arrays[1].shape:
        return
    try:
        raw = Recording(arrays[0], arrays[1], RATE)
        recordings = {500.0: without_disturbances(raw, 500.0, 10.0)[0]}
    except InputError as error:
        raise InputError([problem.at(file) for problem in error.problems]) from None
    if findings := check_configuration(recordings, cycles=10.0):
        raise InputError([Problem(finding.message, file=file) for finding in findings])
