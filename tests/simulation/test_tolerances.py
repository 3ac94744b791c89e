"""Tolerances and what is drawn within them."""

import numpy as np
import pytest
from scipy.stats import kstest, norm, uniform

from multilayer.config import parse_yaml
from multilayer.errors import InputError
from multilayer.paths import locate
from multilayer.simulation import SimulationFile, tolerances
from multilayer.simulation.tolerances import allowed, draw
from multilayer.stack import Stack
from tests.cli.command import run
from tests.simulation.files import FOAM, FOAM_BESIDE_CHAMBER

THICKNESS, POROSITY = "layers.foam.thickness", "layers.foam.porosity"
LAW = "layers.foam.young_modulus"


@pytest.fixture
def simulation(tmp_path):
    """Give a function that returns the foam with tolerances."""

    def read(tolerances, **fields):
        data = parse_yaml(FOAM, tmp_path / "foam.yaml").data
        foam = {**data["layers"][0], **fields}
        return SimulationFile.model_validate({**data, "layers": [foam], "tolerances": tolerances})

    return read


def drawn(simulation, n=4000, seed=0):
    return draw(simulation.stack, simulation.scatter, n, seed)


@pytest.mark.parametrize(
    ("written", "expected"),
    [
        ("10 %", uniform(0.045, 0.01)),
        ("5 mm", uniform(0.045, 0.01)),
        (0.005, uniform(0.045, 0.01)),
        ({"uniform": "10 %"}, uniform(0.045, 0.01)),
        ({"uniform": ["40 mm", "70 mm"]}, uniform(0.04, 0.03)),
        ({"normal": "10 %"}, norm(0.05, 0.005)),
        ({"normal": "1 mm"}, norm(0.05, 0.001)),
        ({"normal": ["60 mm", "1 mm"]}, norm(0.06, 0.001)),
        ({"normal": [0.06, "5 %"]}, norm(0.06, 0.003)),
    ],
)
def test_distribution(simulation, written, expected):
    values = drawn(simulation({THICKNESS: written}))[THICKNESS]
    assert values.shape == (4000,)
    assert kstest(values, expected.cdf).pvalue > 0.01


def test_a_share_of_a_complex_value_keeps_its_loss_factor(simulation):
    values = drawn(simulation({LAW: "10 %"}, young_modulus="1e5+2e4j"))[LAW]
    np.testing.assert_allclose(values.imag / values.real, 0.2)
    assert 9e4 < values.real.min() < 9.1e4


def test_complex_values_have_no_mean_of_their_own(simulation):
    with pytest.raises(ValueError, match="a complex value scatters by a share"):
        simulation({LAW: {"normal": ["1e5", "1e4"]}}, young_modulus="1e5+2e4j")


def test_what_a_field_refuses_is_drawn_again(simulation):
    values = drawn(simulation({POROSITY: "5 %"}))[POROSITY]
    assert 0.95 * 0.98 < values.min() < 0.94
    assert 0.995 < values.max() < 1
    assert kstest(values, uniform(0.931, 0.069).cdf).pvalue > 0.01


