"""Simulations of the power that each layer loses."""

import numpy as np
import pytest
from pydantic import ValidationError

from multilayer.report.simulation import simulation_report
from multilayer.response import power_balance
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.run import simulate

BOARD = {
    "type": "elastic_solid", "name": "board", "thickness": 0.0125, "density": 700.0, "young_modulus": 2.5e9,
    "poisson_ratio": 0.3, "loss_factor": 0.02,
}  # fmt: skip
WOOL = {"type": "equivalent_fluid", "thickness": 0.05, "model": "miki", "flow_resistivity": 8e3}
F = [125.0, 500.0, 2000.0]


def wall(**more):
    data = {"layers": [WOOL, BOARD], "termination": "ambient", "frequency": F, "layer_losses": True} | more
    return SimulationFile.model_validate(data)


@pytest.mark.parametrize("incidence", ["normal", 60.0])
def test_shares_of_the_layers_and_what_gets_through_are_the_absorption(incidence):
    simulation = wall(incidence=incidence)
    (case,) = simulate(simulation).cases
    balance = power_balance(simulation.stack, F, simulation.incidence.angle)
    np.testing.assert_array_equal(case.columns["lost_in_0"], balance.dissipated[0])
    np.testing.assert_array_equal(case.columns["lost_in_board"], balance.dissipated[1])
    whole = case.columns["lost_in_0"] + case.columns["lost_in_board"] + 10 ** (-case.transmission_loss / 10)
    np.testing.assert_allclose(whole, case.absorption, atol=1e-10)


def test_in_bands_with_sweep_and_tolerances():
    simulation = wall(
        frequency={"octaves": [125.0, 1000.0]}, sweep={"layers.board.thickness": [0.01, 0.02]},
        tolerances={"layers.board.density": "5 %"}, samples=3,
    )  # fmt: skip
    result = simulate(simulation)
    for case in result.cases:
        whole = case.columns["lost_in_0"] + case.columns["lost_in_board"] + 10 ** (-case.transmission_loss / 10)
        np.testing.assert_allclose(whole, case.absorption, atol=1e-10)
        assert "lost_in_board_p05" not in case.columns
    assert "lost_in_board" in result.to_csv().splitlines()[0].split(",")
    report = simulation_report(result)
    assert "layer_losses.png" in report.figures
    assert len(report.figures["layer_losses.png"]().axes) == 2


def test_long_axes_are_as_short_ones():
    f = np.linspace(100.0, 1000.0, 5000).tolist()
    (case,) = simulate(wall(frequency=f)).cases
    (short,) = simulate(wall(frequency=f[4500:4600])).cases
    np.testing.assert_allclose(case.columns["lost_in_board"][4500:4600], short.columns["lost_in_board"], rtol=1e-12)


def test_a_lossless_layer_loses_nothing():
    gap = {"type": "fluid", "name": "gap", "thickness": 0.03}
    (case,) = simulate(wall(layers=[gap, WOOL], termination="rigid")).cases
    np.testing.assert_allclose(case.columns["lost_in_gap"], 0.0, atol=1e-12)
    np.testing.assert_allclose(case.columns["lost_in_1"], case.absorption, atol=1e-12)


@pytest.mark.parametrize(
    ("more", "message"),
    [
        ({"incidence": "diffuse"}, "one plane wave"),
        ({"area": 10.0, "beside": [{"type": "flanking", "transmission_loss": 50.0}]}, "of a stack alone"),
    ],
)
def test_what_has_no_shares_is_refused(more, message):
    with pytest.raises(ValidationError, match=message):
        wall(**more)


def test_columns_have_the_units_of_their_quantities():
    """A layer may be called as a column in dB is."""
    board = BOARD | {"name": "x_db"}
    toleranced = wall(layers=[WOOL, board], tolerances={"layers.x_db.density": "5 %"}, samples=3, frequency=[125.0])
    units = simulate(toleranced).frame.units | simulate(wall(layers=[BOARD], free_waves=True)).frame.units
    assert units["transmission_loss_db"] == units["transmission_loss_db_p05"] == "dB"
    assert units["transmission_loss_db_sd_from_x_db.density"] == "dB"
    assert (units["phase_speed"], units["bending_stiffness"]) == ("m/s", "N m")
    assert "lost_in_x_db" not in units
