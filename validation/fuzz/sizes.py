"""Files that are too large, or claim to be: told at once, or read in seconds and within a gigabyte."""

from __future__ import annotations

import io
import struct
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np

from multilayer.cli.check import _checked
from multilayer.errors import InputError
from multilayer.measurements.readers import read_channels, read_spectra
from validation.fuzz.watch import PASSED, Outcome, own, tried

_HEAD = "version: 1\ntermination: ambient\n"
Made = Callable[[Path], Path]


def _layers(n: int, extra: str = "") -> str:
    rows = "".join(f"  - {{type: fluid, name: l{i}, thickness: 0.01{extra}}}\n" for i in range(n))
    return f"{_HEAD}layers:\n{rows}"


def _yaml(text: Callable[[], str]) -> Made:
    def make(folder: Path) -> Path:
        file = folder / own("large.yaml")
        file.write_text(text(), encoding="utf-8")
        return file

    return make


def _contacts(n: int) -> str:
    return f"{_layers(n + 1)}contacts:\n" + "".join(
        f"  - {{between: [l{i}, l{i + 1}], kind: bonded}}\n" for i in range(n)
    )


def _aliases() -> str:
    lines = ["a0: &a0 [x, x, x, x, x, x, x, x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 9)}]" for i in range(1, 40)]
    return "\n".join(lines)


def _modulus(text: str) -> str:
    fields = f"thickness: 1 mm, density: 1, poisson_ratio: 0, young_modulus: {text}"
    return f"{_HEAD}layers: [{{type: elastic_plate, {fields}}}]"


def _sweep(cases: int, layers: int) -> str:
    values = ", ".join(f"{0.01 + i * 1e-5:.5f}" for i in range(cases))
    return f"{_layers(layers)}sweep:\n  layers.l0.thickness: [{values}]\n"


TEXTS: dict[str, Callable[[], str]] = {
    "10 000 layers": lambda: _layers(10_000),
    "10 001 layers": lambda: _layers(10_001),
    "50 000 layers": lambda: _layers(50_000),
    "10 000 layers, each with a mistake": lambda: _layers(10_000, ", thicknes: 1"),
    "10 000 layers of one name": lambda: _layers(10_000).replace("name: l", "name: l0 #"),
    "3 000 contacts": lambda: _contacts(3000),
    "100 000 frequencies": lambda: f"{_layers(1)}frequency: [{', '.join(str(100 + i / 10) for i in range(100_000))}]",
    "1 000 000 frequencies": lambda: f"{_layers(1)}frequency: [{', '.join(str(100 + i) for i in range(1_000_000))}]",
    "9 000 cases": lambda: _sweep(9000, 5),
    "9 000 cases of 1 000 layers": lambda: _sweep(9000, 1000),
    "a modulus of 20 000 digits": lambda: _modulus("1" * 20_000),
    "a modulus of 20 000 digits, as text": lambda: _modulus(f"'{'1' * 20_000} Pa'"),
    "a complex modulus of 1 000 digits": lambda: _modulus(f"'{'1' * 1000}+{'2' * 1000}j Pa'"),
    "a name of 1 MB": lambda: f"{_layers(1)}{'a' * 1_000_000}: 1\n",
    "a text of 9 MB": lambda: f"{_layers(1)}note: {'a' * 9_000_000}\n",
    "a text of 20 MB": lambda: f"{_layers(1)}note: {'a' * 20_000_000}\n",
    "nested 100 000 deep": lambda: "[" * 100_000,
    "aliases of aliases": _aliases,
    "100 000 names twice": lambda: _HEAD + "a: 1\n" * 100_000,
    "100 000 unknown names": lambda: _HEAD + "".join(f"a{i}: 1\n" for i in range(99_000)),
    "5 000 unknown names in a layer": lambda: (
        f"{_HEAD}layers:\n  - {{type: fluid, {', '.join(f'a{i}: 1' for i in range(5000))}}}\n"
    ),
    "20 000 tolerances": lambda: (
        f"{_layers(1)}tolerances: {{{', '.join(f'layers.l{i}.thickness: 5 %' for i in range(20_000))}}}"
    ),
    "a line of 9 000 000 brackets": lambda: "[]" * 4_500_000,
}


