"""``multilayer fit`` of fields of stacks to measurements of them."""

import csv
import io
import json

import numpy as np
import pytest
from matplotlib.image import imread

from multilayer.response import plane_wave
from multilayer.simulation import simulate
from multilayer.stack import load_stack
from tests.cli.command import run
from tests.fits.stack_fits import IN_A_TUBE, F, changed, noisy, parts, write

R = plane_wave(IN_A_TUBE, F).reflection
TUBE = {"kind": "reflection", "file": "tube.csv", "noise": {"absolute": 0.01}}
UNKNOWNS = {
    "layers.wool.flow_resistivity": {"lognormal": ["10 kN s/m^4", 0.5]},
    "layers.wool.thermal_length": {"lognormal": ["200 um", 0.5]},
    "layers.wool.tortuosity": {"uniform": [1, 2]},
}


def tables(values=R):
    return {"tube.csv": parts("frequency_hz,reflection_re,reflection_im", F, values)}


@pytest.fixture(scope="module")
def fitted(tmp_path_factory):
    folder = tmp_path_factory.mktemp("stack-fit") / "wool"
    folder.mkdir()
    path = write(folder, changed(IN_A_TUBE, wool__flow_resistivity=2e4), tables(noisy(R, 0.01)), [TUBE], UNKNOWNS)
    return run("fit", path, "--out", folder / "out"), folder / "out", path


class TestResults:
    def test_prints_the_values(self, fitted):
        done, folder, _ = fitted
        assert (done.status, done.err) == (0, "")
        lines = done.out.splitlines()
        assert lines[0].startswith("wool: unknowns, with the intervals that hold them at 68 and 90 %")
        row = next(line.split() for line in lines if line.startswith("wool.flow_resistivity"))
        assert float(row[1]) == pytest.approx(1.2e4, rel=0.05)
        assert "N*s/m^4" in row
        assert (
            lines[-1]
            == f"written to {folder}: parameters.csv, curves.csv, fit.json, fitted-nominal.yaml, report.html, "
            "reflection_tube.png"
        )

    def test_parameters(self, fitted):
        _, folder, _ = fitted
        rows = list(csv.DictReader(io.StringIO((folder / "parameters.csv").read_text())))
        assert [row["name"] for row in rows] == list(UNKNOWNS)
        for row in rows:
            numbers = [float(row[name]) for name in ("low_90", "low_68", "value", "high_68", "high_90")]
            assert numbers == sorted(numbers)
            assert (row["determined"], float(row["left_of_prior"]) < 0.5) == ("true", True)

    def test_curves(self, fitted):
        _, folder, _ = fitted
        rows = list(csv.DictReader(io.StringIO((folder / "curves.csv").read_text())))
        columns = {
            name: np.array([float(row[name]) for row in rows])
            for name in rows[0]
            if name not in ("measurement", "unit")
        }
        assert columns["frequency_hz"] == pytest.approx(F)
        difference = columns["predicted_re"] - columns["measured_re"]
        assert columns["residual_re"] == pytest.approx(difference / 0.01, rel=1e-4, abs=1e-6)

    def test_json(self, fitted):
        _, folder, path = fitted
        data = json.loads((folder / "fit.json").read_text())
        assert data["converged"]
        assert data["misfit_per_datum"] == pytest.approx(1, abs=0.4)
        assert np.diag(data["correlation"]) == pytest.approx(1)
        assert data["minima"][0]["values"].keys() == UNKNOWNS.keys()
        assert data["measurements"][0]["n_data"] == 2 * len(F)
        assert data["settings"]["nominal"]["layers"][0]["flow_resistivity"] == 2e4
        done = run("fit", path, "--out", path.parent / "again", "--json", "--no-figures")
        assert json.loads(done.out) == data
        assert not (path.parent / "again" / "reflection_tube.png").exists()

    def test_the_fitted_stack_is_one(self, fitted):
        _, folder, _ = fitted
        layer = load_stack(folder / "fitted-nominal.yaml").layers[0]
        assert layer.flow_resistivity == pytest.approx(1.2e4, rel=0.05)
        assert layer.porosity == 0.97

    def test_figure(self, fitted):
        _, folder, _ = fitted
        picture = (255 * imread(folder / "reflection_tube.png")[..., :3]).round().astype(int)
        assert (0, 0x72, 0xB2) in {tuple(colour) for colour in picture.reshape(-1, 3)}

    def test_check(self, fitted):
        _, _, path = fitted
        done = run("check", path, path.parent)
        assert done.status == 0
        assert done.out.splitlines() == [
            f"{one}: a stack fit of one measurement without mistakes" for one in (path, path.parent)
        ]


def test_remarks(tmp_path):
    """A wrong model, and an unknown that the data do not show."""
    more = {**UNKNOWNS, "layers.wool.porosity": {"normal": [0.97, 1e-4]}}
    path = write(tmp_path, IN_A_TUBE, tables(R + 0.1 * np.sin(F / 30)), [TUBE], more)
    done = run("fit", path, "--out", tmp_path / "out", "--no-figures")
    assert done.status == 0
    assert "the model misses the data by more than noise; intervals are" in done.out
    assert "of these the prior tells as much as the data, or more: wool.porosity" in done.out


def test_what_simulate_writes(tmp_path):
    (tmp_path / "stack.yaml").write_text(
        "layers: [{type: equivalent_fluid, model: miki, name: wool, thickness: 4 cm, flow_resistivity: 1e4}]\n"
        "sweep: {layers.wool.thickness: [2 cm, 4 cm]}\nfrequency: [300, 600, 1200]\ntermination: rigid\n"
    )
    (tmp_path / "sim.csv").write_text(simulate(tmp_path / "stack.yaml").to_csv())
    (tmp_path / "fit.yaml").write_text(
        "nominal: stack.yaml\n"
        "measurements: [{kind: surface_impedance, normalised: true, file: sim.csv, rows: {case: wool.thickness = 3 cm},"
        " noise: 0.01}]\n"
        "unknowns: {layers.wool.flow_resistivity: {lognormal: [2e4, 1]}}\n"
    )
    done = run("fit", tmp_path / "fit.yaml", "--out", tmp_path / "out", "--no-figures")
    assert done.status == 2
    assert "no row has 'wool.thickness = 3 cm' as case; did you mean 'wool.thickness = 4 cm'?" in done.err
    (tmp_path / "fit.yaml").write_text((tmp_path / "fit.yaml").read_text().replace("= 3 cm", "= 4 cm"))
    done = run("fit", tmp_path / "fit.yaml", "--out", tmp_path / "out", "--no-figures")
    assert done.status == 0
    (row,) = csv.DictReader(io.StringIO((tmp_path / "out" / "parameters.csv").read_text()))
    assert float(row["value"]) == pytest.approx(1e4, rel=1e-3)


def test_validity_is_told(tmp_path):
    (tmp_path / "stack.yaml").write_text(
        "layers: [{type: equivalent_fluid, model: miki, name: wool, thickness: 4 cm, flow_resistivity: 4e5}]\n"
    )
    stack = load_stack(tmp_path / "stack.yaml")
    with pytest.warns(UserWarning, match="Miki"):
        wave = plane_wave(stack, F)
    path = write(
        tmp_path, stack, tables(wave.reflection), [TUBE], {"layers.wool.flow_resistivity": {"lognormal": [4e5, 0.1]}}
    )
    done = run("fit", path, "--out", tmp_path / "out", "--no-figures")
    assert done.status == 0
    assert done.err.startswith("warning: Miki holds for f / flow_resistivity")
