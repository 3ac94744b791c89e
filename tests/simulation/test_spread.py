"""Which tolerance the scatter comes from."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from multilayer.paths import locate, with_values
from multilayer.report.simulation import simulation_report
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.run import plan, simulate
from multilayer.simulation.tasks import run_task

F = [125.0, 500.0, 2000.0]
BOARD = {
    "type": "elastic_plate", "name": "board", "thickness": 0.0125, "density": 700.0, "young_modulus": 2.5e9,
    "poisson_ratio": 0.25, "loss_factor": 0.02,
}  # fmt: skip
WOOL = {"type": "equivalent_fluid", "name": "wool", "thickness": 0.05, "model": "miki", "flow_resistivity": 8e3}
DENSITY = "layers.board.density"
SLIGHT = {
    "layers.wool.flow_resistivity": {"normal": "2 %"},
    "layers.board.thickness": {"normal": "1 %"},
    DENSITY: {"normal": "1 %"},
}
LOW = {"octaves": [63.0, 125.0]}
THIRDS = {"third_octaves": [400.0, 500.0]}


def simulation(**more):
    data = {"layers": [WOOL, BOARD], "termination": "ambient", "frequency": F, "tolerances": SLIGHT, "samples": 40}
    return SimulationFile.model_validate(data | more)


def case_of(**more):
    (case,) = simulate(simulation(**more)).cases
    return case


@pytest.mark.parametrize(("path", "rtol"), [(DENSITY, 1e-7), ("ambient.pressure", 1e-3)])
def test_mass_law(path, rtol):
    """By a derivative and by differences: the loss is 10 lg (1 + x^2), x = omega m / (2 rho c)."""
    file = simulation(layers=[BOARD], tolerances={path: {"normal": "3 %"}}, samples=500)
    (case,) = simulate(file).cases
    deviation = plan(file).tasks[0].deviations[path] / locate(file.stack, path).value
    assert deviation == pytest.approx(0.03, rel=0.1)
    x = np.pi * np.array(F) * 700.0 * 0.0125 / file.ambient.gas.impedance
    expected = 20 / np.log(10) * x**2 / (1 + x**2) * deviation
    (found,) = case.spread["transmission_loss"].values()
    np.testing.assert_allclose(found, expected, rtol=rtol)


@pytest.mark.parametrize(
    "more",
    [
        {},
        {"incidence": 60.0},
        {"incidence": 60.0, "finite_size": {"width": 1.4, "height": 1.1}},
        {"incidence": "diffuse"},
        {"incidence": "diffuse", "finite_size": {"width": 1.4, "height": 1.1}},
        {"frequency": THIRDS, "incidence": 30.0},
        {"frequency": THIRDS, "incidence": "diffuse"},
        # the panel's size weighs the frequencies of a band otherwise
        {"frequency": LOW, "incidence": 60.0, "finite_size": {"width": 0.8, "height": 0.6}},
        {"excitation": {"type": "tapping_machine"}, "layers": [BOARD, WOOL]},
        {"area": 10.0, "beside": [{"type": "flanking", "transmission_loss": 30.0}]},
    ],
    ids=str,
)
def test_slopes_of_what_is_computed(more):
    task = replace(plan(simulation(**more)).tasks[0], effort={"tolerance": 1e-7, "tolerance_db": 1e-6})
    spread = run_task(task).spread
    assert {"absorption", "transmission_loss"} <= spread.keys()
    for path, deviation in task.deviations.items():
        value, step = locate(task.stack, path).value, 1e-3
        above, below = (
            run_task(replace(task, stack=with_values(task.stack, {path: value * (1 + s)}), deviations={})).quantities
            for s in (step, -step)
        )
        for name, of_fields in spread.items():
            slope = np.abs(above[name] - below[name]) / (2 * step * value)
            largest = np.max([*of_fields.values()])
            np.testing.assert_allclose(of_fields[path], slope * deviation, rtol=2e-3, atol=1e-3 * largest)


def test_contributions_add_up_to_the_scatter_of_the_samples():
    case = case_of(samples=3000, incidence=45.0)
    for name, column in (("absorption", "absorption"), ("transmission_loss", "transmission_loss_db")):
        low, _, high = case.percentiles[column]
        whole = np.sqrt(np.sum(np.square([*case.spread[name].values()]), axis=0))
        np.testing.assert_allclose(whole, (high - low) / (2 * 1.645), rtol=0.06)


def test_a_share_of_a_complex_modulus_is_that_of_its_real_part_with_a_loss_factor():
    tolerances = {"layers.board.young_modulus": "10 %"}
    plate = {**BOARD, "young_modulus": "2.5e9+5e7j", "loss_factor": 0.0}
    expected = case_of(layers=[BOARD], tolerances=tolerances, incidence=80.0, frequency=[2000.0])
    found = case_of(layers=[plate], tolerances=tolerances, incidence=80.0, frequency=[2000.0])
    for name, of_fields in expected.spread.items():
        np.testing.assert_allclose(
            found.spread[name]["board.young_modulus"], of_fields["board.young_modulus"], rtol=0.02
        )


def test_at_a_bound_the_slope_is_to_one_side():
    more = {"excitation": {"type": "point_force", "radius": 0.01}, "layers": [{**BOARD, "loss_factor": 0.0}, WOOL]}
    case = case_of(tolerances={"layers.board.loss_factor": 0.01}, **more)
    (found,) = case.spread["sound_power_level"].values()
    assert np.all(np.isfinite(found))
    assert np.all(found > 0)


def test_insertion_loss_scatters_as_the_transmission_loss(tmp_path):
    reference = tmp_path / "gap.yaml"
    reference.write_text(
        "kind: stack\nversion: 1\ntermination: ambient\nlayers:\n  - {type: fluid, thickness: 10 mm}\n"
    )
    case = case_of(reference=str(reference))
    for path, values in case.spread["transmission_loss"].items():
        np.testing.assert_array_equal(case.spread["insertion_loss"][path], values)


def test_each_case_has_its_own_whatever_the_executor():
    file = simulation(sweep={"layers.wool.thickness": [0.02, 0.1]})
    here = simulate(file)
    with ProcessPoolExecutor(2) as pool:
        there = simulate(file, pool)
    assert here.to_csv() == there.to_csv()
    first, second = (case.spread["absorption"]["wool.flow_resistivity"] for case in here.cases)
    assert np.all(first != second)


def test_table_report_and_figure():
    result = simulate(simulation(sweep={"layers.wool.thickness": [0.02, 0.1]}))
    assert "transmission_loss_db_sd_from_board.density" in result.to_csv().splitlines()[0].split(",")
    assert len(result.to_dict()["cases"][1]["absorption_sd_from_wool.flow_resistivity"]) == len(F)
    report = simulation_report(result)
    (section,) = (section for section in report.sections if section.title == "Scatter")
    (listing,) = section.listings
    assert [row[0] for row in listing.rows][-1] == "wool.flow_resistivity"
    assert "transmission loss / dB" in listing.caption
    assert " to " in listing.rows[-1][1]
    figure = report.figures["scatter.png"]()
    assert len(figure.axes) == 2
    for axis in figure.axes:
        top = max(np.max(line.get_ydata()) for line in axis.lines)
        assert axis.get_ylim()[1] > top


def test_shares_of_one_case_are_a_whole():
    report = simulation_report(simulate(simulation()))
    (section,) = (section for section in report.sections if section.title == "Scatter")
    shares = [int(row[1].rstrip("%")) for row in section.listings[0].rows]
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) == pytest.approx(100, abs=2)
