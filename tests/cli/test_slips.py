"""Slips that a file allows: asked back in a line, once; and failures that are nobody's input."""

import os
import re
import shutil
import signal
import subprocess
import sys
import time

import pytest

from multilayer.cli.failures import failure
from multilayer.inference.priors import Prior
from tests.cli.command import run
from tests.examples.test_examples import EXAMPLES
from tests.explore.command import SCRIPT

SOLID = "{{type: elastic_solid, density: 2700, poisson_ratio: 0.3, thickness: 1 mm, young_modulus: {}}}"
TABLE_UP_TO = "law: table, frequency: [10, 100]"
FOAM = "{type: equivalent_fluid, name: foam, model: jca, porosity: 0.9, flow_resistivity: 10000, tortuosity: 1.1"


def written(tmp_path, layer, rest="termination: rigid\n"):
    file = tmp_path / "stack.yaml"
    file.write_text(f"version: 1\nlayers:\n  - {layer}\n{rest}")
    return file


@pytest.mark.parametrize(
    ("layer", "rest", "told"),
    [
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50}}", "termination: rigid\n",
         ["layers.0.thickness: a layer of 50 m; numbers without a unit are in m: is '50 mm' meant?"]),
        (f"{FOAM}, viscous_length: 3e-4, thermal_length: 1e-4, thickness: 50 mm}}", "termination: rigid\n",
         ["layers.0.viscous_length: 300 um is above thermal_length, 100 um, which no pores have: exchanged?"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50 mm}}", "frequency: [100, 200]\n",
         ["no termination is stated: a rigid wall is assumed, without transmission; say rigid or ambient"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50 mm}}",
         "termination: rigid\nambient: {temperature: 20, pressure: 1013}\n",
         ["ambient.temperature: a temperature of 20 K; numbers without a unit are in K: is '20 degC' meant?",
          "ambient.pressure: a pressure of 1013 Pa; numbers without a unit are in Pa: is '1013 hPa' meant?"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50 mm}}",
         "termination: rigid\nambient: {density: 0.166, sound_speed: 1007}\n",
         ["ambient.density: density sound_speed^2 is 1.683e+05 Pa, heat_capacity_ratio times pressure 1.419e+05 Pa"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50 mm}}",
         "termination: rigid\nambient: {density: 0.166, sound_speed: 1007, heat_capacity_ratio: 1.66}\n", []),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 2e-4, thickness: 50 mm}}",
         "termination: rigid\nambient: {density: 1.2, sound_speed: 340}\n", []),
        (f"{FOAM}, viscous_length: 100, thermal_length: 200, thickness: 50 mm}}".replace("10000", "10"),
         "termination: rigid\n",
         ["layers.0.flow_resistivity: a flow resistivity of 10 N s/m4; numbers without a unit are in N s/m4: is "
          "'10 kN s/m4' meant?",
          "layers.0.viscous_length: pores of 100 m; numbers without a unit are in m: is '100 um' meant?",
          "layers.0.thermal_length: pores of 200 m; numbers without a unit are in m: is '200 um' meant?"]),
        ("{type: elastic_solid, density: 7.8, young_modulus: 210, poisson_ratio: 0.3, thickness: 1 mm}",
         "termination: rigid\n",
         ["layers.0.density: a density of 7.8 kg/m3; numbers without a unit are in kg/m3: is '7.8 g/cm3' meant?",
          "layers.0.young_modulus: a Young's modulus of 210 Pa; numbers without a unit are in Pa: is '210 GPa' "
          "meant?"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 1e-4, thickness: 50 mm}}", "termination: rigid\n", []),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 1e-4, thickness: 50 mm}}".replace("0.9", "0.98 %"),
         "termination: rigid\n",
         ["layers.0.porosity: a porosity of 0.0098, which is 0.98 %: is 0.98 meant?"]),
        (f"{FOAM}, viscous_length: 1e-4, thermal_length: 1e-4, thickness: 50 mm}}".replace("0.9", "0.05"),
         "termination: rigid\n", ["layers.0.porosity: a porosity of 0.05, which is 5 %: is 0.95 meant?"]),
        (SOLID.format("70 GPa, loss_factor: 10"), "termination: rigid\n",
         ["layers.0.loss_factor: a loss factor of 10, which is 1000 %: is '10 %' meant?"]),
        (SOLID.format("70 GPa, loss_factor: 0.1"), "termination: rigid\n", []),
        (SOLID.format("70+7j"), "termination: rigid\n",
         ["layers.0.young_modulus: a Young's modulus of 70 Pa; numbers without a unit are in Pa: is '70 GPa' meant?"]),
        (SOLID.format("{law: loss_factor, young_modulus: 70, loss_factor: 5}"), "termination: rigid\n",
         ["layers.0.young_modulus: a Young's modulus of 70 Pa;", "layers.0.young_modulus: a loss factor of 5,"]),
        (SOLID.format(f"{{{TABLE_UP_TO}, storage_modulus: [2, 3], loss_modulus: [0, 0]}}"),
         "termination: rigid\nfrequency: [20, 90]\n", ["layers.0.young_modulus: a Young's modulus of 3 Pa;"]),
        (SOLID.format(f"{{law: shifted, modulus: {{{TABLE_UP_TO}, storage_modulus: [2, 3], loss_modulus: [0, 0]}}, "
                      "temperature: 300, reference_temperature: 300, activation_energy: 1e5}"),
         "termination: rigid\nfrequency: [20, 90]\n", ["layers.0.young_modulus: a Young's modulus of 3 Pa;"]),
        ("{type: fluid, thickness: 1 m, losses: air}",
         "termination: rigid\nambient: {density: 0.166, sound_speed: 1007, heat_capacity_ratio: 1.66}\n",
         ["layers.0.losses: the losses are those of air at the ambient temperature and pressure, and ambient.density "
          "is 0.166, of such air 1.204: leave out 'losses' of another gas, or give temperature and pressure of air"]),
        ("{type: fluid, thickness: 1 m, losses: air}",
         "termination: rigid\nambient: {density: 1.2, sound_speed: 340, relative_humidity: 0.4}\n", []),
        ("{type: fluid, thickness: 1 m, losses: air}",
         "termination: rigid\nambient: {temperature: 0 degC, density: 1.29, sound_speed: 331}\n", []),
        ("{type: fluid, thickness: 1 m}",
         "termination: rigid\nambient: {density: 0.166, sound_speed: 1007, heat_capacity_ratio: 1.66}\n", []),
    ],
)  # fmt: skip
def test_what_is_hardly_meant_is_asked_back_once(tmp_path, layer, rest, told):
    file = written(tmp_path, layer, rest)
    done = run("simulate", file, "--no-figures", "--out", tmp_path / "out")
    assert done.status == 0, done.err
    lines = [line for line in done.err.splitlines() if line.startswith(f"warning: {file}")]
    assert len(lines) == len(told)
    assert all(text in line for text, line in zip(told, lines, strict=True))


