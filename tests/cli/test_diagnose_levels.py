"""``multilayer diagnose`` of walls and their measured transmission loss."""

import json

import numpy as np
import pytest

from multilayer.config import dump_yaml
from multilayer.response import diffuse_field
from multilayer.response.bands import band_points
from multilayer.stack import Stack
from tests.cli.command import run
from tests.diagnosis.walls import BANDS, BOARD

FILE = """kind: diagnose
version: 1
nominal: wall.yaml
measurements:
  - {kind: transmission_loss, file: wall.csv, bands: third octaves, incidence: diffuse}
unknowns:
  layers.board.density: {normal: [700 kg/m^3, 7 kg/m^3]}
effects: [receiving_absorption, leak]
uncertainty: repeatability
search: {candidates: 4, starts: 1}
"""


def loss():
    """Return the loss of a board in third octaves, dB, of which 4 dB are missing by area or calibration."""
    board = Stack.model_validate({"version": 1, "layers": [BOARD], "termination": "ambient"})
    points = band_points(BANDS)
    share = diffuse_field(board, points.ravel()).transmission_coefficient.reshape(points.shape)
    return -10 * np.log10(share.mean(axis=1)) - 4


def write(folder, text=FILE, termination="ambient"):
    folder.mkdir(exist_ok=True)
    rows = "".join(f"{f:g},{value:.2f}\n" for f, value in zip(BANDS, loss(), strict=True))
    (folder / "wall.csv").write_text(f"frequency_hz,transmission_loss_db\n{rows}")
    (folder / "wall.yaml").write_text(dump_yaml({"version": 1, "layers": [BOARD], "termination": termination}))
    (folder / "why.yaml").write_text(text)
    return folder / "why.yaml"


def test_it_writes_record_report_and_figures(tmp_path):
    out = tmp_path / "out"
    done = run("diagnose", write(tmp_path / "wall"), "--out", out)
    assert done.status == 0, done.err
    record = json.loads((out / "diagnosis.json").read_text())
    assert record["group"][:1] == [["receiving_absorption"]]
    assert record["inputs"]["noise"] == {"transmission_loss wall": "ISO 12999-1, repeatability"}
    assert "construction, field or reading" in done.out
    names = {path.name for path in out.glob("*.png")}
    assert names >= {"where.png", "causes.png", "place.png", "before_after-transmission_loss_wall.png"}


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("uncertainty: repeatability", "uncertainty: guessed"), "uncertainty"),
        (("[receiving_absorption, leak]", "[rear_air_gap]"), "of levels there are"),
        (("bands: third octaves", "bands: octaves"), "octaves"),
    ],
)
def test_mistakes_are_told_with_their_place(tmp_path, change, told):
    path = write(tmp_path / "wall", FILE.replace(*change))
    done = run("diagnose", path, "--out", tmp_path / "out")
    assert done.status == 2
    assert "why.yaml:" in done.err
    assert told in done.err
    assert not (tmp_path / "out").exists()


def test_nothing_gets_through_a_rigid_wall(tmp_path):
    done = run("diagnose", write(tmp_path / "wall", termination="rigid"))
    assert done.status == 2
    assert "termination: ambient" in done.err
