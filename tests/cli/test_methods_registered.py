"""``--method`` takes any registered name: built-in ones, those of packages and of single files."""

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

from multilayer.fits.methods import METHODS
from tests.cli.campaigns import BURSTS, NAME, modulus
from tests.cli.command import result_names, run, run_elsewhere
from tests.cli.test_bad_input import assert_refused
from tests.cli.test_fit import keep_bursts, rows, strict_json

ROOT = Path(__file__).parents[2]
FOAM = ROOT / "examples" / "foam_b"
HALF_POWER = ROOT / "tests" / "fits" / "half_power.py"


def record(folder):
    return strict_json((folder / "fit.json").read_text())


class TestBuiltIn:
    def test_transfer_function(self, campaign, tmp_path):
        out = tmp_path / "out"
        done = run("fit", campaign, "--method", "transfer-function", "--lateral", "held", "--out", out)
        assert (done.status, done.err) == (1, "")  # the last burst is too high for a rod
        assert result_names(out) == {"moduli.csv", "fit.json", "report.html", "moduli.png", "gross_check.png"}
        assert [float(row["frequency_hz"]) for row in rows(out)] == list(BURSTS)
        assert [row["accepted"] for row in rows(out)] == ["true", "true", "false"]
        for row in rows(out):
            assert abs(float(row["E1_pa"]) - modulus(float(row["frequency_hz"])).real) < 3 * float(row["E1_std_pa"])
            assert row["delta_tof_s"] == ""
        found = record(out)
        assert (found["method"], found["settings"]["method"]) == ("transfer-function", "transfer-function")
        assert found["bursts"][0]["delta_tof_s"] is None
        assert set(found["transfer_function_limit_hz"]) == {NAME}
        assert "too thick for its wavelength beyond" in done.out

    def test_where_there_is_no_modulus(self, campaign, tmp_path):
        keep_bursts(campaign, 400)
        (campaign / "fit.yaml").write_text(
            "version: 1\nmethod: transfer-function\nbounds: {storage_modulus: [100 MPa, 1 GPa]}\n"
        )
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert (done.status, done.err) == (1, "")
        assert result_names(tmp_path / "out") == {"moduli.csv", "fit.json", "report.html"}
        (row,) = rows(tmp_path / "out")
        assert (row["E1_pa"], row["accepted"]) == ("", "false")
        assert "no modulus within bounds" in done.out
        assert " – " in done.out
        assert "nan" not in done.out

    def test_quasi_static_of_the_fit_file(self, campaign, tmp_path):
        text = "version: 1\nmethod: quasi-static\n"
        (campaign / "fit.yaml").write_text(text)
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert_refused(done, "no quasi_static values in a fit file, and no burst below a tenth of the resonance")
        static = "quasi_static: {storage_modulus: 150 kPa, loss_modulus: 40 kPa, frequency: 5 Hz}\n"
        (campaign / "fit.yaml").write_text(text + static)
        assert run("fit", campaign, "--out", tmp_path / "out", "--no-figures").status == 0
        assert [(row["frequency_hz"], row["E1_pa"]) for row in rows(tmp_path / "out")] == [("5", "150000")]

    def test_joint_by_its_name(self, sound_campaign, tmp_path):
        one, two = tmp_path / "one", tmp_path / "two"
        for out, option in ((one, ("--joint",)), (two, ("--method", "joint"))):
            assert run("fit", sound_campaign, *option, "--out", out, "--no-figures").status in (0, 1)
        assert (one / "joint.json").read_text() == (two / "joint.json").read_text()
        again = run("fit", sound_campaign, "--method", "joint", "--out", one, "--no-figures", "--resume")
        assert "nothing to do" in again.out

    def test_pores_are_refused(self, campaign, tmp_path):
        (campaign / "fit.yaml").write_text("version: 1\nmethod: transfer-function\nsensor_mass: 1 g\n")
        assert_refused(run("fit", campaign, "--out", tmp_path / "out"), "sensor_mass: the classical methods have none")

    def test_fits_that_need_every_burst_by_itself(self, campaign, tmp_path):
        other = shutil.copytree(campaign, tmp_path / "other")
        for folder, plate in ((campaign, "1 mm"), (other, "3 mm")):
            file = folder / "campaign.yaml"
            file.write_text(file.read_text().replace("top_plate_thickness: 1 mm", f"top_plate_thickness: {plate}"))
            (folder / "fit.yaml").write_text("version: 1\nmethod: transfer-function\n")
        done = run("preload", campaign, other, "--out", tmp_path / "out")
        assert_refused(done, "method: 'transfer-function' does not fit every burst by itself; take least-squares or")