CAMPAIGN_SLIPS = {
    "density: 87\n": ("density: 0.087\n", "specimen.density: a density of 0.087 kg/m3", "0.087 g/cm3"),
    "density: 7850,": ("density: 7.85,", "top_plate.density: a density of 7.85 kg/m3", "7.85 g/cm3"),
    "young_modulus: 7.0e+10": ("young_modulus: 70", "base_plate.young_modulus: a Young's modulus of 70 Pa", "70 GPa"),
    "specimen_thickness: 0.025": ("specimen_thickness: 25", "specimen_thickness: a length of 25 m", "25 mm"),
    "top_plate_thickness: 0.001": ("top_plate_thickness: 1", "top_plate_thickness: a length of 1 m", "1 mm"),
    "specimen_radius: 0.0225": ("specimen_radius: 22.5", "specimen_radius: a length of 22.5 m", "22.5 mm"),
}


def told_of(file):
    done = run("check", file)
    return done.status, [line for line in done.err.splitlines() if "is '" in line and "numbers without a unit" in line]


def test_numbers_of_a_campaign_in_other_units_are_asked_back(tmp_path):
    shutil.copytree(EXAMPLES / "foam_b", tmp_path / "foam")
    file = tmp_path / "foam" / "campaign.yaml"
    text = file.read_text(encoding="utf-8")
    assert told_of(tmp_path / "foam") == (0, [])
    for right, (wrong, _, _) in CAMPAIGN_SLIPS.items():
        assert text.count(right) == 1
        text = text.replace(right, wrong)
    file.write_text(text, encoding="utf-8")
    status, lines = told_of(tmp_path / "foam")
    assert (status, len(lines)) == (0, len(CAMPAIGN_SLIPS))
    for line, (_, what, meant) in zip(lines, CAMPAIGN_SLIPS.values(), strict=True):
        assert line.startswith(f"warning: {file}:")
        assert what in line
        assert line.endswith(f"is '{meant}' meant?")


