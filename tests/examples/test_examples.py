"""Every example runs and gives the number it gave before: none can be added without a check, or rot unnoticed."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from multilayer.measurements.campaign import load_campaign, load_recordings
from multilayer.media.rod import rod_transmissibility
from multilayer.response import base_motion, plane_wave
from multilayer.rig.file import load_rig
from multilayer.stack import load_stack
from tests.cli.command import result_names, run
from tests.examples.make_foam_tube import table as foam_tube_table
from tests.examples.make_raw_tube import tables as raw_tube_tables

EXAMPLES = Path(__file__).parents[2] / "examples"


def foam_b(source, folder):
    """Fit the bursts with the settings that lie beside them."""
    done = run("fit", source, "--out", folder, "--no-figures")
    assert (done.status, done.err) == (0, "")
    rows = list(csv.DictReader((folder / "moduli.csv").read_text().splitlines()))
    assert len(rows) == 15
    assert {row["accepted"] for row in rows} == {"true"}
    found = {float(row["frequency_hz"]): float(row["E1_pa"]) for row in rows}
    assert found[500] == pytest.approx(239.3e3, rel=0.005)
    assert found[1500] == pytest.approx(324.5e3, rel=0.005)


def three_layers(source, folder):
    """At normal incidence a foam under a plate is a rod of its P-wave modulus under a mass."""
    stack = load_stack(source)
    frequency = 200.0
    foam, top = stack.layers[1:]
    assert (foam.name, top.name, stack.termination) == ("foam", "top_plate", "ambient")

    young, nu = complex(foam.young_modulus(frequency)), foam.poisson_ratio
    modulus = young * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    mass = top.density * top.thickness

    def rod(load):
        return complex(rod_transmissibility(frequency, modulus, foam.density, foam.thickness, load))

    found = complex(base_motion(stack, frequency).transmissibility)
    assert abs(found) == pytest.approx(2.694, rel=1e-3)

    # The air above loads the plate by rho c: with it, the plates' elasticity alone is left out. The base plate gives
    # way by the weight it carries over its stiffness, w^2 h (rho h / 2 + m) (rho c^2)^-1: 4e-6 at 200 Hz.
    omega = 2 * np.pi * frequency
    air = stack.ambient.gas.impedance / (1j * omega)
    assert found == pytest.approx(rod(mass + air), rel=2e-5)

    # Without the air, the error is its share of the moving mass, Z0 / (w m) = 4 %, times what the response gains or
    # loses by a heavier plate, d ln T / d ln m: 2.5 near the resonance.
    share = abs(air) / mass
    assert share == pytest.approx(0.042, rel=0.01)
    gain = abs(rod(mass * 1.001) / rod(mass) - 1) / 0.001
    assert abs(found / rod(mass) - 1) < 1.1 * share * gain


def simulated(source, folder):
    """Return the rows that ``multilayer simulate`` writes."""
    done = run("simulate", source, "--out", folder)
    assert (done.status, done.err) == (0, "")
    return list(csv.DictReader((folder / "simulation.csv").read_text().splitlines()))


def foam_absorption(source, folder):
    """The foam is a fluid of complex density and stiffness in front of a wall: Z = -i Zc cot(k h)."""
    rows = [row for row in simulated(source, folder) if row["case"] == "foam.thickness = 50 mm"]
    row = min(rows, key=lambda row: abs(float(row["frequency_hz"]) - 1000))
    assert float(row["absorption"]) == pytest.approx(0.869, abs=0.001)

    # Johnson, Champoux and Allard, with the numbers of the file
    gas = load_stack(source).ambient.gas
    thickness, porosity, resistivity, tortuosity, viscous, thermal = 0.05, 0.99, 1e4, 1.02, 1e-4, 1.5e-4
    omega = 2j * np.pi * float(row["frequency_hz"])
    drag = resistivity * porosity / (omega * gas.density * tortuosity)
    inertia = np.sqrt(
        1 + 4 * omega * gas.viscosity * gas.density * (tortuosity / (resistivity * viscous * porosity)) ** 2
    )
    density = tortuosity * gas.density / porosity * (1 + drag * inertia)
    heat = omega * gas.density * gas.prandtl * thermal**2 / gas.viscosity
    ratio = gas.heat_capacity_ratio
    stiffness = ratio * gas.pressure / porosity / (ratio - (ratio - 1) / (1 + 8 / heat * np.sqrt(1 + heat / 16)))
    impedance = np.sqrt(density * stiffness) / np.tanh(omega * np.sqrt(density / stiffness) * thickness)
    reflection = (impedance - gas.impedance) / (impedance + gas.impedance)
    assert float(row["absorption"]) == pytest.approx(1 - abs(reflection) ** 2, rel=1e-6)
    assert float(row["absorption_p05"]) < float(row["absorption"]) < float(row["absorption_p95"])


def double_wall(source, folder):
    """Far below its resonance the wall is one mass; above, the table has what it had before."""
    rows = {row["frequency_hz"]: row for row in simulated(source, folder) if row["case"] == "incidence = 45 deg"}
    assert len(rows) == 18
    assert float(rows["1000"]["transmission_loss_db"]) == pytest.approx(57.2, abs=0.1)

    stack, frequency = load_stack(source), 20.0
    mass = sum(layer.density * layer.thickness for layer in (stack.layers[0], stack.layers[3]))
    mass += stack.layers[1].frame_density * stack.layers[1].thickness
    pull = np.pi * frequency * mass * np.cos(np.pi / 4) / stack.ambient.gas.impedance
    found = plane_wave(stack, frequency, 45).transmission_loss
    assert found == pytest.approx(10 * np.log10(1 + pull**2), abs=0.02)


def steel_stud_wall(source, folder):
    """More passes than by the floor alone; studs that give way carry less above the resonance of the cavity."""
    losses = np.array([float(row["transmission_loss_db"]) for row in simulated(source, folder)]).reshape(3, 18)
    assert np.all(losses < 60)
    assert np.all(np.diff(losses[:, 4:12], axis=0) > 0)  # 250 Hz to 1250 Hz
    assert losses[:, 10] == pytest.approx([50.1, 59.6, 59.7], abs=0.1)


def duct_silencer(source, folder):
    """Narrow airways attenuate most, in all bands."""
    rows = simulated(source, folder)
    attenuation = np.array([float(row["duct_attenuation"]) for row in rows]).reshape(3, 22)
    assert np.all(np.diff(attenuation, axis=0) < 0)
    assert attenuation[1, 12] == pytest.approx(45.2, abs=0.1)  # 1 kHz


def best_absorber(source, folder):
    """The file of the best design gives, simulated by itself, the rating that the search tells, and weighs no more."""
    done = run("optimise", source, "--out", folder, "--no-figures")
    assert (done.status, done.err) == (0, "")
    record = json.loads((folder / "optimisation.json").read_text())
    best = record["designs"][0]
    assert best["goals"] == [0.75]
    assert best["goals_followed"][0] == pytest.approx(0.7323, abs=2e-4)
    stack = load_stack(folder / "best.yaml")
    thickness, mass = sum(layer.depth for layer in stack.layers), sum(layer.mass_per_area for layer in stack.layers)
    assert (thickness, mass) == pytest.approx(best["limits"])
    assert thickness <= 0.05 * (1 + 1e-6)
    assert mass <= 1.5 * (1 + 1e-6)
    done = run("simulate", folder / "best.yaml", "--out", folder.parent / "simulated", "--no-figures")
    assert "alpha_w 0.75" in done.out


def virtual_rig(source, folder):
    """The accelerometer is a mass on a rod, whatever the campaign says: E1 comes out 7 % low under the thin plate."""
    done = run("rig", source, "--out", folder)
    assert (done.status, done.err) == (0, "")
    truth = json.loads((folder.parent / "results.truth.json").read_text())
    assert (truth["effect"], truth["parameters"]["mass"]) == ("sensor_mass", 0.001)

    recordings = load_recordings(load_campaign(folder))
    assert len(recordings) == 20
    recording, frequency = recordings["h25mm-t1mm", 200.0], 200.0
    turn = np.exp(-2j * np.pi * frequency * recording.time)
    base, top = (channel @ turn for channel in recording.mean())
    assert abs(top / base) == pytest.approx(2.36, abs=0.01)

    law = load_rig(source).specimen.modulus(frequency)
    mass = 7.85 + 1e-3 / (np.pi * 0.0225**2)
    assert top / base == pytest.approx(complex(rod_transmissibility(frequency, law, 80, 0.025, mass)), rel=0.03)

    done = run("fit", folder, "--out", folder.parent / "fit", "--no-figures")
    assert (done.status, done.err) == (0, "")
    rows = list(csv.DictReader((folder.parent / "fit" / "moduli.csv").read_text().splitlines()))
    found = {(row["configuration"], float(row["frequency_hz"])): float(row["E1_pa"]) for row in rows}
    assert found["h25mm-t1mm", frequency] < 0.95 * law.real


def foam_tube(source, folder):
    """The fit finds what the table was computed from, which a file beside it says."""
    done = run("fit", source, "--out", folder, "--no-figures")
    assert (done.status, done.err) == (0, "")
    found = {row["name"]: row for row in csv.DictReader((folder / "parameters.csv").read_text().splitlines())}
    assert float(found["layers.foam.flow_resistivity"]["value"]) == pytest.approx(13687, rel=0.002)
    truth = load_stack(source / "truth.yaml").layers[0]
    for name, row in found.items():
        value, std = float(row["value"]), float(row["std"])
        assert row["determined"] == "true"
        assert abs(value - getattr(truth, name.rpartition(".")[2])) < 2.5 * std
    written, made = (
        np.loadtxt(text.splitlines(), delimiter=",", skiprows=2)
        for text in ((source / "tube.csv").read_text(), foam_tube_table())
    )
    assert written == pytest.approx(made, abs=1.01e-4)


def raw_tube(source, folder):
    """Two unlike microphones, exchanged, give the reflection of the foam that they were computed from."""
    done = run("tube", source, "--out", folder)
    assert (done.status, done.err) == (0, "")
    assert result_names(folder) == {"tube.csv", "tube.json", "tube.png"}
    rows = list(csv.DictReader((folder / "tube.csv").read_text().splitlines()))
    truth = plane_wave(load_stack(EXAMPLES / "foam_tube" / "truth.yaml"), [float(row["frequency_hz"]) for row in rows])
    found = np.array([complex(float(row["reflection_re"]), float(row["reflection_im"])) for row in rows])
    assert np.sqrt(np.mean(np.abs(found - truth.reflection) ** 2)) < 0.002
    assert {name: (source / name).read_text() for name in raw_tube_tables()} == raw_tube_tables()


ELSEWHERE = {"gallery", "reproducing"}  # see test_gallery.py and test_reproducing.py
LISTED = sorted(path for path in EXAMPLES.iterdir() if not path.name.startswith(".") and path.name not in ELSEWHERE)
CHECKS = {
    "best_absorber.yaml": best_absorber,
    "duct_silencer.yaml": duct_silencer,
    "double_wall.yaml": double_wall,
    "foam_absorption.yaml": foam_absorption,
    "foam_b": foam_b,
    "foam_tube": foam_tube,
    "raw_tube": raw_tube,
    "steel_stud_wall.yaml": steel_stud_wall,
    "three_layers.yaml": three_layers,
    "virtual_rig.yaml": virtual_rig,
}


def test_every_example_is_checked():
    assert {path.name for path in LISTED} == set(CHECKS)


@pytest.mark.parametrize("name", CHECKS)
def test_number(name, tmp_path):
    CHECKS[name](EXAMPLES / name, tmp_path / "results")


def test_no_mistakes_in_any():
    done = run("check", *LISTED)
    assert (done.status, done.err) == (0, "")
    assert len(done.out.splitlines()) == len(CHECKS)
