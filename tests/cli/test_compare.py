"""``multilayer compare``: measured spectra over predicted ones."""

import csv
import io
import json

import numpy as np
import pytest
from matplotlib.image import imread

from multilayer.response.plane_wave import plane_wave
from multilayer.stack import load_stack
from tests.cli.command import python, run
from tests.recorders import SPECTRA_WRITERS
from tests.simulation.files import FOAM, PANEL

F = np.array([200.0, 500.0, 1000.0, 2000.0])


@pytest.fixture
def foam(tmp_path):
    (tmp_path / "foam.yaml").write_text(FOAM)
    return tmp_path / "foam.yaml"


@pytest.fixture
def measured(tmp_path):
    """Give a function that writes a table and returns its path."""

    def write(text, name="tube.csv"):
        (tmp_path / name).write_text(text)
        return tmp_path / name

    return write


def table(header, *columns):
    rows = [", ".join(f"{value!r}" for value in row) for row in zip(*(map(float, c) for c in columns), strict=True)]
    return "\n".join([header, *rows, ""])


@pytest.fixture
def wave(foam):
    return plane_wave(load_stack(foam), F)


def misfits(folder):
    return json.loads((folder / "comparison.json").read_text())["misfits"]


class TestAbsorption:
    @pytest.fixture
    def compared(self, foam, measured, wave, tmp_path):
        offset = np.array([0.01, -0.02, 0.03, 0.0])
        file = measured(table("frequency_hz, absorption", F[::-1], (wave.absorption + offset)[::-1]))
        return run("compare", foam, file, "--out", tmp_path / "out"), tmp_path / "out"

    def test_prints_the_misfit(self, compared):
        done, folder = compared
        assert (done.status, done.err) == (0, "")
        lines = done.out.splitlines()
        assert lines[0] == "tube over foam: 4 frequencies, 200 to 2000 Hz"
        assert lines[2].split() == ["absorption", "-", "0.0187", "0.03", "1000"]
        names = "comparison.csv, comparison.json, comparison.html, comparison_absorption.png"
        assert lines[-1] == f"written to {folder}: {names}"

    def test_files(self, compared, wave):
        _, folder = compared
        (misfit,) = misfits(folder)
        assert misfit["rms"] == pytest.approx(np.sqrt(14e-4 / 4))
        assert misfit["largest"] == pytest.approx(0.03)
        assert misfit["worst_frequency_hz"] == 1000
        rows = list(csv.DictReader(io.StringIO((folder / "comparison.csv").read_text())))
        assert list(rows[0]) == ["case", "frequency_hz", "absorption_measured", "absorption_predicted"]
        np.testing.assert_allclose([float(row["absorption_predicted"]) for row in rows], wave.absorption, rtol=1e-8)
        assert [float(row["frequency_hz"]) for row in rows] == F.tolist()

    def test_figure(self, compared):
        _, folder = compared
        picture = (255 * imread(folder / "comparison_absorption.png")[..., :3]).round().astype(int)
        assert {(0, 0x72, 0xB2), (0, 0, 0)} <= {tuple(colour) for colour in picture.reshape(-1, 3)}