class TestOptions:
    @pytest.mark.parametrize(
        ("options", "words"),
        [
            (("--law", "zener"), "--law is of joint, not of least-squares; add --joint, or leave it out"),
            (("--elements", "3"), "--elements is of joint, not of least-squares; add --joint, or leave it out"),
            (
                ("--lateral", "held"),
                "--lateral is of transfer-function, not of least-squares; choose another --method, or",
            ),
            (("--method", "transfer-function", "--lateral", "hold"), "--lateral: there is no 'hold'; did you mean"),
            (
                ("--method", "transfer-function", "--model", "finite"),
                "not of transfer-function; choose another --method",
            ),
            (("--method", "transfer-function", "--joint"), "--joint and --method transfer-function are two methods"),
            (("--method", "stacks"), "--method: 'stacks' fits no campaigns, but what a stack-fit file says"),
            (("--method", "nelder-mead", "--model", "finite"), "--method: nelder-mead is the paper's method with"),
            (("--joint", "--law", "zenner"), "--law: there is no law 'zenner'; did you mean 'zener'?"),
            (("--joint", "--law", "maxwell", "--elements", "0"), "Invalid value for '--elements': "),
            (("--joint", "--law", "free_form"), "say how many `elements` (add --elements N), or"),
        ],
    )
    def test_that_do_not_fit(self, sound_campaign, tmp_path, options, words):
        assert_refused(run("fit", sound_campaign, "--out", tmp_path / "out", *options), words)
        assert not (tmp_path / "out").exists()

    def test_of_stacks(self, tmp_path):
        tube = ROOT / "examples" / "foam_tube"
        for option in (("--law", "zener"), ("--method", "transfer-function"), ("--joint",), ("--resume",)):
            done = run("fit", tube, "--out", tmp_path / "out", *option)
            assert_refused(done, f"{option[0]} is of the fit of a campaign; {tube} is a stack-fit file: leave it out")
        assert run("fit", tube, "--method", "stacks", "--out", tmp_path / "out", "--no-figures").status == 0

    def test_the_fit_file_names_a_wrong_one(self, campaign, tmp_path):
        (campaign / "fit.yaml").write_text("version: 1\nmethod: stacks\n")
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert_refused(done, f"{campaign / 'fit.yaml'}:2:9: method: 'stacks' fits no campaigns")


class TestList:
    def test_without_a_campaign(self):
        done = run("methods")
        assert (done.status, done.err) == (0, "")
        for name, kind in METHODS.working():
            assert f"{name:20}{kind.summary}\n" in done.out

    def test_as_json(self):
        found = {one["method"]: one for one in json.loads(run("methods", "--json").out)}
        assert list(found) == METHODS.names()
        assert found["stacks"] | {"summary": ""} == {
            "method": "stacks", "summary": "", "reads": "stack-fit", "options": ["--posterior"],
        }  # fmt: skip
        assert found["joint"]["options"] == ["--model", "--law", "--elements", "--posterior", "--with"]

    def test_options_are_those_of_the_command(self):
        options = run("fit", "--help").out
        assert all(option in options for one in json.loads(run("methods", "--json").out) for option in one["options"])


