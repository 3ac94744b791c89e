"""Campaigns with one mistake each, for the page of error messages."""

import shutil
from pathlib import Path

import numpy as np

FOAM = Path(__file__).parents[2] / "examples" / "foam_b"
BURST = "signals/h25mm-t1mm_0500Hz.npz"


def _signals(folder: Path, change) -> None:
    path = folder / BURST
    with np.load(path) as archive:
        arrays = {name: archive[name].copy() for name in archive.files}
    np.savez(path, **(change(arrays) or arrays))


def silent(folder):
    _signals(folder, lambda a: {**a, "top": 0 * a["top"]})


def clipped(folder):
    def clip(a):
        return {**a, "top": np.clip(a["top"], -0.3 * np.abs(a["top"]).max(), 0.3 * np.abs(a["top"]).max())}

    _signals(folder, clip)


def exchanged(folder):
    _signals(folder, lambda a: {**a, "base": a["top"], "top": a["base"]})


def short(folder):
    _signals(folder, lambda a: {name: v[..., :200] if v.ndim else v for name, v in a.items()})


def no_numbers(folder):
    def spoil(a):
        a["base"][..., 7] = np.nan

    _signals(folder, spoil)


def lost(folder):
    (folder / BURST).unlink()


def damaged(folder):
    path = folder / BURST
    path.write_bytes(path.read_bytes()[:500])


def _in_text(folder: Path, old: str, new: str) -> None:
    path = folder / "campaign.yaml"
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def other_rate(folder):
    _in_text(folder, "sampling_rate: 25600", "sampling_rate: 51200")


def other_frequency(folder):
    _in_text(folder, "{frequency: 500,", "{frequency: 550,")


def heavy(folder):
    _in_text(folder, "density: 87", "density: 87 kg")


SPOILED = (silent, clipped, exchanged, short, no_numbers, lost, damaged, other_rate, other_frequency, heavy)


def make_all(folder: Path) -> None:
    """Write every spoiled campaign under its function's name."""
    for spoil in SPOILED:
        campaign = folder / spoil.__name__
        shutil.copytree(FOAM, campaign)
        spoil(campaign)
