"""Tables that simulations write, read as measurements."""

import numpy as np
import pytest

from multilayer.csv_table import csv_table, rows_of
from multilayer.errors import InputError
from multilayer.simulation.file import SimulationFile
from multilayer.simulation.measured import read_measured
from multilayer.simulation.run import simulate

FACE = {"type": "elastic_solid", "thickness": 1e-3, "density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}
FOAM = {**FACE, "name": "foam", "thickness": 0.025, "density": 30.0, "young_modulus": 1.5e5, "loss_factor": 0.3}
DAMPED = {**FACE, "loss_factor": 1e-3}
SANDWICH = {"layers": [DAMPED, FOAM, DAMPED], "termination": "ambient"}
WOOL = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.05, "flow_resistivity": 8e3}


@pytest.fixture
def read(tmp_path):
    """Give a function that reads a text as a table of measured spectra."""

    def read_text(text, quantity=None):
        (tmp_path / "simulation.csv").write_text(text)
        return read_measured(tmp_path / "simulation.csv", quantity)

    return read_text


@pytest.mark.parametrize(
    "data",
    [
        {"layers": [WOOL], "termination": "rigid", "duct": {"height": 0.1}},
        {"layers": [DAMPED], "termination": "ambient", "excitation": {"type": "point_force", "radius": 0.01}},
        {"layers": [DAMPED], "termination": "ambient", "free_waves": True},
    ],
)
def test_every_column_has_its_unit(read, data):
    result = simulate(SimulationFile.model_validate({**data, "frequency": [200.0, 500.0]}))
    measured = read(result.to_csv())
    (case,) = result.cases
    assert measured.quantities.keys() == case.quantities.keys()
    for name, values in measured.quantities.items():
        np.testing.assert_allclose(values, case.quantities[name], rtol=1e-8)


def test_names_of_others_need_their_unit(read):
    assert read("f_hz, bending_stiffness [kN m]\n100, 2\n").quantities["bending_stiffness"] == 2000
    with pytest.raises(InputError, match=r"'Bending stiffness' has no unit; write 'bending_stiffness \[N m\]'"):
        read("f_hz, Bending stiffness\n100, 2\n")
    with pytest.raises(InputError, match="'transmission_loss' has no unit"):
        read("f_hz, transmission_loss\n100, 2\n")


def test_what_there_is_not_is_an_empty_cell_and_left_out(read):
    frequency = np.geomspace(20, 2000, 60)
    (case,) = simulate(
        SimulationFile.model_validate({**SANDWICH, "frequency": frequency.tolist(), "free_waves": True})
    ).cases
    none = np.isnan(case.quantities["phase_speed"])
    assert 0 < np.count_nonzero(none) < 60
    rows = zip(frequency, case.quantities["phase_speed"], case.quantities["absorption"], strict=True)
    text = csv_table(["frequency_hz", "phase_speed", "absorption"], rows)
    assert "nan" not in text
    whole = read(text)
    np.testing.assert_array_equal(np.isnan(whole.quantities["phase_speed"]), none)
    np.testing.assert_allclose(whole.quantities["absorption"], case.absorption, rtol=1e-8)
    alone = read(text, "phase_speed")
    np.testing.assert_allclose(alone.frequency, frequency[~none], rtol=1e-8)
    assert np.all(np.isfinite(alone.quantities["phase_speed"]))


def test_gaps_follow_their_frequencies(read):
    measured = read(
        "f_hz, absorption, reflection_re, reflection_im\n500, 0.5, 1, 2\n100, , 3, 4\n300, 0.3, 5, \n200,,,\n"
    )
    assert measured.frequency.tolist() == [100, 300, 500]
    np.testing.assert_array_equal(measured.quantities["absorption"], [np.nan, 0.3, 0.5])
    np.testing.assert_array_equal(np.isnan(measured.quantities["reflection"]), [False, True, False])
    assert measured.quantities["reflection"][0] == 3 + 4j


def test_a_column_without_any_value_is_not_there(read):
    assert [*read("f_hz, absorption, il_db\n100, 0.5,\n").quantities] == ["absorption"]
    with pytest.raises(InputError, match=r"simulation.csv:1: holds no values of insertion_loss: all cells are empty"):
        read("f_hz, il_db\n100, \n")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (", 0.5\n", "csv:2: '' is no number"),
        ("100\n", "csv:2: has 1 cells and lacks some"),
        ("100, nan\n", "csv:2: 'nan' is not finite"),
    ],
)
def test_what_still_is_refused(read, text, words):
    with pytest.raises(InputError, match=words):
        read(f"f_hz, absorption\n{text}")


def test_nan_is_an_empty_cell():
    assert rows_of(csv_table(["a", "b"], [[np.nan, float("nan")], [np.inf, np.float64(2)]])) == [
        ["a", "b"], ["", ""], ["inf", "2"],
    ]  # fmt: skip
