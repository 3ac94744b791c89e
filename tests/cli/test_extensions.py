"""Pores and the accelerometer's mass in a fit file, as a user meets them."""

import csv
import json

import pytest

from tests.cli.campaigns import BURSTS, line_of, modulus
from tests.cli.command import run
from tests.cli.test_bad_input import assert_refused

PORES = "campaign: .\npores: {porosity: 0.95, flow_resistivity: 30 kN s/m4}\n"


def rows(file):
    with file.open() as lines:
        return list(csv.DictReader(lines))


class TestPores:
    def test_air_takes_its_share(self, campaign, tmp_path):
        """The signals are those of a solid: a frame with air in its pores explains them with less stiffness."""
        (campaign / "fit.yaml").write_text(PORES)
        done = run("fit", campaign, "--no-figures", "--out", tmp_path / "out")
        assert (done.status, done.err) == (0, "")
        found = {float(row["frequency_hz"]): float(row["E1_pa"]) for row in rows(tmp_path / "out" / "moduli.csv")}
        for f in BURSTS:
            assert 0.2 < found[f] / modulus(f).real < 0.8
        stated = json.loads((tmp_path / "out" / "fit.json").read_text())["settings"]["pores"]
        assert stated == {"porosity": 0.95, "flow_resistivity": 3e4, "tortuosity": 1.0}

    @pytest.mark.parametrize(
        ("old", "new", "place", "parts"),
        [
            ("porosity: 0.95", "porosity: 1.2", "1.2", ["pores.porosity", "1.2"]),
            ("porosity: 0.95, ", "", "{flow", ["pores", "porosity"]),
            ("30 kN s/m4", "-3 N s/m4", "-3 N", ["pores.flow_resistivity"]),
            ("30 kN s/m4", "30 kPa", "30 kPa", ["pores.flow_resistivity"]),
            ("30 kN s/m4}", "30 kN s/m4, rim: open}", "open}", ["pores.rim", "plane waves have no rim"]),
            ("30 kN s/m4}", "30 kN s/m4, rim: shut}", "shut}", ["pores.rim", "sealed"]),
            ("porosity:", "prosity:", "prosity", ["pores.prosity", "porosity"]),
        ],
    )
    def test_pores_that_cannot_be(self, campaign, tmp_path, old, new, place, parts):
        file = campaign / "fit.yaml"
        file.write_text(PORES.replace(old, new))
        done = run("fit", campaign, "--out", tmp_path / "out")
        assert_refused(done, f"fit.yaml:{line_of(file, place)}", *parts)
        assert not (tmp_path / "out").exists()

    def test_methods_without_air(self, campaign, tmp_path):
        (campaign / "fit.yaml").write_text(PORES)
        assert_refused(run("methods", campaign, "--out", tmp_path / "out"), "pores: the classical methods have none")

    def test_options_against_the_file(self, campaign, tmp_path):
        (campaign / "fit.yaml").write_text(f"model: finite\n{PORES.replace('}', ', rim: open}')}")
        done = run("fit", campaign, "--model", "plane_wave", "--out", tmp_path / "out")
        assert_refused(done, "pores.rim: plane waves have no rim")


def test_mass_of_the_accelerometer(campaign, tmp_path):
    """A plate that is thought heavier carries a stiffer sample."""
    (campaign / "fit.yaml").write_text("campaign: .\nsensor_mass: 1.25 g\n")  # a tenth of the plate's mass
    done = run("fit", campaign, "--no-figures", "--out", tmp_path / "out")
    assert (done.status, done.err) == (0, "")
    found = {float(row["frequency_hz"]): float(row["E1_pa"]) for row in rows(tmp_path / "out" / "moduli.csv")}
    assert found[200] / modulus(200).real == pytest.approx(1.08, abs=0.03)


def test_mass_below_nothing(campaign, tmp_path):
    (campaign / "fit.yaml").write_text("campaign: .\nsensor_mass: -1 g\n")
    assert_refused(run("fit", campaign, "--out", tmp_path / "out"), "sensor_mass", "-0.001")