@pytest.mark.parametrize(
    ("field", "told"),
    [
        ("bounds: {storage_modulus: [1, 1000]}", ":4:28: bounds.storage_modulus.0: a modulus of 1 Pa;"),
        ("sensor_mass: 1", ":4:14: sensor_mass: a mass of 1 kg;"),
        (
            "pores: {porosity: 0.9, flow_resistivity: 20}",
            ":4:42: pores.flow_resistivity: a flow resistivity of 20 N s/m4;",
        ),
        ("ambient: {temperature: 20}", ":4:24: ambient.temperature: a temperature of 20 K;"),
    ],
)
def test_numbers_of_a_fit_file_in_other_units_are_asked_back(tmp_path, field, told):
    file = tmp_path / "fit.yaml"
    file.write_text(f"kind: fit\nversion: 1\ncampaign: {EXAMPLES / 'foam_b'}\n{field}\n", encoding="utf-8")
    status, (line,) = told_of(file)
    assert (status, f"{file}{told}" in line) == (0, True), line


def test_numbers_of_a_rig_file_in_other_units_are_asked_back_in_place_of_a_wrong_remedy(tmp_path):
    text = (EXAMPLES / "virtual_rig.yaml").read_text(encoding="utf-8")
    file = tmp_path / "rig.yaml"
    file.write_text(text.replace("80 kg/m^3", "0.08"), encoding="utf-8")
    status, (line,) = told_of(file)
    assert (status, "specimen.density: a density of 0.08 kg/m3;" in line) == (0, True), line
    file.write_text(text.replace("[12.5 mm, 25 mm]", "[12.5, 25]"), encoding="utf-8")
    status, lines = told_of(file)
    assert (status, len(lines)) == (2, 2)
    assert "configurations.thicknesses.1: a length of 25 m;" in lines[1]
    assert "loss factor" not in run("check", file).err


def test_energy_that_a_model_makes_outside_its_range_is_told_by_its_name(tmp_path):
    layer = "{type: equivalent_fluid, model: delany_bazley, thickness: 50 mm, flow_resistivity: 60 kN s/m^4}"
    file = written(tmp_path, layer, "termination: rigid\nfrequency: [20 Hz, 500 Hz]\n")
    done = run("simulate", file, "--out", tmp_path / "out")
    assert done.status == 2
    assert "gives back more energy than came in" in done.err
    assert "Delany-Bazley holds for" in done.err
    assert not (tmp_path / "out").exists()


def test_a_measured_absorption_in_per_cent(tmp_path):
    table = tmp_path / "room.csv"
    table.write_text("frequency_hz,absorption\n200,12\n400,40\n800,81\n")
    done = run("compare", EXAMPLES / "foam_absorption.yaml", table, "--no-figures", "--out", tmp_path / "out")
    assert done.status == 0
    assert f"warning: {table}: an absorption of 81; it is a share of 1: are these per cent?" in done.err


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "version: 1\nlayer:\n  - {type: fluid, thickness: 1 mm}\n",
            "2:1: layer: there is no such field; did you mean",
        ),
        ("version: 1\nlayers: [{type: fluid, thickness: '0,05 m'}]\n", "decimals follow a point, '0.05 m'"),
        ("version: 1\nlayers: [{type: screen, flow_resistance: 10 rayl}]\n", "a rayl is 1 Pa s/m (MKS) or 10 Pa s/m"),
        ("version: 1\nfrequency: 100-5000\nlayers: [{type: fluid, thickness: 1}]\n", "or {from: 100 Hz, to: 5 kHz}"),
    ],
)
def test_slips_of_writing_get_one_message(tmp_path, text, told):
    (tmp_path / "slip.yaml").write_text(text)
    done = run("simulate", tmp_path / "slip.yaml")
    (line,) = [line for line in done.err.splitlines() if "slip.yaml" in line]
    assert (done.status, told in line) == (2, True), done.err


@pytest.mark.parametrize("command", ["fit", "explore", "diagnose"])
def test_a_table_where_a_file_that_names_it_is_wanted(tmp_path, command):
    table = tmp_path / "h12.csv"
    table.write_text("frequency_hz,alpha\n500,0.3\n")
    done = run(command, table)
    told = "this is no YAML file; name the stack, campaign or fit file that refers to it, or a campaign's folder"
    assert (done.status, done.err) == (2, f"{table}: {told}\n")
    assert "1:1: must hold fields" in run("tube", table).err


