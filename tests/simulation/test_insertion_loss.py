"""Insertion losses: their means, and the air of their reference."""

import numpy as np
import pytest

from multilayer.config import parse_yaml
from multilayer.optimisation.aims import Figures
from multilayer.optimisation.file import OptimisationFile
from multilayer.report.simulation import simulation_report
from multilayer.response import plane_wave
from multilayer.response.bands import mean_loss
from multilayer.simulation import SimulationFile, simulate
from multilayer.simulation.quantities import mean_of
from multilayer.stack import Stack
from tests.simulation.files import PANEL

PLATE = {"type": "elastic_plate", "name": "plate", "thickness": 1e-3, "density": 2700, "young_modulus": 70e9}
PLATE |= {"poisson_ratio": 0.33, "loss_factor": 0.01}
BARE = {"layers": [PLATE], "termination": "ambient"}


def read(tmp_path, **further):
    data = parse_yaml(PANEL, tmp_path / "panel.yaml").data
    return SimulationFile.model_validate({**data, "reference": BARE, **further})


def band_losses(simulation, frequency):
    losses = [plane_wave(stack, frequency).transmission_loss for stack in (simulation.stack, simulation.reference)]
    return mean_loss(losses[0]) - mean_loss(losses[1])


def test_the_mean_is_the_difference_of_those_of_both_losses():
    loss, reference = np.array([[20.0, 60.0], [30.0, 30.0]]), np.array([40.0, 10.0])
    quantities = {"transmission_loss": loss, "insertion_loss": loss - reference, "absorption": np.zeros((2, 2))}
    np.testing.assert_allclose(mean_of("insertion_loss", quantities), mean_loss(loss) - mean_loss(reference))
    np.testing.assert_allclose(mean_of("transmission_loss", quantities), mean_loss(loss))


def test_tables_average_single_frequencies_so(tmp_path):
    """Across the resonance of the double wall, which its reference has not, the mean of quotients is 5 dB off."""
    frequency = np.geomspace(89.2, 5600, 600)
    simulation = read(tmp_path, frequency=frequency.tolist())
    report = simulation_report(simulate(simulation))
    (values,) = (part for section in report.sections for part in section.listings if not part.only)
    assert "insertion loss / dB, averages over third octaves" in values.caption
    shown = {float(row[0]): float(row[1]) for row in values.rows}
    for centre in (200.0, 250.0, 315.0, 1000.0):
        inside = frequency[np.abs(10 * np.log10(frequency) - np.round(10 * np.log10(centre))) < 0.5]
        assert shown[centre] == pytest.approx(band_losses(simulation, inside), abs=0.051)
    assert f"is {band_losses(simulation, frequency):.1f} dB on average" in report.sentence


def test_goals_of_an_optimisation_average_it_so(tmp_path):
    frequency = np.geomspace(150, 600, 60)
    data = parse_yaml(PANEL, tmp_path / "panel.yaml").data
    file = OptimisationFile.model_validate(
        {
            **data, "reference": BARE, "frequency": frequency.tolist(), "design": {"layers.gap.thickness": [0.02, 0.1]},
            "goal": {"highest": "insertion_loss"},
        }
    )  # fmt: skip
    simulation = read(tmp_path, frequency=frequency.tolist())
    (case,) = simulate(simulation).cases
    figures = Figures({name: values[None] for name, values in case.quantities.items()}, {})
    assert file.goals[0].true(figures) == pytest.approx(band_losses(simulation, frequency))


@pytest.mark.parametrize("incidence", [30, "diffuse"])
def test_the_reference_is_in_the_air_of_the_stack(tmp_path, incidence):
    """A wall over itself gains nothing, whatever the weather, and however far its draws scatter."""
    wall = {key: value for key, value in parse_yaml(PANEL, tmp_path / "panel.yaml").data.items() if key != "version"}
    more = {"reference": wall, "frequency": [200.0, 1000.0], "incidence": incidence}
    swept = simulate(read(tmp_path, **more, sweep={"ambient.temperature": ["-10 degC", "40 degC"]}))
    stated = simulate(read(tmp_path, **more, ambient={"pressure": 80e3}))
    for case in (*swept.cases, *stated.cases):
        np.testing.assert_allclose(case.insertion_loss, 0, atol=1e-9)
    drawn = simulate(read(tmp_path, **more, tolerances={"ambient.temperature": "20 K"}, samples=4)).cases[0]
    np.testing.assert_allclose(drawn.percentiles["insertion_loss_db"], 0, atol=1e-9)
    np.testing.assert_allclose(drawn.spread["insertion_loss"]["ambient.temperature"], 0, atol=1e-9)


def test_the_references_own_air_does_not_count(tmp_path):
    cold = {**BARE, "ambient": {"temperature": 250.0}}
    (own,), (other,) = (simulate(read(tmp_path, frequency=[500.0], reference=bare)).cases for bare in (BARE, cold))
    np.testing.assert_array_equal(own.insertion_loss, other.insertion_loss)
    assert Stack.model_validate(cold).ambient.temperature == 250
