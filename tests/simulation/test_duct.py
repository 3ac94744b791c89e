"""Lined ducts of simulation files."""

import numpy as np
import pytest

from multilayer.report.simulation import simulation_report
from multilayer.response import duct_mode
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.run import simulate
from tests.cli.command import run

WOOL = {"type": "equivalent_fluid", "name": "wool", "model": "miki", "thickness": 0.05, "flow_resistivity": 8e3}
F = [125.0, 500.0, 2000.0]


def lined(**more):
    data = {"layers": [WOOL], "termination": "rigid", "frequency": F, "duct": {"height": 0.1}} | more
    return SimulationFile.model_validate(data)


def test_the_attenuation_is_that_of_the_mode():
    simulation = lined(duct={"height": 0.2, "lined": "one side", "mach": 0.1})
    (case,) = simulate(simulation).cases
    expected = duct_mode(simulation.stack, F, 0.2, "one side", 0.1).attenuation
    np.testing.assert_array_equal(case.columns["duct_attenuation"], expected)


def test_bands_sweeps_and_tolerances():
    simulation = lined(
        frequency={"octaves": [250.0, 1000.0]}, sweep={"duct.height": [0.1, 0.2]},
        tolerances={"layers.wool.thickness": "10 %"}, samples=3,
    )  # fmt: skip
    result = simulate(simulation)
    narrow, wide = (case.columns["duct_attenuation"] for case in result.cases)
    assert np.all(narrow > wide)
    assert np.all(result.cases[0].columns["duct_attenuation_p05"] < narrow * 1.1)
    report = simulation_report(result)
    assert "attenuation of the lined duct" in report.sentence
    assert "duct_attenuation.png" in report.figures


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("termination: ambient", "the lining of a duct ends at a wall that keeps sound in: write 'termination: rigid'"),
        (
            "termination: rigid\narea: 2\nbeside: [{type: patch, name: door, area: 1, "
            "stack: {termination: rigid, layers: [{type: fluid, thickness: 50 mm}]}}]",
            "is computed of a stack alone",
        ),
        ("termination: rigid\nduct: {height: 100 mm, mach: 1.2}", "must be below 1"),
        ("termination: rigid\nduct: {height: 100 mm, lined: all}", "one side"),
    ],
)
def test_what_no_duct_has(tmp_path, change, words):
    text = "layers:\n  - {type: screen, flow_resistance: 100}\n  - {type: fluid, thickness: 50 mm}\n" + change
    file = tmp_path / "duct.yaml"
    file.write_text(text if "duct:" in change else text + "\nduct: {height: 100 mm}\n")
    done = run("simulate", str(file), "--out", str(tmp_path / "out"))
    assert done.status == 2
    assert words in done.err
    assert "duct.yaml:" in done.err
    assert not (tmp_path / "out").exists()