def test_an_optimisation_has_its_article():
    done = run("check", EXAMPLES / "best_absorber.yaml")
    assert f"{EXAMPLES / 'best_absorber.yaml'}: an optimisation of " in done.out


PLUGIN = """\
from typing import Literal

from multilayer.layers import Layer


class Broken(Layer):
    type: Literal["broken"] = "broken"
    thickness: float
    summary = "fails"

    def faces(self, wave):
        return 1 / 0
"""


def test_a_plugin_that_fails_is_named(tmp_path):
    (tmp_path / "plug.py").write_text(PLUGIN)
    file = written(tmp_path, "{type: broken, thickness: 0.01}")
    done = run("simulate", file, "--plugin", tmp_path / "plug.py", "--out", tmp_path / "out")
    assert done.status == 2
    assert f"{tmp_path / 'plug.py'}:12: the plugin failed here, in faces: ZeroDivisionError" in done.err
    assert "bug" not in done.err


def test_a_failure_of_a_pool_is_traced_to_the_plugin(tmp_path):
    error = KeyError("thickness")
    error.__cause__ = RuntimeError(f'  File "{tmp_path / "plug.py"}", line 3, in faces\n')
    assert failure(error, (tmp_path / "plug.py",))[0].startswith(f"{tmp_path / 'plug.py'}:3: the plugin failed here")
    text, status = failure(KeyError("thickness"))
    assert (status, "please report it" in text) == (70, True)


def test_ctrl_c_during_the_import_of_an_extension_module_is_no_bug(monkeypatch):
    def imports(*_):
        try:
            raise KeyboardInterrupt
        except KeyboardInterrupt as stop:
            raise ImportError("initialization failed") from stop  # as pybind11 tells it

    monkeypatch.setattr("multilayer.fits.sources.open_source", imports)
    monkeypatch.setattr("os._exit", sys.exit)
    done = run("explore", EXAMPLES / "foam_tube", "--no-browser")
    assert (done.status, done.err) == (130, "stopped by Ctrl-C: nothing was written\n")


@pytest.mark.skipif(sys.platform == "win32", reason="processes get no Ctrl-C there")
@pytest.mark.parametrize("seconds", [2.0, 5.0])
def test_ctrl_c_is_one_line(tmp_path, seconds):
    begun = SCRIPT.replace("main()", "print('begun', flush=True); main()")  # a loaded machine takes seconds to import
    command = [sys.executable, "-c", begun, "diagnose", EXAMPLES / "foam_b", "--jobs", "2", "--seed", "3"]
    started = subprocess.Popen(
        [*command, "--out", tmp_path / "out"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    assert started.stdout.readline() == "begun\n"
    time.sleep(seconds)
    os.killpg(started.pid, signal.SIGINT)
    _, told = started.communicate(timeout=30)
    if started.returncode == 0:
        pytest.skip("it was done before")
    assert (started.returncode, told.splitlines()[-1]) == (130, "stopped by Ctrl-C: nothing was written")
    assert "Traceback" not in told
    assert not (tmp_path / "out").exists()


def test_a_name_that_no_file_can_have_is_none(campaign):
    file = campaign / "campaign.yaml"
    file.write_text(re.sub(r"signals/[^,}\s]*", "x" * 300, file.read_text(), count=1))
    (campaign / "fit.yaml").write_text(f"version: 1\ncampaign: .\ncalibration: {'y' * 300}\n")
    for named in (file, campaign / "fit.yaml", campaign / ("z" * 300)):
        done = run("check", named)
        assert (done.status, "long" in done.err or "there is no" in done.err, "bug" in done.err) == (2, True, False)


@pytest.mark.parametrize(
    ("prior", "words"),
    [
        ({"lognormal": (1.0, 1e300)}, "the spread 1e+300 of ln is above 100"),
        ({"normal": (0.0, 1.0), "bounds": (1e9, 2e9)}, "1e+09 to 2e+09 hold nothing of the prior; widen them"),
    ],
)
def test_priors_that_no_number_holds(prior, words):
    with pytest.raises(ValueError, match=re.escape(words)):
        Prior(**prior)
