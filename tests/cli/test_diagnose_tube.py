"""``multilayer diagnose`` of stacks and their tube measurements."""

import json

import numpy as np
import pytest

from multilayer.config import dump_yaml
from tests.cli.command import run
from tests.diagnosis.tubes import F, foam, reflection, table

FILE = """version: 1
nominal: foam.yaml
measurements:
  - {kind: reflection, file: tube.csv, noise: {absolute: 0.002}}
unknowns:
  layers.foam.flow_resistivity: {lognormal: [11 kN s/m^4, 0.1]}
effects: [rear_air_gap, sample_position]
search: {candidates: 8, starts: 1}
"""


def write(folder, text=FILE, r=None, **stack):
    folder.mkdir(exist_ok=True)
    r = reflection(0.03, {"rear_air_gap": {"depth": 0.02}}) if r is None else r
    (folder / "tube.csv").write_text(table(r))
    (folder / "foam.yaml").write_text(dump_yaml({**foam(0.03), **stack}))
    (folder / "why.yaml").write_text(text)
    return folder / "why.yaml"


@pytest.fixture(scope="module")
def diagnosed(tmp_path_factory):
    path = write(tmp_path_factory.mktemp("tube") / "foam")
    out = path.parent / "out"
    return run("diagnose", path, "--out", out), out


def test_it_writes_record_report_and_figures(diagnosed):
    done, out = diagnosed
    record = json.loads((out / "diagnosis.json").read_text())
    assert done.status == 0, done.err
    assert (record["verdict"], record["group"]) == ("effect", [["rear_air_gap"]])
    assert record["sentence"] in " ".join(done.out.split())
    assert record["inputs"]["file"] == "why"
    html = (out / "report.html").read_text()
    assert "Re R" in html
    assert "rear air gap" in html
    assert {path.name for path in out.glob("*.png")} >= {"where.png", "causes.png", "before_after-reflection_tube.png"}


def test_what_is_left_out_is_not_blamed(tmp_path):
    path = write(tmp_path / "foam")
    done = run(
        "diagnose",
        path,
        "--without",
        "rear_air_gap",
        "--no-figures",
        "--json",
        "--exit-code",
        "--out",
        tmp_path / "out",
    )
    record = json.loads(done.out)
    assert done.status == 1  # there is a gap
    assert record["verdict"] in ("unknown", "effect")
    assert all("rear_air_gap" not in cause["effects"] for cause in record["causes"])
    assert not list((tmp_path / "out").glob("*.png"))


def test_noise_that_is_not_said_is_estimated_and_told(tmp_path):
    text = FILE.replace(", noise: {absolute: 0.002}", "")
    done = run("diagnose", write(tmp_path / "foam", text), "--no-figures", "--out", tmp_path / "out")
    assert done.status == 0
    assert "warning: reflection tube: no noise is said; estimated" in " ".join(done.err.split())


LAW = "{law: table, file: moduli.csv}"
BAD = {
    "an effect of the rig": ("sample_position]", "sensor_mass]", "why.yaml:7:", "is an effect of the two-plate rig"),
    "no such effect": ("sample_position]", "rear_gap]", "why.yaml:7:", "did you mean 'rear_air_gap'?"),
    "effects of a tube with levels": (
        "kind: reflection",
        "kind: absorption, columns: {value: reflection_re}",
        "why.yaml:7:",
        "of levels there are",
    ),
    "normalised, yet in Pa s/m": (
        "kind: reflection",
        "kind: surface_impedance, normalised: true, columns: {real: 'z_re [Pa*s/m]', imag: 'z_im [Pa*s/m]'}",
        "tube.csv:1:",
        "Pa*s/m",
    ),
    "an impedance as a reflection": (
        "kind: reflection",
        "kind: reflection, columns: {real: z_re, imag: z_im}",
        "why.yaml:4:",
        "these are no reflection coefficients",
    ),
    "normalised by its numbers": (
        "kind: reflection",
        "kind: surface_impedance, normalised: true, columns: {real: z_re, imag: z_im}",
        "why.yaml:4:",
        "if it is in Pa s/m, say 'normalised: false'",
    ),
    "in Pa s/m by its numbers, which are not": (
        "kind: reflection",
        "kind: surface_impedance, normalised: false, columns: {real: 'reflection_re [Pa*s/m]', "
        "imag: 'reflection_im [Pa*s/m]'}",
        "why.yaml:4:",
        "say 'normalised: true'",
    ),
    "too few frequencies": ("file: tube.csv", "file: tube.csv, from: 1500", "why.yaml:4:", "too few for a diagnosis"),
    "tube": ("effects:", "tube: {diameter: 3 kg}\neffects:", "why.yaml:7:", "diameter"),
}


@pytest.mark.parametrize("case", BAD)
def test_a_mistake_is_told_with_its_line(tmp_path, case):
    old, new, place, words = BAD[case]
    path = write(tmp_path / "foam", FILE.replace(old, new))
    r = reflection(0.03, {})
    z = 413 * (1 + r) / (1 - r)
    columns = np.stack([F, r.real, r.imag, z.real, z.imag], axis=1).tolist()
    rows = [",".join(map(repr, row)) for row in columns]
    path.with_name("tube.csv").write_text("\n".join(["frequency_hz,reflection_re,reflection_im,z_re,z_im", *rows, ""]))
    done = run("diagnose", path, "--out", tmp_path / "out")
    told = " ".join(done.err.split())
    assert done.status == 2, told
    assert place in told
    assert words in told
    assert not (tmp_path / "out").exists()


def test_a_stack_without_a_response_at_these_frequencies_is_refused(tmp_path):
    f = np.array([300.0, 500.0])
    plate = {
        "type": "elastic_plate", "name": "plate", "thickness": 1e-3, "density": 1000.0, "poisson_ratio": 0.3,
        "young_modulus": {"law": "table", "frequency": f.tolist(), "storage_modulus": [1e9, 2e9],
                          "loss_modulus": [1e8, 1e8]},
    }  # fmt: skip
    path = write(tmp_path / "foam", layers=[plate, *foam(0.03)["layers"]])
    done = run("diagnose", path, "--out", tmp_path / "out")
    assert done.status == 2
    assert "the modulus table holds 300 to 500 Hz" in " ".join(done.err.split())
    assert "why.yaml:4:" in done.err


def test_the_law_of_campaigns_is_refused(tmp_path):
    done = run("diagnose", write(tmp_path / "foam"), "--law", "zener", "--out", tmp_path / "out")
    assert done.status == 2
    assert "--law is of campaigns" in done.err
