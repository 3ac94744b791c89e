"""Walls of several paths, from files and on the command line."""

import json

import numpy as np
import pytest

from multilayer import load_simulation, load_stack, simulate
from multilayer.stack import Stack
from tests.cli.command import run
from tests.simulation.files import FOAM, PANEL

BESIDE = """\
area: 10 m2
beside:
  - type: patch
    name: door
    area: 2 m2
    stack:
      layers: [{material: Bauakustik/T4.2.4-1/glass, name: pane, thickness: 6 mm}]
      termination: ambient
  - {type: slit, name: sill, width: 2 mm, length: 90 cm, depth: 40 mm, at_edge: true}
  - {type: flanking, name: floor, transmission_loss: 50 dB}
frequency: {octaves: [125 Hz, 2 kHz]}
"""


@pytest.fixture
def written(tmp_path):
    def write(text, name="wall.yaml"):
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return write


def losses(path):
    return np.array([case.transmission_loss for case in simulate(path).cases])


def test_a_leak_and_a_door_let_more_through(written):
    built, tight = (losses(written(PANEL + text)) for text in (BESIDE, BESIDE.replace("width: 2 mm", "width: 0.1 mm")))
    assert np.all(built < tight)
    assert np.all(built < 50.0)


def test_sweeps_and_tolerances_lead_beside(written):
    more = "sweep: {beside.sill.width: [0.5 mm, 2 mm], area: [10 m2, 20 m2]}\n"
    more += (
        "tolerances: {beside.sill.depth: 20 %, beside.door.stack.layers.pane.thickness: 5 %, layers.gap.thickness: 5 %}"
    )
    result = simulate(written(PANEL + BESIDE + more + "\nsamples: 5\n"))
    assert result.cases[1].label == "beside.sill.width = 0.5 mm, area = 20 m2"
    assert len(result.cases) == 4
    loss = np.array([case.transmission_loss for case in result.cases])
    assert np.all(loss[2] < loss[0])
    assert all(np.all(np.diff(case.percentiles["transmission_loss_db"], axis=0) > 0) for case in result.cases)
    assert "reflection" not in result.cases[0].quantities


def test_patch_by_its_file(written):
    written(PANEL, "panel.yaml")
    text = FOAM.replace("rigid", "ambient") + "area: 4\nbeside: [{type: patch, area: 1, stack: panel.yaml}]\n"
    simulation = load_simulation(written(text))
    assert simulation.beside[0].stack == load_stack(written(PANEL, "panel.yaml"))
    assert type(load_stack(written(text))) is Stack
    assert load_simulation(written(PANEL)).stack == load_stack(written(PANEL))


def test_mistakes_are_placed(written):
    done = run("check", written(PANEL + BESIDE.replace("width: 2 mm", "width: 2 kg")))
    assert done.status == 2
    assert "wall.yaml:15:" in done.err
    assert "wrong unit" in done.err


def test_command_line(written, tmp_path):
    done = run("simulate", written(PANEL + BESIDE), "--json", "--out", tmp_path / "results")
    assert done.status == 0, done.err
    assert json.loads(done.out)["settings"]["beside"][1]["at_edge"] is True


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("area: 10 m2\n", ["wall.yaml:7:7: area: changes nothing, as nothing lies beside the stack"]),
        ("sweep: {area: [10 m2, 20 m2]}\n", ["wall.yaml:7:15: sweep.area: changes nothing, as nothing lies beside"]),
        (BESIDE, []),
        ("area: 10 m2\nsweep: {beside: [[], [{type: slit, width: 1 mm, length: 1 m, depth: 50 mm}]]}\n", []),
    ],
)
def test_an_area_with_nothing_beside_it_is_told(written, text, told):
    done = run("check", written(PANEL + text))
    assert done.status == 0
    assert len(done.err.splitlines()) == len(told)
    assert all(words in done.err for words in told)


def test_a_file_of_dots_has_no_folder_of_its_own(written, tmp_path):
    file = written(PANEL + "frequency: [500]\n", "...yaml")
    done = run("simulate", file, cwd=tmp_path)
    assert (done.status, done.err) == (2, "results/.. is no folder of its own; say --out DIR, or rename the file\n")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["...yaml"]
    assert run("simulate", file, "--out", "out", "--no-figures", cwd=tmp_path).status == 0
