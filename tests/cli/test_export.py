"""``multilayer export`` as a user types it."""

import json

import numpy as np
import pytest

from multilayer.exchange.nastran import FRAME_DENSITIES
from multilayer.exchange.quantities import KINDS
from multilayer.measurements.readers import read_spectra
from multilayer.response import plane_wave
from multilayer.response.ports import FACE_KINDS
from multilayer.simulation.file import load_simulation
from tests.cli.command import run

STACK = """\
kind: simulation
version: 1
layers:
  - {type: equivalent_fluid, name: "=wool", model: jca, thickness: 50 mm, porosity: 0.98, flow_resistivity: 15000,
     tortuosity: 1.05, viscous_length: 100 um, thermal_length: 250 um}
termination: rigid
frequency: [200, 500, 1000]
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "wool.yaml"
    path.write_text(STACK)
    return path


def test_a_table_is_written_and_read_back(file, tmp_path):
    out = tmp_path / "z.csv"
    done = run("export", file, "--as", "surface_impedance", "--angle", "30", "--out", out)
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("surface_impedance at 3 frequencies\n")
    assert done.out.endswith(f"written to {out}\n")
    table = read_spectra(out)
    real, imaginary = (table.numbers([2, 3])[i] for i in (2, 3))
    expected = plane_wave(load_simulation(file).stack, [200, 500, 1000], 30).surface_impedance
    np.testing.assert_allclose(real + 1j * imaginary, expected, rtol=1e-10)


def test_json_says_what_was_written(file, tmp_path):
    done = run("export", file, "--as", "absorption", "--angle", "0,45 deg", "--out", tmp_path / "a.mat", "--json")
    record = json.loads(done.out)
    assert record["directions"] == [0, 45]
    assert {key: record[key] for key in ("version", "kind", "values", "frequencies", "along")} == {
        "version": 1, "kind": "absorption", "values": ["absorption"], "frequencies": 3, "along": "angle",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("--as", "impedance", "--out", "z.csv"), "there is no table 'impedance'; did you mean"),
        (("--as", "absorption", "--out", "z.xlsx"), "z.xlsx: no table is written as '.xlsx'; allowed: .csv"),
        (("--as", "absorption", "--out", "z.csv", "--angle", "0,x"), "--angle: 'x' is no number"),
        (("--as", "absorption", "--out", "z.csv", "--angle", "95"), "an angle lies outside the range"),
        (("--as", "absorption", "--out", "z.csv", "--angle", "0", "--trace-wavenumber", "1"), "give one of them"),
        (("--as", "surface_impedance", "--out", "z.csv", "--trace-wavenumber", "-1"), "wavenumber is negative"),
        (("--as", "transmission_loss", "--out", "z.csv"), "needs a half-space behind the stack"),
    ],
)  # fmt: skip
def test_mistakes_end_with_status_2_and_nothing_is_written(file, tmp_path, options, told):
    done = run("export", file, *options, cwd=tmp_path)
    assert done.status == 2
    assert told in done.err
    assert "Traceback" not in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["wool.yaml"]


WALL = STACK.replace("rigid", "ambient") + "area: 10\nbeside: [{type: slit, width: 1 mm, length: 1 m, depth: 50 mm}]\n"
PLATE = "{{type: elastic_plate, name: {}, thickness: 12 mm, density: 800, young_modulus: 2 GPa, poisson_ratio: 0.3}}"
LINKED = (
    STACK.replace("rigid", "ambient")
    .replace("layers:\n", f"layers:\n  - {PLATE.format('front')}\n")
    .replace(
        "termination",
        f"  - {PLATE.format('back')}\nlinks: [{{kind: line, between: [front, back], spacing: 0.6}}]\ntermination",
    )
)


@pytest.mark.parametrize("text", [WALL, LINKED])
@pytest.mark.parametrize("kind", [name for name, kind in KINDS.items() if kind.at_faces])
def test_a_wall_as_built_has_no_table_at_its_faces(file, tmp_path, kind, text):
    file.write_text(text)
    done = run("export", file, "--as", kind, "--out", "z.csv", cwd=tmp_path)
    assert done.status == 2
    assert f"a wall with openings or links has no one {kind}; leave out 'beside' and 'links'" in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["wool.yaml"]
    assert run("export", file, "--as", "absorption", "--out", "a.csv", cwd=tmp_path).status == 0


FOAM = STACK.replace("equivalent_fluid", "poroelastic").replace(
    "thermal_length: 250 um", "thermal_length: 250 um, frame_density: 30, young_modulus: 100 kPa, poisson_ratio: 0.3"
)
CARDS = ("--as", "nastran", "--out", "foam.bdf")


def test_cards_are_written_where_the_density_is_said(file, tmp_path):
    file.write_text(FOAM)
    done = run("export", file, *CARDS, "--frame-density", "solid", "--first-id", "20", cwd=tmp_path)
    assert (done.status, done.err) == (0, "")
    assert done.out.startswith("MATPE1, MAT1, MAT10\n")
    assert "MAT1*                 21 1.000000000E+05" in (tmp_path / "foam.bdf").read_text()


@pytest.mark.parametrize(
    ("text", "options", "told"),
    [
        (FOAM, CARDS, "--frame-density: is missing; say what your program takes as RHO of the frame's MAT1: solid"),
        (FOAM, (*CARDS, "--frame-density", "dense"), "--frame-density: 'dense' is not allowed; say what"),
        (FOAM, (*CARDS, "--frame-density", "bulk", "--angle", "0"), "cards have no direction and no faces"),
        (FOAM, (*CARDS, "--frame-density", "bulk", "--front", "plate"), "cards have no direction and no faces"),
        (FOAM, ("--as", "nastran", "--out", "z.csv"), "z.csv: cards are not written as '.csv'; allowed: .bdf"),
        (FOAM, ("--as", "absorption", "--out", "z.csv", "--frame-density", "bulk"), "belong to cards"),
        (STACK, (*CARDS, "--frame-density", "bulk"), "wool.yaml:4:3: layers: no layer is poroelastic"),
        (FOAM.replace("model: jca,", "model: jcal, thermal_permeability: 1e-9,"), (*CARDS, "--frame-density", "bulk"),
         "wool.yaml:4:47: layers.0.model: 'jcal' has no card"),
    ],
)  # fmt: skip
def test_mistakes_with_cards(file, tmp_path, text, options, told):
    file.write_text(text)
    done = run("export", file, *options, cwd=tmp_path)
    assert done.status == 2
    assert told in done.err
    assert [path.name for path in tmp_path.iterdir()] == ["wool.yaml"]


def test_mistakes_of_the_file_are_placed(tmp_path):
    file = tmp_path / "wrong.yaml"
    file.write_text(STACK.replace("50 mm", "50 kg"))
    done = run("export", file, "--as", "absorption", "--out", tmp_path / "a.csv")
    assert done.status == 2
    assert "wrong.yaml:4:" in done.err


def test_the_shell_offers_what_there_is():
    from multilayer.cli import completion

    assert completion.exports("") == [*KINDS, "nastran"]
    assert completion.frame_densities("") == [*FRAME_DENSITIES]
    assert completion.faces("") == [*FACE_KINDS]
    assert completion.exports("sea") == ["sea_trim"]