def test_what_fields_refuse_together_is_drawn_again(simulation):
    law = {"law": "fractional_zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1.2e5, "order": 0.5}
    tolerances = {f"{LAW}.relaxed_modulus": "20 %", f"{LAW}.unrelaxed_modulus": "20 %"}
    low, high = drawn(simulation(tolerances, young_modulus={**law, "relaxation_time": 1e-3})).values()
    assert np.all(high >= low)
    assert np.any(high < 1.05e5)


def test_hardly_any_is_allowed(simulation):
    with pytest.raises(InputError, match=r"of layers.foam.porosity hardly any draw is allowed"):
        drawn(simulation({POROSITY: {"normal": [3, "1 %"]}}))


_PLATE = "{type: elastic_plate, thickness: 6 mm, density: 2500, young_modulus: 70 GPa, poisson_ratio: 0.22}"
WINDOW = f"""\
version: 1
layers: [{_PLATE}]
termination: ambient
area: 10 m2
beside:
  - {{type: patch, name: window, area: 9.5 m2, stack: {{layers: [{_PLATE}], termination: ambient}}}}
frequency: [100, 500]
"""


@pytest.mark.parametrize("share", ["5 %", "50 %"])
def test_shares_that_no_longer_make_a_whole(tmp_path, share):
    (tmp_path / "mix.yaml").write_text(f"{FOAM_BESIDE_CHAMBER}tolerances: {{layers.mix.patches.0.share: {share}}}\n")
    done = run("simulate", tmp_path / "mix.yaml", "--out", tmp_path / "out")
    assert done.status == 2
    assert done.err.startswith(f"{tmp_path / 'mix.yaml'}:13:13: tolerances: of layers.mix.patches.0.share hardly any")
    assert "is allowed (the shares sum up to " in done.err


@pytest.mark.parametrize("path", ["area", "beside.window.area"])
def test_what_the_wall_refuses_is_drawn_again(path):
    file = SimulationFile.model_validate(
        {**parse_yaml(WINDOW, "wall.yaml").data, "tolerances": {path: {"normal": "10 %"}}}
    )
    values = drawn(file, 500)[path]
    assert np.all(values > 9.5 if path == "area" else values < 10)
    assert np.std(values) > 0.3


def test_few_samples_may_take_many_rounds(simulation):
    # one draw in ten is allowed: two samples may be refused for longer than many would be without hope
    rare = simulation({POROSITY: {"normal": [1.0256, 0.02]}})
    for seed in range(20):
        assert np.all(drawn(rare, 2, seed)[POROSITY] <= 1)


def test_seed(simulation):
    scattered = simulation({THICKNESS: "10 %", POROSITY: "1 %"})
    first, again, other = (drawn(scattered, 50, seed) for seed in (1, 1, 2))
    for path in (THICKNESS, POROSITY):
        np.testing.assert_array_equal(first[path], again[path])
        assert np.all(first[path] != other[path])


def test_independent(simulation):
    thickness, porosity = drawn(simulation({THICKNESS: "10 %", POROSITY: "1 %"})).values()
    assert abs(np.corrcoef(thickness, porosity)[0, 1]) < 0.05


def test_one_instance_in_two_places_is_two_layers():
    plate = SimulationFile.model_validate(parse_yaml(WINDOW, "wall.yaml").data).layers[0]
    stack = Stack(layers=[plate, {"type": "fluid", "thickness": 0.1}, plate], termination="ambient")
    file = SimulationFile.model_validate(
        {**dict(stack), "tolerances": {"layers.0.thickness": {"normal": [0.001, 0.001]}, "layers.2.thickness": "1 %"}}
    )
    values = drawn(file, 500)
    assert np.all(values["layers.0.thickness"] > 0)


@pytest.mark.parametrize(
    "tolerances",
    [
        {THICKNESS: "10 %", POROSITY: "1 %"},
        {THICKNESS: "10 %", POROSITY: "5 %"},  # above 1 at one corner
        {f"{LAW}.relaxed_modulus": "5 %", f"{LAW}.unrelaxed_modulus": "5 %", THICKNESS: {"normal": "30 %"}},
        {f"{LAW}.relaxed_modulus": "20 %", f"{LAW}.unrelaxed_modulus": "20 %"},  # refused where they cross
    ],
)
def test_a_box_is_judged_as_each_draw_by_itself(simulation, tolerances):
    law = {"law": "fractional_zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1.2e5, "order": 0.5}
    file = simulation(tolerances, young_modulus={**law, "relaxation_time": 1e-3})
    rng, paths = np.random.default_rng(4), list(tolerances)
    fields = {path: locate(file.stack, path) for path in paths}
    values = {path: file.scatter[path].values(fields[path].value, rng.uniform(-1, 1, 200)) for path in paths}
    each = [allowed(fields, {path: values[path][i : i + 1] for path in paths}).item() for i in range(200)]
    np.testing.assert_array_equal(allowed(fields, values), each)


def test_draws_within_bounds_are_not_checked_one_by_one(simulation, monkeypatch):
    checked = []
    monkeypatch.setattr(tolerances, "_fits", lambda owner, values: checked.append(values) or True)
    drawn(simulation({THICKNESS: "10 %", LAW: "10 %"}, young_modulus="1e5+2e4j"), 100_000)
    assert len(checked) == 4  # corners of a box of two fields


def test_draws_in_a_wall_are_checked_at_their_corners_too(monkeypatch):
    checked, fits = [], tolerances._fits
    monkeypatch.setattr(tolerances, "_fits", lambda owner, values: checked.append(values) or fits(owner, values))
    file = SimulationFile.model_validate(
        {**parse_yaml(WINDOW, "wall.yaml").data, "tolerances": {"area": "1 %", "layers.0.thickness": "5 %"}}
    )
    drawn(file, 100_000)
    assert len(checked) == 6  # of the layer's field, and of both in the wall