class TestClosestValues:
    @pytest.fixture
    def compared(self, foam, measured, tmp_path):
        thicker = load_stack(foam).replaced({"layers.foam.thickness": 0.06})
        file = measured(table("frequency_hz, absorption", F, plane_wave(thicker, F).absorption))
        return run("compare", foam, file, "--out", tmp_path / "out"), tmp_path / "out"

    def test_the_field_that_is_wrong_is_told_with_its_value(self, compared):
        done, folder = compared
        assert (done.status, done.err) == (0, "")
        lines = done.out.splitlines()
        first = lines[[line.startswith("One value changed") for line in lines].index(True) + 2]
        assert first.split()[:7] == ["foam.thickness", "absorption", "50", "mm", "60", "mm", "+20.0%"]
        best = json.loads((folder / "comparison.json").read_text())["closest_values"][0]
        assert (best["field"], best["unit"], best["stated"]) == ("foam.thickness", "m", 0.05)
        assert best["value"] == pytest.approx(0.06)
        assert best["deviations"] is None

    def test_the_page_has_the_table(self, compared):
        _, folder = compared
        page = (folder / "comparison.html").read_text()
        assert "If one value were another" in page
        assert "(rms) with foam.thickness of 60 mm in place of 50 mm" in page

    def test_where_no_value_helps_that_is_said(self, foam, measured, tmp_path):
        f = np.linspace(200, 2000, 40)
        rough = plane_wave(load_stack(foam), f).absorption + 0.05 * (-1) ** np.arange(40)
        file = measured(table("frequency_hz, absorption", f, rough))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        told = "No single value of a layer brings the absorption coefficient closer by more than 10%."
        assert done.status == 0
        assert told in done.out

    def test_it_can_be_left_out(self, foam, measured, wave, tmp_path):
        file = measured(table("frequency_hz, absorption", F, wave.absorption + 0.1))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures", "--no-closest-values")
        assert "value" not in done.out
        assert json.loads((tmp_path / "out/comparison.json").read_text())["closest_values"] == []

    def test_a_value_at_the_end_of_the_search_is_told_as_such(self, foam, measured, tmp_path):
        file = measured(table("frequency_hz, absorption", F, 0 * F))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        values = json.loads((tmp_path / "out/comparison.json").read_text())["closest_values"]
        (thickness,) = (value for value in values if value["field"] == "foam.thickness")
        assert thickness["at_limit"]
        assert "≤ 5 mm" in done.out

    def test_several_processes_find_the_same(self, foam, measured, compared, tmp_path):
        _, folder = compared
        thicker = load_stack(foam).replaced({"layers.foam.thickness": 0.06})
        file = measured(table("frequency_hz, absorption", F, plane_wave(thicker, F).absorption))
        assert run("compare", foam, file, "--out", tmp_path / "two", "--no-figures", "--jobs", "2").status == 0
        one, two = (json.loads((at / "comparison.json").read_text()) for at in (folder, tmp_path / "two"))
        assert one == two

    def test_of_several_cases_the_best(self, foam, measured, tmp_path):
        foam.write_text(FOAM + "sweep: {layers.foam.thickness: [20 mm, 52 mm]}\n")
        stack = load_stack(foam).replaced({"layers.foam.thickness": 0.05})
        file = measured(table("frequency_hz, absorption", F, plane_wave(stack, F).absorption))
        assert run("compare", foam, file, "--out", tmp_path / "out", "--no-figures").status == 0
        best = json.loads((tmp_path / "out/comparison.json").read_text())["closest_values"][0]
        assert (best["case"], best["field"]) == ("foam.thickness = 52 mm", "foam.thickness")
        assert best["value"] == pytest.approx(0.05)

    def test_ctrl_c_meanwhile_leaves_the_comparison(self, foam, measured, wave, tmp_path):
        file = measured(table("frequency_hz, absorption", F, wave.absorption + 0.1))
        options = ("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        done = python("-c", STOPPED, *options)
        assert done.status == 130
        assert done.err.startswith("warning: stopped by Ctrl-C: the comparison is written without the values")
        assert f"written to {tmp_path / 'out'}" in done.out
        (misfit,) = misfits(tmp_path / "out")
        assert misfit["rms"] == pytest.approx(0.1)
        record = json.loads((tmp_path / "out" / "comparison.json").read_text())
        assert record["closest_values"] == []
        assert "stopped by Ctrl-C" in record["warnings"][0]


STOPPED = """
import sys
from multilayer.cli import main
from multilayer.simulation import closest_values

def stopping(self):
    raise KeyboardInterrupt

closest_values._Search.__call__ = stopping
sys.argv[0] = "multilayer"
main()
"""


class TestForms:
    @pytest.mark.parametrize(
        ("header", "factors"),
        [
            ("frequency [Hz], absorption", (1, 1)),
            ("f [kHz], alpha [%]", (1e-3, 100)),
            ("f_Hz, Absorption [-]", (1, 1)),
            ('"Frequency (Hz)", "alpha"', (1, 1)),
        ],
    )
    def test_headers(self, foam, measured, wave, tmp_path, header, factors):
        file = measured(table(header, F * factors[0], wave.absorption * factors[1]))
        assert run("compare", foam, file, "--out", tmp_path / "out", "--no-figures").status == 0
        assert misfits(tmp_path / "out")[0]["largest"] < 1e-12

    @pytest.mark.parametrize("separator", [";", "\t"])
    def test_separators_and_comments(self, foam, measured, wave, tmp_path, separator):
        text = "# made in a tube\n\n" + table("frequency_hz, absorption, remark", F, wave.absorption, F)
        file = measured(text.replace(", ", separator))
        assert run("compare", foam, file, "--out", tmp_path / "out", "--no-figures").status == 0
        assert misfits(tmp_path / "out")[0]["largest"] < 1e-12

    def test_decimal_commas_of_spreadsheets(self, foam, measured, wave, tmp_path):
        text = table("frequency_hz, absorption", F, wave.absorption).replace(", ", ";").replace(".", ",")
        assert run("compare", foam, measured(text), "--out", tmp_path / "out", "--no-figures").status == 0
        assert misfits(tmp_path / "out")[0]["largest"] < 1e-12

    def test_frequencies_outside_of_the_working_range_are_left_out(self, foam, measured, wave, tmp_path):
        rows = [f"{f},{str(f > 300).lower()},{a if f > 300 else 3.6}" for f, a in zip(F, wave.absorption, strict=True)]
        file = measured("\n".join(["frequency_hz,in_range,absorption", *rows]))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        n = sum(F <= 300)
        assert f"{file}: rows left out of {len(F)}: {n} outside of the working range of the tube" in done.err
        assert misfits(tmp_path / "out")[0]["largest"] < 1e-12

    @pytest.mark.parametrize("suffix", SPECTRA_WRITERS)
    def test_formats(self, foam, tmp_path, suffix):
        f = np.array([250.0, 500.0, 750.0])
        spectra = {"reflection": plane_wave(load_stack(foam), f).reflection}
        file = SPECTRA_WRITERS[suffix](tmp_path / f"tube.{suffix}", f, spectra, {})
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        assert (done.status, done.err) == (0, "")
        assert done.out.startswith("tube over foam: 3 frequencies, 250 to 750 Hz")
        assert misfits(tmp_path / "out")[0]["largest"] < 1e-10

    def test_impedance(self, foam, measured, wave, tmp_path):
        z = wave.surface_impedance / load_stack(foam).ambient.gas.impedance + (0.3 + 0.4j)
        named = measured(table("frequency_hz, normalised_impedance_re, normalised_impedance_im", F, z.real, z.imag))
        short = measured(table("frequency_hz, re, im", F, z.real, z.imag), "short.csv")
        for file, options in ((named, ()), (short, ("--quantity", "normalised_impedance"))):
            assert run("compare", foam, file, "--out", tmp_path / "out", *options).status == 0
            (misfit,) = misfits(tmp_path / "out")
            assert (misfit["rms"], misfit["largest"]) == (pytest.approx(0.5), pytest.approx(0.5))

    def test_what_simulate_writes(self, foam, tmp_path):
        assert run("simulate", foam, "--out", tmp_path / "one", "--no-figures").status == 0
        done = run("compare", foam, tmp_path / "one" / "simulation.csv", "--out", tmp_path / "two", "--no-figures")
        assert done.status == 0
        found = misfits(tmp_path / "two")
        assert [misfit["quantity"] for misfit in found] == ["absorption", "normalised_impedance", "reflection"]
        assert max(misfit["rms"] for misfit in found) < 1e-7

    @pytest.mark.parametrize(("width", "n"), [("third octaves", 18), ("octaves", 6)])
    def test_bands(self, measured, tmp_path, width, n):
        file = tmp_path / "panel.yaml"
        file.write_text(f"{PANEL}frequency: {{{width.replace(' ', '_')}: [100, 5000]}}\n")
        assert run("simulate", file, "--out", tmp_path / "one", "--no-figures").status == 0
        rows = list(csv.DictReader(io.StringIO((tmp_path / "one" / "simulation.csv").read_text())))
        losses = [float(row["transmission_loss_db"]) for row in rows]
        nominal = [float(row["frequency_hz"]) for row in rows]
        spectrum = measured(table("frequency_hz, transmission_loss_db", nominal, losses))
        done = run("compare", file, spectrum, "--out", tmp_path / "two")
        assert done.status == 0
        assert f"tube over panel: {n} {width}, {nominal[0]:g} to {nominal[-1]:g} Hz" in done.out
        assert misfits(tmp_path / "two")[0]["largest"] < 1e-7
        off = measured(table("frequency_hz, transmission_loss_db", [112.0], losses[:1]), "off.csv")
        done = run("compare", file, off, "--out", tmp_path / "three")
        assert done.status == 2
        assert f"112 Hz is no centre among those of {width}, or stands twice" in done.err
        twice = measured(table("frequency_hz, transmission_loss_db", [125.0, 500.0, 500.0], losses[:3]), "twice.csv")
        told = run("compare", file, twice, "--out", tmp_path / "four").err
        assert told.startswith(f"{twice}: twice: 500 Hz is no centre")

    def test_tolerances_and_cases(self, foam, measured, wave, tmp_path):
        foam.write_text(
            FOAM + "sweep: {layers.foam.thickness: [20 mm, 50 mm]}\ntolerances: {layers.foam.flow_resistivity: 20 %}\n"
        )
        file = measured(table("frequency_hz, absorption", F, wave.absorption))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--json")
        assert (done.status, done.err) == (0, "")
        thin, thick = json.loads(done.out)["misfits"]
        assert (thin["inside_percentiles"], thick["inside_percentiles"]) == (0, 1)
        assert thin["rms"] > 0.2
        assert thick["rms"] < 1e-12

    def test_what_is_not_predicted_is_left_out(self, foam, measured, wave, tmp_path):
        file = measured(table("frequency_hz, absorption, transmission_loss_db", F, wave.absorption, F))
        done = run("compare", foam, file, "--out", tmp_path / "out", "--no-figures")
        assert done.status == 0
        assert "not predicted, left out: transmission_loss" in done.out


BAD = {
    "no unit": (
        "frequency, absorption\n100, 0.5\n",
        "tube.csv:1: column 'frequency' has no unit; write 'frequency_hz'",
    ),
    "no dB": ("f_hz, transmission_loss\n100, 5\n", "'transmission_loss' has no unit; write 'transmission_loss_db' or"),
    "wrong unit": ("frequency [m], absorption\n100, 0.5\n", "column 'frequency [m]': '1 m' has the wrong unit"),
    "per cent for dB": ("f_hz, tl [%]\n100, 5\n", "column 'tl [%]' must be in dB"),
    "impedance of what": ("f_hz, impedance_re, impedance_im\n1, 1, 1\n", "does not say whether it is divided by rho c"),
    "half an impedance": (
        "f_hz, reflection_re\n1, 1\n",
        "reflection needs two columns, reflection_re and",
    ),
    "re and im of what": ("f_hz, re, im\n1, 1, 1\n", "'re' and 'im' need --quantity normalised_impedance|reflection"),
    "no frequency": ("absorption\n1\n", "no column holds the frequency; name the columns 'frequency_hz'"),
    "nothing to compare": ("f_hz, colour\n1, 2\n", "no column holds a quantity to compare"),
    "twice": ("f_hz, absorption, alpha\n1, 1, 1\n", "two columns hold absorption"),
    "empty": ("# nothing\n", "is empty; name the columns"),
    "header only": ("f_hz, absorption\n", "holds no values below its header"),
    "no number": ("f_hz, absorption\n100, 0.5\n200, much\n", "tube.csv:3: 'much' is no number"),
    "decimal comma": ("f_hz; absorption\n100.0; 0,5\n", "'0,5' is no number; write decimals with a point"),
    "decimal comma between commas": (
        "f [Hz],alpha\n250,1\n500,0,31\n",
        "tube.csv:3: has 3 cells where 2 columns are named; decimals have a point where commas separate columns",
    ),
    "point between thousands": (
        "f [Hz];alpha\n500;0,31\n1.000;0,62\n",
        "tube.csv:2: '0,31' is no number; write decimals with a point, as '1.000' in line 3 has one; a point between "
        "thousands must go",
    ),
    "comma between thousands and commas": (
        'f [Hz],alpha\n500,0.31\n"1,000",0.62\n',
        "tube.csv:3: '1,000' is no number; write decimals with a point, as '0.31' in line 2 has one, and thousands "
        "without a mark, '1000'",
    ),
    "decimal comma in quotes between commas": (
        'f [Hz],alpha\n500,"0,31"\n',
        "tube.csv:2: '0,31' is no number; write decimals with a point\n",
    ),
    "comma between thousands": (
        "f [Hz];alpha\n800;0\n1,000;1\n1,250;0\n",
        "tube.csv:3: '1,000' stands among whole numbers as '800': are these thousands, or decimals? Write '1000', or "
        "'1,0000' for decimals",
    ),
    "frequency without a unit": (
        "frequency [-], alpha\n1, 0\n",
        "'frequency [-]' holds no pure numbers; write its unit",
    ),
    "outside of the working range": (
        "frequency_hz,in_range,absorption\n100,false,3.6\n",
        "tube.csv:1: holds no row to compare; left out: 1 outside of the working range of the tube",
    ),
    "blanks": (
        "f_hz absorption\n100 0.5\n",
        "tube.csv:1: has blanks between its columns; columns are separated by commas, semicolons or tabs",
    ),
    "not finite": ("f_hz, absorption\n100, nan\n", "tube.csv:2: 'nan' is not finite"),
    "short row": ("f_hz, absorption\n100\n", "tube.csv:2: has 1 cells and lacks some of the columns"),
    "frequency zero": ("f_hz, absorption\n0, 0.5\n", "tube.csv:2: a frequency of 0 Hz is not allowed"),
    "several cases": ("case, f_hz, absorption\na, 1, 1\nb, 1, 1\n", "holds several cases of a simulation"),
    "not predicted": ("f_hz, tl_db\n100, 5\n", "tube holds transmission_loss, and this simulation predicts absorption"),
}


class TestBadInput:
    @pytest.mark.parametrize("name", BAD)
    def test_table(self, foam, measured, tmp_path, name):
        text, words = BAD[name]
        done = run("compare", foam, measured(text), "--out", tmp_path / "out")
        assert (done.status, done.out) == (2, "")
        assert words in done.err
        assert len(done.err.splitlines()) == 1
        assert not (tmp_path / "out").exists()

    def test_binary(self, foam, tmp_path):
        (tmp_path / "tube.csv").write_bytes(b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR")
        done = run("compare", foam, tmp_path / "tube.csv")
        assert done.status == 2
        assert "is no text that can be read" in done.err

    def test_folder(self, foam, tmp_path):
        done = run("compare", foam, tmp_path)
        assert (done.status, done.err) == (2, f"{tmp_path}: is a folder; name the file in it\n")

    def test_missing(self, foam, tmp_path):
        done = run("compare", foam, tmp_path / "tube.csv")
        assert done.status == 2
        assert "tube.csv: there is no such file" in done.err

    def test_quantity(self, foam, measured):
        done = run("compare", foam, measured("f_hz, absorption\n100, 0.5\n"), "--quantity", "absorbtion")
        assert done.status == 2
        assert "--quantity: there is no 'absorbtion'; did you mean 'absorption'?" in done.err

    def test_quantity_that_is_not_there(self, foam, measured):
        done = run("compare", foam, measured("f_hz, absorption\n100, 0.5\n"), "--quantity", "TL")
        assert done.status == 2
        assert "no column holds the transmission_loss" in done.err

    @pytest.mark.parametrize(
        ("text", "quantity"),
        [
            (FOAM, "transmission_loss_db"),
            (FOAM, "insertion_loss_db"),
            (f"{FOAM}incidence: diffuse\n", "reflection_re, reflection_im"),
            (f"{FOAM}frequency: {{octaves: [125, 250]}}\n", "reflection_re, reflection_im"),
        ],
    )
    def test_what_is_not_predicted_is_told_before_anything_is_computed(
        self, foam, measured, tmp_path, monkeypatch, text, quantity
    ):
        def computed(*arguments):
            raise AssertionError("computed")

        monkeypatch.setattr("multilayer.simulation.run.run", computed)
        foam.write_text(text)
        columns = [[125, 250]] * (1 + len(quantity.split(",")))
        done = run("compare", foam, measured(table(f"frequency_hz, {quantity}", *columns)), "--out", tmp_path / "out")
        assert (done.status, done.out) == (2, "")
        assert "and this simulation predicts absorption" in done.err
        assert not (tmp_path / "out").exists()