def _npz_claim(folder: Path) -> Path:
    """An archive whose header claims 8 TB."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (10**12,)})
    return _zipped(folder / "claim.npz", header.getvalue() + bytes(1000))


def _npz_bomb(folder: Path) -> Path:
    """Two gigabytes of zeros in nine megabytes."""
    header = io.BytesIO()
    np.lib.format.write_array_header_1_0(header, {"descr": "<f8", "fortran_order": False, "shape": (125_000_000,)})
    file = folder / "bomb.npz"
    with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive:
        for name in ("base", "top"):
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                entry.write(header.getvalue())
                for _ in range(10):
                    entry.write(bytes(10**8))
    return file


def _zipped(file: Path, content: bytes) -> Path:
    with zipfile.ZipFile(file, "w") as archive:
        for name in ("base", "top"):
            archive.writestr(f"{name}.npy", content)
    return file


def _npz_pickle(folder: Path) -> Path:
    file = folder / "pickle.npz"
    np.savez(file, base=np.array([{}], dtype=object), top=np.zeros(3))
    return file


def _h5_claim(folder: Path) -> Path:
    import h5py

    with h5py.File(folder / "claim.h5", "w") as opened:
        opened.create_dataset("base", shape=(10**12,), dtype="f8", chunks=(10**6,))
    return folder / "claim.h5"


def _h5_bomb(folder: Path) -> Path:
    import h5py

    with h5py.File(folder / "bomb.h5", "w") as opened:
        data = opened.create_dataset("base", shape=(10**9,), dtype="f8", chunks=(10**7,), compression="gzip")
        for i in range(10):
            data[i * 10**7 : (i + 1) * 10**7] = 0
    return folder / "bomb.h5"


def _h5_many(folder: Path) -> Path:
    import h5py

    with h5py.File(folder / "many.h5", "w") as opened:
        for i in range(20_000):
            opened[f"c{i}"] = np.zeros(4)
    return folder / "many.h5"


def _h5_loop(folder: Path) -> Path:
    import h5py

    with h5py.File(folder / "loop.h5", "w") as opened:
        opened.create_group("a")["b"] = h5py.SoftLink("/a")
        opened["c"] = h5py.ExternalLink("/etc/passwd", "/x")
    return folder / "loop.h5"


def _mat_bomb(folder: Path) -> Path:
    """A gigabyte and a half of zeros, compressed, in an array that says so."""
    n = 190_000_000
    flags = struct.pack("<IIII", 6, 8, 6, 0)
    dims = struct.pack("<IIii", 5, 8, 1, n)
    name = struct.pack("<II", 1, 4) + b"base\0\0\0\0"
    pack = zlib.compressobj(1)
    size = len(flags) + len(dims) + len(name) + 8 + 8 * n
    parts = [pack.compress(struct.pack("<II", 14, size) + flags + dims + name + struct.pack("<II", 9, 8 * n))]
    parts += [pack.compress(bytes(10**7)) for _ in range(8 * n // 10**7)]
    packed = b"".join([*parts, pack.flush()])
    head = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<HH", 0x0100, 0x4D49)
    (folder / "bomb.mat").write_bytes(head + struct.pack("<II", 15, len(packed)) + packed)
    return folder / "bomb.mat"


def _mat_claim(folder: Path) -> Path:
    from scipy.io import savemat

    savemat(folder / "claim.mat", {"base": np.zeros(100), "fs": 1.0})
    content = bytearray((folder / "claim.mat").read_bytes())
    at = content.index(struct.pack("<ii", 1, 100))
    content[at : at + 8] = struct.pack("<ii", 2**30, 2**30)
    (folder / "claim.mat").write_bytes(content)
    return folder / "claim.mat"


def _wav_claim(folder: Path) -> Path:
    head = (
        b"RIFF" + struct.pack("<I", 0xFFFFFFF0) + b"WAVEfmt " + struct.pack("<IHHIIHH", 16, 1, 2, 48000, 192000, 4, 16)
    )
    (folder / "claim.wav").write_bytes(head + b"data" + struct.pack("<I", 0xFFFFFF00) + bytes(1000))
    return folder / "claim.wav"


def _wav_channels(folder: Path) -> Path:
    head = b"RIFF" + struct.pack("<I", 262180) + b"WAVEfmt " + struct.pack("<IHHIIHH", 16, 1, 65535, 48000, 1, 65535, 8)
    (folder / "channels.wav").write_bytes(head + b"data" + struct.pack("<I", 4 * 65535) + bytes(4 * 65535))
    return folder / "channels.wav"


def _csv_columns(folder: Path) -> Path:
    n = 50_000
    rows = [",".join(f"c{i}" for i in range(n)), *(",".join(["1"] * n) for _ in range(20))]
    (folder / "columns.csv").write_text("\n".join(rows) + "\n")
    return folder / "columns.csv"


def _csv_rows(folder: Path) -> Path:
    (folder / "rows.csv").write_text("base,top\n" + "1.5,2.5\n" * 2_000_000)
    return folder / "rows.csv"


def _csv_large(folder: Path) -> Path:
    with (folder / "large.csv").open("w") as out:
        out.write("base,top\n")
        for _ in range(50):
            out.write("1.5,2.5\n" * 1_000_000)
    return folder / "large.csv"


def _csv_cell(folder: Path) -> Path:
    (folder / "cell.csv").write_text("base,top\n1,2\n1,2\n" + "1" * 5_000_000 + ",2\n")
    return folder / "cell.csv"


def _uff_claim(folder: Path) -> Path:
    from validation.fuzz.flips import _signals, _uff

    _uff(folder / "claim.uff", _signals())
    content = (folder / "claim.uff").read_bytes().replace(b"      2048", b"2000000000")
    (folder / "claim.uff").write_bytes(content)
    return folder / "claim.uff"


def _tdms_claim(folder: Path) -> Path:
    from validation.fuzz.flips import _signals, _tdms

    _tdms(folder / "claim.tdms", _signals())
    content = (folder / "claim.tdms").read_bytes().replace(struct.pack("<Q", 2048), struct.pack("<Q", 2 * 10**11))
    (folder / "claim.tdms").write_bytes(content)
    return folder / "claim.tdms"


DATA: dict[str, Made] = {
    "npz that claims 8 TB": _npz_claim,
    "npz that unpacks to 2 GB": _npz_bomb,
    "npz with a pickle": _npz_pickle,
    "HDF5 that claims 8 TB": _h5_claim,
    "HDF5 that unpacks to 8 GB": _h5_bomb,
    "HDF5 of 20 000 datasets": _h5_many,
    "HDF5 with loops and links outside": _h5_loop,
    "MAT that unpacks to 1.5 GB": _mat_bomb,
    "MAT that claims 9 EB": _mat_claim,
    "WAV that claims 4 GB": _wav_claim,
    "WAV of 65 535 channels": _wav_channels,
    "CSV of 50 000 columns": _csv_columns,
    "CSV of 2 000 000 rows": _csv_rows,
    "CSV of 400 MB": _csv_large,
    "CSV with a cell of 5 MB": _csv_cell,
    "UFF that claims 8 GB": _uff_claim,
    "TDMS that claims 1 TB": _tdms_claim,
}
NAMES = (*TEXTS, *DATA)


class SizeTarget:
    """Files of all these sizes, by their number in `NAMES`."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def __call__(self, index: int) -> Outcome:
        name = NAMES[index]
        if name in TEXTS:
            file = _yaml(TEXTS[name])(self.folder)
            outcome = tried(lambda: _check(file), file)
        else:
            file = DATA[name](self.folder)
            outcome = tried(lambda: _read(file))
        file.unlink()
        return Outcome(outcome.kind, f"{name}: {outcome.text}") if outcome.failed else outcome


def _check(file: Path) -> str:
    if problems := _checked(file).problems:
        raise InputError(problems)
    return PASSED


def _read(file: Path) -> str:
    try:
        read_channels(file)
    finally:
        if file.suffix in (".npz", ".h5", ".mat", ".csv"):
            read_spectra(file)
    return PASSED
