"""What the figures of a simulation say about its bands."""

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.report.simulation_figures import draw_quantity
from multilayer.simulation import SimulationFile, simulate
from tests.simulation.files import PANEL


def drawn(frequency, tmp_path):
    data = parse_yaml(PANEL, tmp_path / "panel.yaml").data
    result = simulate(SimulationFile.model_validate({**data, "frequency": frequency}))
    return result, draw_quantity(result, "transmission_loss", result.cases[0].transmission_loss).axes[0]


@pytest.mark.parametrize(("width", "ratio"), [("third octaves", 0.1), ("octaves", 0.3)])
def test_bands_are_steps_between_their_edges(width, ratio, tmp_path):
    result, axes = drawn({width.replace(" ", "_"): [125, 2000]}, tmp_path)
    assert axes.get_xlabel() == f"frequency / Hz, {width}"
    (steps,) = axes.patches
    np.testing.assert_allclose(np.diff(np.log10(steps.get_data().edges)), ratio)
    np.testing.assert_array_equal(steps.get_data().values, result.cases[0].transmission_loss)
    np.testing.assert_allclose(axes.get_xlim(), steps.get_data().edges[[0, -1]])
    assert [tick.get_text() for tick in axes.get_xticklabels()] == ["125", "250", "500", "1k", "2k"]


def test_single_frequencies_are_a_line(tmp_path):
    _, axes = drawn([100.0, 200.0, 400.0], tmp_path)
    assert axes.get_xlabel() == "frequency / Hz"
    assert len(axes.patches) == 0
