"""Excitations and free waves of simulation files: what the responses say, as levels, in tables, ratings and figures."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import trapezoid

from multilayer.config import parse_yaml
from multilayer.report.simulation import simulation_report
from multilayer.response.driven import driven
from multilayer.response.excitations import PointForce, Rain, TappingMachine
from multilayer.response.finite_size import Window
from multilayer.response.free_waves import free_waves
from multilayer.simulation import SimulationFile, simulate
from tests.cli.command import run

FLOOR = """\
version: 1
layers:
  - {type: elastic_plate, name: slab, thickness: 140 mm, density: 2300, young_modulus: 30 GPa, poisson_ratio: 0.2,
     loss_factor: 0.05}
termination: ambient
"""
F = [200.0, 500.0, 1300.0]


def read(**further: object) -> SimulationFile:
    data = parse_yaml(FLOOR, Path("floor.yaml")).data
    return SimulationFile.model_validate({**data, "frequency": F, **further})


def test_levels_are_those_of_third_octaves() -> None:
    simulation = read(excitation={"type": "tapping_machine", "restitution": 1})
    (case,) = simulate(simulation).cases
    expected = driven(simulation.stack, F, TappingMachine(restitution=1.0))
    assert expected.radiated_power is not None
    power = expected.radiated_power * np.array(F) * np.log(10) / 10
    np.testing.assert_allclose(case.quantities["sound_power_level"], 10 * np.log10(power / 1e-12), atol=1e-9)
    # Ln: a room with 10 m2 of absorption, p^2 = 4 rho c W/A: (20 uPa)^2/(rho c) is 1 pW/m2 where rho c = 400 Pa s/m
    level = 10 * np.log10(power * 0.4 / 1e-12 * simulation.stack.ambient.gas.impedance / 400)
    np.testing.assert_allclose(case.quantities["impact_level"], level, atol=1e-9)
    np.testing.assert_array_equal(case.quantities["input_mobility"], expected.input_mobility)
    np.testing.assert_array_equal(case.quantities["radiation_efficiency"], expected.radiation_efficiency)


def test_the_impact_level_is_that_of_the_room_behind() -> None:
    """Squared pressure 4 rho c W/A of 10 m2, of the gas behind, over (20 uPa)^2, and the power over 1 pW."""
    behind = {"type": "fluid", "density": 0.6, "sound_speed": 400.0}
    simulation = read(excitation={"type": "tapping_machine"}, termination=behind)
    (case,) = simulate(simulation).cases
    level, power = case.quantities["impact_level"], case.quantities["sound_power_level"]
    np.testing.assert_allclose(level - power, 10 * np.log10(4 * 0.6 * 400.0 / 10 * 1e-12 / 4e-10), atol=1e-9)


def test_the_edges_of_a_finite_panel_radiate() -> None:
    roof = {"type": "elastic_plate", "thickness": 7e-4, "density": 7800.0, "young_modulus": 2.1e11}
    roof |= {"poisson_ratio": 0.3, "loss_factor": 0.01}
    size = {"width": 1.4, "height": 1.1}
    simulation = read(layers=[roof], excitation={"type": "rain"}, finite_size=size)
    (case,) = simulate(simulation).cases
    expected = driven(simulation.stack, F, Rain(), window=Window(1.4, 1.1)).radiated_power
    assert expected is not None
    level = 10 * np.log10(expected * np.array(F) * np.log(10) / 10 / 1e-12)
    np.testing.assert_allclose(case.quantities["sound_power_level"], level)
    (infinite,) = simulate(read(layers=[roof], excitation={"type": "rain"})).cases
    assert np.all(level > infinite.quantities["sound_power_level"] + 1)


@pytest.mark.filterwarnings("ignore:.*bending wavelength")
def test_bands_hold_the_power_of_their_frequencies() -> None:
    thirds = read(excitation={"type": "rain"}, frequency={"third_octaves": [800.0, 1250.0]})
    octave = read(excitation={"type": "rain"}, frequency={"octaves": [1000.0, 1000.0]})
    (of_thirds,), (of_octave,) = simulate(thirds).cases, simulate(octave).cases
    levels = of_thirds.quantities["sound_power_level"]
    assert of_octave.quantities["sound_power_level"][0] == pytest.approx(
        10 * np.log10(np.sum(10 ** (levels / 10))), abs=1e-6
    )
    # against a direct sum over the band, per hertz
    f = np.geomspace(1000 * 10**-0.05, 1000 * 10**0.05, 201)
    density = driven(thirds.stack, f, Rain()).radiated_power
    assert density is not None
    assert levels[1] == pytest.approx(10 * np.log10(trapezoid(density, f) / 1e-12), abs=0.02)
    assert "input_mobility" not in of_thirds.quantities


def test_sweeps_and_tolerances() -> None:
    force = {"type": "point_force", "radius": 0.01}
    simulation = read(
        excitation=force,
        sweep={"excitation.radius": [0.01, 0.02]},
        tolerances={"layers.slab.loss_factor": "20 %"},
        samples=4,
        frequency=[500.0],
    )
    result = simulate(simulation)
    assert [case.label for case in result.cases] == ["excitation.radius = 0.01 m", "excitation.radius = 0.02 m"]
    low, _, high = result.cases[0].percentiles["sound_power_level_db"]
    (level,) = result.cases[0].quantities["sound_power_level"]
    assert level - 1 < low < high < level + 1
    expected = driven(simulation.cases[1].simulation.stack, [500.0], PointForce(radius=0.02)).input_mobility
    np.testing.assert_array_equal(result.cases[1].quantities["input_mobility"], expected)


def test_free_waves() -> None:
    simulation = read(free_waves=True)
    (case,) = simulate(simulation).cases
    expected = free_waves(simulation.stack, F)
    np.testing.assert_array_equal(case.quantities["bending_stiffness"], expected.bending_stiffness)
    np.testing.assert_array_equal(case.columns["loss_factor"], expected.loss_factor)
    np.testing.assert_array_equal(case.columns["phase_speed"], expected.phase_speed)
    assert "bending_stiffness.png" in simulation_report(simulate(simulation)).figures


@pytest.mark.filterwarnings("ignore:.*bending wavelength")
def test_the_lowest_impact_level_is_the_best() -> None:
    simulation = read(
        excitation={"type": "tapping_machine"},
        sweep={"layers.slab.thickness": [0.14, 0.2]},
        frequency={"third_octaves": [100.0, 3150.0]},
    )
    report = simulation_report(simulate(simulation))
    assert "the best is slab.thickness = 0.2 m: Ln,w (CI) 68" in report.sentence
    assert "impact_level.png" in report.figures


def test_the_command(tmp_path: Path) -> None:
    file = tmp_path / "floor.yaml"
    file.write_text(
        FLOOR + "excitation: {type: tapping_machine}\nfrequency: {third_octaves: [50 Hz, 3150 Hz]}\n"
        "sweep: {layers.slab.thickness: [140 mm, 200 mm]}\n"
    )
    done = run("simulate", str(file), "--out", str(tmp_path / "out"), "--no-figures")
    assert done.status == 0, done.err
    assert "normalised impact sound level / dB" in done.out
    assert "Ln,w (CI)" in done.out
    assert "CI,50-2500" in done.out
    with (tmp_path / "out" / "simulation.csv").open() as text:
        rows = list(csv.DictReader(text))
    assert {"sound_power_level_db", "impact_level_db", "radiation_efficiency"} <= rows[0].keys()
    record = json.loads((tmp_path / "out" / "simulation.json").read_text())
    assert record["settings"]["excitation"]["type"] == "tapping_machine"
    weighted = [int(case["ratings"]["Ln,w (CI)"].split()[0]) for case in record["cases"]]
    assert weighted[1] < weighted[0]


@pytest.mark.parametrize(
    ("excitation", "told"),
    [
        ("{type: hail}", "'hail' is not allowed as 'type'; allowed: 'point_force', 'rain', 'tapping_machine'"),
        ("{radius: 1 mm}", "has no 'type'"),
        ("{type: rain, rate: 40 mm}", "wrong unit"),
        ("{type: tapping_machine, restitution: 2}", "at most 1"),
        ("{type: turbulent_flow, speed: 50 m/s}", "boundary_layer_thickness"),
    ],
)
def test_mistakes(tmp_path: Path, excitation: str, told: str) -> None:
    file = tmp_path / "floor.yaml"
    file.write_text(f"{FLOOR}excitation: {excitation}\n")
    done = run("simulate", str(file), "--out", str(tmp_path / "out"))
    assert done.status == 2
    assert told in done.err
    assert "floor.yaml:6" in done.err
    assert not (tmp_path / "out").exists()


def test_a_front_that_yields_without_bound(tmp_path: Path) -> None:
    file = tmp_path / "floor.yaml"
    text = FLOOR.replace("elastic_plate", "elastic_solid") + "excitation: {type: point_force}\nfrequency: [500 Hz]\n"
    file.write_text(text)
    done = run("simulate", str(file), "--out", str(tmp_path / "out"))
    assert done.status == 2
    assert "radius" in done.err
    assert not (tmp_path / "out").exists()
