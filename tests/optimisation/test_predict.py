"""The search's coarse figures beside those of a simulation."""

import pickle

import numpy as np
import pytest

from multilayer.optimisation.predict import Predictor
from multilayer.optimisation.run import _anchors, _Run, evaluated
from multilayer.optimisation.search import GlobalSearch, Problem, Screen
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


def test_designs_that_are_not_allowed_have_no_figures():
    """Cavities that are narrower than their necks: each field is within its bounds, both together are refused."""
    file = read(
        layers=[
            {
                "type": "helmholtz_resonators", "name": "r", "neck_radius": 2e-3, "neck_length": 5e-3, "pitch": 0.02,
                "cavity_depth": 0.03,
            }
        ],
        frequency=[500.0],
        design={"layers.r.neck_radius": [1e-3, 9e-3], "layers.r.pitch": [0.01, 0.04]},
        goal=[{"highest": "absorption"}, {"lowest": "thickness"}],
    )  # fmt: skip
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
