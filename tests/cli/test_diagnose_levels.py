"""``multilayer diagnose`` of walls and their measured transmission loss."""

import json

import pytest

from multilayer.config import dump_yaml
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
# of the board above, third octaves, infinite, to 78 degrees; 6 dB are missing by area or calibration
LOSS = [13.2, 15.1, 17.0, 18.6, 20.7, 22.4, 24.4, 26.4, 28.3, 30.2, 32.1, 33.7, 34.6, 35.2, 32.6, 23.5]


def write(folder, text=FILE, termination="ambient"):
    folder.mkdir(exist_ok=True)
    rows = "".join(f"{f:g},{loss - 6:g}\n" for f, loss in zip(BANDS, LOSS, strict=True))
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
    assert record["inputs"]["noise"] == {"transmission_loss wall": "ISO 12999, repeatability"}
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
