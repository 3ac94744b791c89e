"""The search's coarse figures beside those of a simulation."""

import pickle

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.optimisation import search
from multilayer.optimisation.predict import Predictor
from multilayer.optimisation.run import _anchors, _Run, evaluated
from multilayer.optimisation.search import GlobalSearch, Point, Problem, Screen
from multilayer.simulation.bands import grid_of
from tests.optimisation.test_known_answers import FOAM, TWO, read

PLATE = {"type": "elastic_plate", "thickness": 2e-3, "density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.3}
RIBBED = {
    **PLATE, "type": "ribbed_plate", "rib_height": 0.01, "rib_width": 2e-3, "rib_spacing": 0.1, "loss_factor": 0.05,
}  # fmt: skip
WALL = {
    "layers": [{**PLATE, "name": "plate", "loss_factor": 0.02}, {**FOAM, "thickness": 0.05}],
    "termination": "ambient",
    "frequency": {"octaves": [125, 2000]},
    "design": {"layers.plate.thickness": [1e-3, 4e-3]},
    "goal": {"highest": "transmission_loss"},
}
RESONATORS = {
    "layers": [
        {
            "type": "helmholtz_resonators", "name": "r", "neck_radius": 2e-3, "neck_length": 5e-3, "pitch": 0.02,
            "cavity_depth": 0.03,
        }
    ],
    "frequency": [500.0],
    "design": {"layers.r.neck_radius": [1e-3, 9e-3], "layers.r.pitch": [0.01, 0.04]},
    "goal": [{"highest": "absorption"}, {"lowest": "thickness"}],
}  # fmt: skip
DIFFUSE = {"diffuse": {"max_angle": 90, "weighting": "gaussian"}}
CASES = {
    "normal": TWO,
    "diffuse": {**TWO, "incidence": "diffuse"},
    "finite absorber": {**TWO, "incidence": DIFFUSE, "finite_size": {"width": 1.2, "height": 1.0}},
    "oblique wall": {**WALL, "incidence": 45},
    "wall in a diffuse field": {**WALL, "incidence": "diffuse"},
    "finite wall": {**WALL, "incidence": DIFFUSE, "finite_size": {"width": 1.4, "height": 1.1}},
    "insertion loss": {
        **WALL, "goal": {"highest": "insertion_loss"}, "incidence": 30,
        "reference": {"layers": [PLATE], "termination": "ambient"},
    },
    "ribbed": {
        **WALL, "layers": [{**RIBBED, "name": "plate"}], "incidence": "diffuse", "frequency": {"octaves": [125, 250]},
    },
}  # fmt: skip


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
@pytest.mark.parametrize("name", CASES)
def test_near_the_simulation(name):
    file = read(**CASES[name])
    (variant,) = file.space.variants()
    predictor = Predictor(variant, grid_of(file.frequency), {}, file.goals)
    x = np.full((3, len(variant.ranges)), [[0.2], [0.5], [0.8]])
    figures = predictor.figures(variant, x)
    for i, row in enumerate(x):
        quantities = evaluated(file, variant, row).case.quantities
        for quantity, spectrum in figures.quantities.items():
            tolerance = 0.01 if quantity == "absorption" else 0.5
            assert spectrum[i] == pytest.approx(quantities[quantity], abs=tolerance), quantity


THIRDS = {"incidence": "diffuse", "frequency": {"third_octaves": [80, 5000]}}
RATED = {
    "ratings of absorption": {
        **TWO, **THIRDS,
        "goal": [{"highest": name} for name in ("alpha_w", "NRC", "SAA", "absorption")],
        "limits": [
            {"of": "thickness", "at_most": 0.06}, {"of": "absorption", "at_least": 0.3, "from": 500, "to": 2000}
        ],
    },
    "ratings of losses": {
        **WALL, **THIRDS,
        "goal": [{"highest": name} for name in ("Rw", "Rw+Ctr", "STC", "OITC")],
        "limits": [{"of": "mass", "at_most": 10}, {"of": "price", "at_most": 100}],
        "catalogue": {"plate": {"price_per_mass": 2.0}, "foam": {"density": 30.0, "price_per_volume": 200.0}},
    },
}  # fmt: skip


@pytest.fixture
def exact(monkeypatch):
    monkeypatch.setattr(search, "FEW_FIELDS", 0)


def problem_at(data, x):
    """Return a problem, its only variant, and a point."""
    file = read(**data)
    variant = file.space.variants()[0]
    margins = np.zeros(len(file.bounds))
    problem = Problem(grid_of(file.frequency), file.goals, file.bounds, file.catalogue, variant, margins)
    x = np.full(len(variant.ranges), x)
    return problem, variant, Point(x, *(values[0] for values in problem.measure(variant, x[None])))


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")
@pytest.mark.parametrize("name", [*CASES, *RATED])
def test_slopes_are_central_differences(name, exact, monkeypatch):
    problem, variant, here = problem_at({**CASES, **RATED}[name], 0.37)
    step, n = 1e-4, len(here.x)
    points = here.x + step * np.concatenate([factor * np.eye(n) for factor in (1, -1, 2, -2)])
    near = [values.reshape(4, n, -1) for values in problem.measure(variant, points)]
    monkeypatch.setattr(Problem, "differences", None)  # exact slopes do without
    for slope, (above, below, far_above, far_below) in zip(problem.slopes(variant, here), near, strict=True):
        central = (8 * (above - below) - (far_above - far_below)) / (12 * step)
        assert slope == pytest.approx(central, rel=1e-6, abs=1e-6 * np.max(np.abs(central), initial=0.0))


def test_slopes_where_there_is_no_response_are_differences(exact):
    """A neck as wide as the cavity is refused; the design beside it is not."""
    problem, variant, here = problem_at(RESONATORS, np.array([1.0, 0.0]))
    assert np.isinf(here.goals).all()
    of_goals, _ = problem.slopes(variant, here)
    assert not np.isfinite(of_goals).any()


def test_designs_that_are_not_allowed_have_no_figures():
    """Cavities that are narrower than their necks: each field is within its bounds, both together are refused."""
    file = read(**RESONATORS)
    (variant,) = file.space.variants()
    problem = Problem(grid_of(file.frequency), file.goals, (), {}, variant, np.zeros(0))
    goals, _ = problem.measure(variant, np.array([[0.0, 1.0], [1.0, 0.0]]))
    assert np.isfinite(goals[0]).all()
    assert np.isinf(goals[1]).all()


def test_searches_go_to_other_processes():
    file = read(**{**TWO, "design": {**TWO["design"], "order": ["foam", "gap"]}})
    variant = file.space.variants()[0]
    problem = Problem(grid_of(file.frequency), file.goals, (), {}, variant, np.zeros(0))
    screen = pickle.loads(pickle.dumps(Screen(problem, variant, 4, 0)))
    run = _Run(file, "", None, print, archive=screen())
    search = GlobalSearch(problem, file.space, next(_anchors(run, 1)), 1)
    assert pickle.loads(pickle.dumps(search)).space.variant((1,)).label == "order = gap, foam"


PROFILED = {
    **PLATE, "type": "corrugated_plate", "thickness": 1e-3, "period": 0.2, "height": 0.05, "crest_width": 0.05,
    "name": "sheet",
}  # fmt: skip
MOSAIC = {
    "type": "patches", "name": "sheet", "period": 0.06,
    "patches": [
        {"share": 0.7, "layers": [{**FOAM, "name": "foam", "thickness": 0.05}]},
        {"share": 0.3, "layers": [{"type": "fluid", "thickness": 0.08}]},
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    ("layer", "depth", "volume"),
    [  # trapezoids of 45 degrees: two flats of a quarter of the period, and two flanks of that times the root of two
        (PROFILED, 0.051, 1e-3 * (0.5 + 0.5 * np.sqrt(2))),
        ({**RIBBED, "name": "sheet"}, 0.012, 2e-3 + 0.01 * 2e-3 / 0.1),
        (MOSAIC, 0.08, 0.08),
    ],
)
def test_thickness_is_of_the_envelope_and_mass_and_price_of_the_material(layer, depth, volume):
    """A catalogue that states the density and price of the material, whatever becomes of it."""
    file = read(
        layers=[layer, {"type": "fluid", "name": "gap", "thickness": 0.1}], frequency=[500.0],
        design={"layers.gap.thickness": [0.05, 0.15]},
        goal=[{"lowest": "thickness"}, {"lowest": "mass"}, {"lowest": "price"}],
        catalogue={"sheet": {"density": 2700.0, "price_per_volume": 1000.0}},
    )  # fmt: skip
    (variant,) = file.space.variants()
    predictor = Predictor(variant, grid_of(file.frequency), file.catalogue, file.goals)
    sizes = predictor.measures(variant, np.array([[0.5]]))
    expected = {"thickness": 0.1 + depth, "mass": 2700 * volume, "price": 1000 * volume}
    assert {name: size.item() for name, size in sizes.items()} == pytest.approx(expected)


def test_a_size_takes_the_same_gas_on_both_sides():
    water = {"type": "fluid", "density": 1000.0, "sound_speed": 1480.0}
    file = read(**{**CASES["finite wall"], "termination": water})
    (variant,) = file.space.variants()
    with pytest.raises(InputError, match=r"^finite_size: .* leave the size out"):
        Predictor(variant, grid_of(file.frequency), {}, file.goals)
