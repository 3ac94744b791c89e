"""What the figures of a simulation say about its bands."""

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.report.simulation_figures import draw_losses, draw_quantity
from multilayer.simulation import SimulationFile, simulate
from multilayer.simulation.bands import band_grid
from multilayer.simulation.run import plan, run
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


def test_nothing_is_drawn_between_bands_that_are_not_adjacent(tmp_path):
    """As where measured bands lack some: lines and percentiles end at the edges of their own."""
    data = parse_yaml(PANEL, tmp_path / "panel.yaml").data
    simulation = SimulationFile.model_validate(
        {**data, "frequency": {"third_octaves": [100, 1000]}, "tolerances": {"layers.gap.thickness": "5 %"},
         "samples": 3, "layer_losses": True}
    )  # fmt: skip
    result = run(plan(simulation, "panel", band_grid(np.array([100.0, 125.0, 400.0, 1000.0]), "third octaves")))
    loss = result.cases[0].transmission_loss
    axes = draw_quantity(result, "transmission_loss", loss).axes[0]
    drawn = [patch.get_data() for patch in axes.patches]
    assert len(drawn) == 2  # percentiles and the nominal stack
    for steps in drawn:
        np.testing.assert_allclose(np.log10(steps.edges), 1.95 + 0.1 * np.arange(12))
        assert np.flatnonzero(np.isfinite(steps.values)).tolist() == [0, 1, 6, 10]
    (measured,) = axes.lines
    np.testing.assert_array_equal(measured.get_ydata()[[0, 1, 6, 10]], loss)
    assert np.isnan(measured.get_ydata()).sum() == 7
    for patch in draw_losses(result).axes[0].patches:
        assert np.flatnonzero(np.isfinite(patch.get_data().values)).tolist() == [0, 1, 6, 10]


def test_single_frequencies_are_a_line(tmp_path):
    _, axes = drawn([100.0, 200.0, 400.0], tmp_path)
    assert axes.get_xlabel() == "frequency / Hz"
    assert len(axes.patches) == 0