class TestSingleFile:
    """The half-power width, from one file: beside the built-in methods, and gone afterwards."""

    def test_fit(self, tmp_path):
        out = tmp_path / "out"
        done = run("fit", FOAM, "--plugin", HALF_POWER, "--method", "half-power", "--out", out)
        assert (done.status, done.err) == (0, "")
        (row,) = rows(out)
        # between the moduli that the transfer function has at 100 and 200 Hz
        assert 100 < float(row["frequency_hz"]) < 200
        assert 2.0e5 < float(row["E1_pa"]) < 2.45e5
        assert 0.35 < float(row["loss_factor"]) < 0.4
        done = run("fit", FOAM, "--method", "half-power", "--out", out)
        assert_refused(done, "--method: there is no method 'half-power'; allowed: joint, least-squares,")

    def test_of_a_fit_file_with_processes(self, tmp_path, sound_campaign):
        folders = [shutil.copytree(sound_campaign, tmp_path / name) for name in ("a", "b")]
        for folder in folders:
            keep_bursts(folder, 200)
            (folder / "fit.yaml").write_text("version: 1\nmethod: half-power\n")
        assert_refused(run("check", folders[0]), ":2:9: method: there is no method 'half-power'")
        options = ("--plugin", HALF_POWER, "--jobs", 2, "--no-figures", "--out", tmp_path / "out")
        done = run("fit", *folders, *options)
        assert done.status == 1, done.err
        assert [json.loads((tmp_path / "out" / name / "fit.json").read_text())["method"] for name in ("a", "b")] == [
            "half-power", "half-power",
        ]  # fmt: skip

    def test_beside_the_others(self, campaign, tmp_path):
        keep_bursts(campaign, 200)
        done = run("methods", campaign, "--plugin", HALF_POWER, "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        found = strict_json((tmp_path / "out" / "methods.json").read_text())
        assert found["methods"]["half-power"] == "half-power width of the resonance"
        (point,) = (point for point in found["points"] if point["method"] == "half-power")
        assert not point["reliable"]
        (rod,) = (point for point in found["points"] if point["method"] == "transfer-function")
        assert point["E1_pa"] == pytest.approx(rod["E1_pa"], rel=0.1)
        assert "half-power: half-power width of the resonance" in done.out


@pytest.fixture
def package(tmp_path):
    """Give a path with an installed package: the half-power width, and a method that does not load."""
    root = tmp_path / "site"
    info = root / "house_methods-1.2.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: house-methods\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(
        "[multilayer.methods]\nhalf-power = house_power:HalfPower\nbroken = house_broken:Method\n"
    )
    (root / "house_power.py").write_text(HALF_POWER.read_text())
    (root / "house_broken.py").write_text("raise RuntimeError('no licence')\n")
    return str(root)


class TestPackage:
    def test_one_file_and_an_entry_point(self, package, tmp_path):
        out = tmp_path / "out"
        options = ("--method", "half-power", "--no-figures", "--out", out)
        done = run_elsewhere("fit", FOAM, *options, PYTHONPATH=package)
        assert (done.status, done.err) == (0, "")
        assert np.isfinite(float(rows(out)[0]["E1_pa"]))

    def test_a_broken_one_stops_nothing_else(self, package, campaign, tmp_path):
        keep_bursts(campaign, 400)
        done = run_elsewhere("methods", campaign, "--no-figures", "--out", tmp_path / "out", PYTHONPATH=package)
        assert done.status == 0
        warning = "warning: left out: method 'broken' of house_broken:Method (package house-methods 1.2) does not load"
        assert done.err.startswith(warning)
        done = run_elsewhere("fit", campaign, "--method", "broken", "--out", tmp_path / "no", PYTHONPATH=package)
        assert_refused(
            done, "method 'broken' of house_broken:Method (package house-methods 1.2) does not load: Runtime"
        )
        assert not (tmp_path / "no").exists()
