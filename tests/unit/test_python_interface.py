"""What a notebook uses: paths in, results that draw and show themselves."""

import matplotlib
import numpy as np
import pytest

import multilayer
from multilayer import InputError, Stack, diagnose_campaign, fit_campaign, plane_wave, simulate
from multilayer.layers import LAYERS
from tests.examples.test_examples import EXAMPLES
from tests.report.diagnoses import diagnosis

matplotlib.use("Agg")


def test_the_version_is_that_of_the_package():
    assert multilayer.__version__.count(".") == 2


def test_a_fit_takes_a_path_and_draws_itself():
    result = fit_campaign(EXAMPLES / "foam_b")
    axes = result.plot("E1_pa")
    assert axes.get_ylabel() == "E1_pa / Pa"
    assert result.plot("E2_pa", axes) is axes
    line = axes.containers[0].lines[0]
    assert line.get_xdata().tolist() == sorted(burst.frequency for burst in result.bursts)
    assert axes.containers[0].has_yerr
    with pytest.raises(InputError, match="did you mean 'E1_pa'"):
        result.plot("E1_kpa")


def test_a_simulation_and_a_response_draw_themselves():
    axes = simulate(EXAMPLES / "foam_absorption.yaml").plot("absorption")
    assert axes.get_xlabel() == "frequency / Hz"
    stack = Stack(layers=[{"type": "equivalent_fluid", "model": "miki", "flow_resistivity": 1e4, "thickness": 0.05}])
    response = plane_wave(stack, np.geomspace(100, 1000, 5), [0.0, 60.0])
    assert len(response.plot("reflection").containers) == 2


def test_a_diagnosis_shows_itself_in_a_line_and_draws_moduli():
    made = diagnosis()
    assert repr(made) == f"Diagnosis of foam_b: {made.record['sentence']}"
    assert [axis.get_ylabel() for axis in made.plot()] == ["E1 / Pa", "E2 / Pa"]


def test_mistakes_in_python_are_input_errors():
    with pytest.raises(InputError, match=r"layers\.0\.thickness: -1\.0 is not allowed: it must be above 0"):
        Stack(layers=[{"type": "fluid", "thickness": -1}])
    with pytest.raises(InputError, match="colour: there is no such field"):
        LAYERS["fluid"](thickness=1, colour="red")


def test_an_equivalent_fluid_names_its_model():
    assert "model='miki'" in repr(LAYERS["equivalent_fluid"](model="miki", flow_resistivity=1e4, thickness=0.05))


def test_a_diagnosis_takes_a_path():
    with pytest.raises(InputError, match="no_such"):
        diagnose_campaign(EXAMPLES / "no_such")
