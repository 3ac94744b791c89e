"""``multilayer simulate``: what it writes, what it prints, how it ends."""

import csv
import io
import json
import sys

import numpy as np
import pytest
from matplotlib.image import imread

from multilayer.response.plane_wave import plane_wave
from multilayer.stack import load_stack
from tests.cli.command import result_names, run, run_elsewhere
from tests.simulation.files import FOAM, PANEL

SWEEP = """\
frequency: {from: 200 Hz, to: 2 kHz, points: 60}
sweep: {layers.foam.thickness: [20 mm, 40 mm]}
tolerances: {layers.foam.flow_resistivity: 20 %}
samples: 60
"""
TABLES = {"simulation.csv", "simulation.json"}


def strict_json(text):
    def refuse(constant):
        raise ValueError(f"{constant} is no JSON")

    return json.loads(text, parse_constant=refuse)


@pytest.fixture
def written(tmp_path):
    """Give a function that writes a file and returns its path."""

    def write(text, name="foam.yaml"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """Give what the command printed for a sweep, and the folder it wrote."""
    folder = tmp_path_factory.mktemp("simulated")
    (folder / "foam.yaml").write_text(FOAM + SWEEP)
    return run("simulate", folder / "foam.yaml", "--out", folder / "out"), folder / "out"


class TestSweep:
    def test_ends_well(self, simulated):
        done, folder = simulated
        assert (done.status, done.err) == (0, "")
        assert result_names(folder) == TABLES | {"report.html", "absorption.png", "impedance.png", "scatter.png"}

    def test_csv(self, simulated):
        _, folder = simulated
        text = (folder / "simulation.csv").read_text()
        rows = list(csv.DictReader(io.StringIO(text)))
        assert text.startswith("case,frequency_hz,absorption,absorption_p05,absorption_p50,absorption_p95,")
        assert len(rows) == 2 * 60
        stack = load_stack(folder.parent / "foam.yaml")
        for i, thickness in enumerate((20, 40)):
            mine = rows[60 * i : 60 * (i + 1)]
            assert {row["case"] for row in mine} == {f"foam.thickness = {thickness} mm"}
            f = np.array([float(row["frequency_hz"]) for row in mine])
            np.testing.assert_allclose(f, np.geomspace(200, 2000, 60), rtol=1e-8)
            wave = plane_wave(stack.replaced({"layers.foam.thickness": thickness / 1000}), np.geomspace(200, 2000, 60))
            values = {name: np.array([float(row[name]) for row in mine]) for name in mine[0] if name != "case"}
            np.testing.assert_allclose(values["absorption"], wave.absorption, rtol=1e-6)
            np.testing.assert_allclose(values["reflection_im"], wave.reflection.imag, rtol=1e-6)
            low, middle, high = (values[f"absorption_p{percent}"] for percent in ("05", "50", "95"))
            assert np.all((low < middle) & (middle < high))

    def test_json(self, simulated):
        _, folder = simulated
        result = strict_json((folder / "simulation.json").read_text())
        assert result["settings"]["samples"] == 60
        assert [case["values"] for case in result["cases"]] == [
            {"foam.thickness": "20 mm"},
            {"foam.thickness": "40 mm"},
        ]
        assert len(result["cases"][1]["absorption_p95"]) == 60

    @pytest.mark.parametrize("name", ["absorption.png", "impedance.png"])
    def test_figures_show_lines_and_bands(self, simulated, name):
        _, folder = simulated
        picture = (255 * imread(folder / name)[..., :3]).round().astype(int)
        found = {tuple(colour) for colour in np.unique(picture.reshape(-1, 3), axis=0)}
        assert {(0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00)} <= found
        pale = [(204, 227, 240), (247, 223, 204)]  # a fifth of these on white
        assert all(any(np.abs(np.subtract(c, p)).max() <= 1 for c in found) for p in pale)

    def test_table(self, simulated):
        done, folder = simulated
        lines = done.out.splitlines()
        assert lines[0] == "foam: absorption coefficient, averages over third octaves"
        assert lines[1].split() == ["foam.thickness", "20", "mm", "40", "mm"]
        bands = [int(line.split()[0]) for line in lines[3:] if line.lstrip()[:1].isdecimal()]
        assert bands == [200, 250, 315, 400, 500, 630, 800, 1000, 1250, 1600, 2000]
        tables = "simulation.csv, simulation.json, report.html"
        assert lines[-1] == f"written to {folder}: {tables}, absorption.png, impedance.png, scatter.png"

    def test_where_the_scatter_comes_from(self, simulated):
        done, folder = simulated
        _, _, below = done.out.partition("Where the scatter of the absorption coefficient comes from")
        fields = [line.split()[0] for line in below.splitlines()[2:-1]]
        columns = (folder / "simulation.csv").read_text().partition("\n")[0].split(",")
        assert fields
        assert {f"absorption_sd_from_{path}" for path in fields} <= {*columns}


class TestOptions:
    def test_json_alone_on_standard_output(self, written, tmp_path):
        done = run("simulate", written(FOAM), "--out", tmp_path / "out", "--json", "--no-figures")
        assert (done.status, done.err) == (0, "")
        assert strict_json(done.out) == strict_json((tmp_path / "out" / "simulation.json").read_text())
        assert result_names(tmp_path / "out") == TABLES

    def test_results_folder_is_named_after_the_file(self, written, tmp_path):
        written(FOAM)
        assert run("simulate", "foam.yaml", "--no-figures", cwd=tmp_path).status == 0
        assert result_names(tmp_path / "results" / "foam") == TABLES

    def test_jobs(self, written, tmp_path):
        file = written(FOAM + SWEEP)
        one, two = (
            run("simulate", file, "--out", tmp_path / n, "--no-figures", "--jobs", n, "--json") for n in ("1", "2")
        )
        assert one == two
        assert (two.status, two.err) == (0, "")

    def test_many_cases_stand_below_each_other(self, written, tmp_path):
        thicknesses = ", ".join(f"{n} mm" for n in range(10, 30))
        file = written(f"{FOAM}sweep: {{layers.foam.thickness: [{thicknesses}]}}\n")
        done = run("simulate", file, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert done.out.splitlines()[1].split()[:3] == ["case", "125", "Hz"]
        assert sum(line.startswith("foam.thickness = ") and "NRC" not in line for line in done.out.splitlines()) == 20

    def test_panel(self, written, tmp_path):
        written(PANEL, "bare.yaml")
        text = f"{PANEL}frequency: {{third_octaves: [100, 5000]}}\nincidence: diffuse\nreference: bare.yaml\n"
        done = run("simulate", written(text, "panel.yaml"), "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        figures = {"report.html", "absorption.png", "transmission_loss.png", "insertion_loss.png"}
        assert result_names(tmp_path / "out") == TABLES | figures
        assert "panel: transmission loss / dB, averages over third octaves" in done.out
        assert "Rw (C; Ctr) " in done.out
        assert "STC " in done.out

    def test_octaves(self, written, tmp_path):
        file = written(FOAM + "frequency: {octaves: [125 Hz, 4 kHz]}\n")
        done = run("simulate", file, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        lines = done.out.splitlines()
        assert lines[0] == "foam: absorption coefficient, averages over octaves"
        assert [line.split()[0] for line in lines[2:-2]] == ["125", "250", "500", "1000", "2000", "4000"]
        assert lines[-2].startswith("alpha_w ")
        assert "NRC" not in done.out
        assert result_names(tmp_path / "out") == TABLES | {"report.html", "absorption.png"}
        result = strict_json((tmp_path / "out" / "simulation.json").read_text())
        assert (result["bands"], result["frequency_hz"]) == ("octaves", [125, 250, 500, 1000, 2000, 4000])
        assert result["settings"]["frequency"] == {"octaves": [125, 4000]}

    @pytest.mark.parametrize("label", ["_a [/b] [red]", "50 $ or $ 60_{", "泡沫 %s"])
    def test_names_are_taken_to_the_letter(self, written, tmp_path, label):
        file = written(f"{FOAM}sweep: {{layers.foam.name: ['{label}', foam]}}\n")
        done = run("simulate", file, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        assert label in done.out


class TestElsewhere:
    """In a process of its own, as the console script runs."""

    def test_json_with_processes(self, written, tmp_path):
        options = ("--out", tmp_path / "out", "--json", "--no-figures", "--jobs", "2")
        done = run_elsewhere("simulate", written(FOAM + SWEEP), *options, PYTHONWARNINGS="error")
        assert (done.status, done.err) == (0, "")
        assert len(strict_json(done.out)["cases"]) == 2

    def test_a_pipe_without_greek_letters(self, written, tmp_path):
        options = ("--out", tmp_path / "out", "--no-figures")
        done = run_elsewhere("simulate", written(FOAM), *options, PYTHONIOENCODING="ascii")
        assert (done.status, done.err) == (0, "")


MIKI = """\
version: 1
layers: [{type: equivalent_fluid, name: wool, model: miki, thickness: 50 mm, flow_resistivity: 20e3}]
termination: rigid
"""


class TestWarnings:
    @pytest.mark.parametrize("jobs", ["1", "2"])
    def test_outside_the_range_of_a_model(self, written, tmp_path, jobs):
        file = written(f"{MIKI}frequency: [50, 1000]\nsweep: {{layers.wool.thickness: [50 mm, 80 mm]}}\n")
        done = run("simulate", file, "--out", tmp_path / "out", "--no-figures", "--jobs", jobs)
        assert done.status == 0
        (line,) = done.err.splitlines()
        assert line.startswith("warning: ")
        assert "50 Hz" in line

    def test_inside(self, written, tmp_path):
        done = run("simulate", written(f"{MIKI}frequency: [1000]\n"), "--out", tmp_path / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")


MISTAKES = {
    "frequency": ("frequency: [0 Hz]", "15:13: frequency.0: 0.0 is not allowed: it must be above 0"),
    "negative frequency": ("frequency: {from: -10 Hz}", "15:19: frequency.from: -10.0 is not allowed"),
    "angle": (
        "incidence: 90",
        "15:12: incidence: 90 is not allowed; allowed: normal, an angle in degrees from 0",
    ),
    "path": (
        "sweep: {layers.foam.thicknes: [1 mm]}",
        "15:9: sweep.layers.foam.thicknes: there is no such field; did",
    ),
    "unit": ("sweep: {layers.foam.thickness: [1 s]}", "15:33: sweep.layers.foam.thickness.0: '1 s' has the wrong unit"),
    "contact": ("contacts: [{between: [foam, lid], kind: slip}]", "15:22: contacts.0.between: there is no layer 'lid'"),
    "no neighbours": ("contacts: [{between: [foam, foam], kind: slip}]", "foam and foam are no neighbours"),
    "kind of contact": (
        "contacts: [{between: [foam, termination], kind: glue}]",
        "'glue' is not allowed; allowed:",
    ),
}


class TestBadInput:
    @pytest.mark.parametrize("name", MISTAKES)
    def test_is_told_once_at_its_place(self, written, tmp_path, name):
        line, words = MISTAKES[name]
        file = written(f"{FOAM}{line}\n")
        done = run("simulate", file, "--out", tmp_path / "out")
        assert (done.status, done.out) == (2, "")
        (told,) = done.err.splitlines()
        assert told.startswith(str(file))
        assert words in told
        assert not (tmp_path / "out").exists()
        assert run("check", file).err == done.err

    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (("--jobs", "0"), "--jobs: 0 is not allowed; it must be at least 1"),
            (("--jobs", "2", "--cluster", "127.0.0.1:8786"), "--jobs and --cluster exclude each other"),
            (("--cluster", "nowhere"), "'nowhere' is no address of a scheduler"),
        ],
    )
    def test_options(self, written, tmp_path, options, words):
        if "nowhere" in options:
            pytest.importorskip("distributed")
        done = run("simulate", written(FOAM), "--out", tmp_path / "out", *options)
        assert (done.status, done.out) == (2, "")
        assert words in done.err
        assert not (tmp_path / "out").exists()

    def test_cluster_without_distributed(self, written, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "distributed", None)
        done = run("simulate", written(FOAM), "--out", tmp_path / "out", "--cluster", "127.0.0.1:8786")
        assert done.status == 2
        assert "pip install 'multilayer[cluster]'" in done.err

    def test_no_such_file(self, tmp_path):
        done = run("simulate", tmp_path / "foam.yaml")
        assert done.status == 2
        assert "foam.yaml: there is no such file" in done.err

    def test_folder_that_cannot_be_written_to(self, written, tmp_path):
        (tmp_path / "taken").write_text("")
        done = run("simulate", written(FOAM), "--out", tmp_path / "taken" / "out")
        assert done.status == 2
        assert "choose another folder with --out" in done.err


class TestCheck:
    def test_says_what_it_is(self, written):
        done = run(
            "check", written(FOAM), written(FOAM + SWEEP, "sweep.yaml"), written(FOAM + "samples: 5\n", "one.yaml")
        )
        assert (done.status, done.err) == (0, "")
        said = [line.partition(": ")[2] for line in done.out.splitlines()]
        assert said == [
            f"a {what} without mistakes" for what in ("stack", "simulation of 2 cases", "simulation of one case")
        ]


@pytest.mark.parametrize("command", ["simulate", "compare"])
def test_help(command):
    done = run(command, "--help")
    assert (done.status, done.err) == (0, "")
    assert f"Usage: multilayer {command}" in done.out
    assert f"Example: multilayer {command}" in done.out
    assert "Exit status: 0 done" in " ".join(done.out.split())
