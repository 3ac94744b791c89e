"""How much room layers take, and what they weigh."""

import numpy as np
import pytest

from multilayer.layers import LAYERS

MIKI = {"model": "miki", "thickness": 0.05, "flow_resistivity": 1e4}
HOLES = {"type": "perforated_plate", "thickness": 1e-3, "hole_radius": 1e-3, "perforation": 0.1}
PLATE = {"density": 2700, "young_modulus": 7e10, "poisson_ratio": 0.3}
CASES = [
    ({"type": "fluid", "thickness": 0.1}, 0.1, 0.0),
    ({"type": "fluid", "thickness": 0.1, "density": 1000}, 0.1, 100.0),
    ({"type": "elastic_plate", "thickness": 1e-3, **PLATE}, 1e-3, 2.7),
    ({"type": "membrane", "surface_density": 0.3}, 0.0, 0.3),
    ({"type": "screen", "flow_resistance": 400}, 0.0, None),
    ({"type": "screen", "flow_resistance": 400, "surface_density": 0.2}, 0.0, 0.2),
    ({"type": "equivalent_fluid", **MIKI}, 0.05, None),
    ({"type": "limp", **MIKI, "porosity": 0.98, "frame_density": 30}, 0.05, 1.5),
    (HOLES, 1e-3, None),
    ({**HOLES, "density": 2700}, 1e-3, 2.43),
    ({"type": "ribbed_plate", "thickness": 2e-3, "rib_height": 0.02, "rib_width": 2e-3, "rib_spacing": 0.1, **PLATE},
     0.022, 2700 * 2.4e-3),
    ({"type": "helmholtz_resonators", "neck_radius": 2e-3, "neck_length": 5e-3, "pitch": 0.02, "cavity_depth": 0.03},
     0.035, None),
    ({"type": "patches", "period": 0.06, "patches": [
        {"share": 0.7, "layers": [{"type": "fluid", "thickness": 0.05}]},
        {"share": 0.3, "layers": [{"type": "screen", "flow_resistance": 400}, {"type": "fluid", "thickness": 0.02},
                                  {"type": "elastic_plate", "thickness": 0.06, **PLATE}]},
    ]}, 0.08, None),
]  # fmt: skip


@pytest.mark.parametrize(("fields", "depth", "mass"), CASES)
def test_depth_and_mass(fields, depth, mass):
    layer = LAYERS[fields["type"]].model_validate(fields)
    assert layer.depth == pytest.approx(depth)
    assert layer.mass_per_area == (mass if mass is None else pytest.approx(mass))


def test_a_corrugated_sheet_weighs_its_length():
    """Trapezoids of 45 degrees: two flats of a quarter of the period, two flanks of that times the root of two."""
    fields = {"thickness": 1e-3, "period": 0.2, "height": 0.05, "crest_width": 0.05, "trough_width": 0.05}
    layer = LAYERS["corrugated_plate"].model_validate({"type": "corrugated_plate", **fields, **PLATE})
    assert layer.depth == pytest.approx(0.051)
    assert layer.mass_per_area == pytest.approx(2.7 * (0.5 + 0.5 * np.sqrt(2)))
