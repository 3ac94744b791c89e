"""The preloaded solid against solids of the modulus that the law says, and the laws of layers."""

import re
from pathlib import Path

import numpy as np
import pytest
from multilayer_preload import GRAVITY, PreloadedSolid

from multilayer import Stack, base_motion, plane_wave
from multilayer.config import parse_yaml
from multilayer.errors import InputError, ValidityWarning
from multilayer.response.fields import fields
from multilayer.testing import check_layer

FOAM = {"thickness": 0.025, "density": 60.0, "young_modulus": "200+60j kPa", "poisson_ratio": 0.1}
LAW = {"stiffening": 5e-4, "damping": -1e-4}
PLATE = {"type": "elastic_solid", "name": "plate", "thickness": 1e-3, "density": 7800, "young_modulus": 2e11,
         "poisson_ratio": 0.3}  # fmt: skip
PLATE_STRESS = GRAVITY * 7800 * 1e-3
FREQUENCIES = [50.0, 300.0, 2000.0]


def loaded(**more):
    return {"type": "preloaded_solid", "name": "foam", **FOAM, **LAW, **more}


def solid(stress):
    """Return an ordinary solid with the modulus that the law gives by hand."""
    storage, loss = 200e3 * (1 + 5e-4 * stress), 60e3 / 200e3 * (1 - 1e-4 * stress)
    return {"type": "elastic_solid", **FOAM, "young_modulus": f"{storage!r}+{storage * loss!r}j Pa"}


def stack(*layers, termination="rigid"):
    return Stack.model_validate({"layers": list(layers), "termination": termination})


@pytest.mark.parametrize("more", [{}, {"static_stress": "1 kPa"}, {"young_modulus": "200 kPa", "loss_factor": 0.2}])
def test_laws_of_layers(more):
    check_layer(PreloadedSolid.model_validate(loaded(**more)))


def test_without_a_load_it_is_a_solid():
    assert np.allclose(
        plane_wave(stack(loaded()), FREQUENCIES, [0, 50]).reflection,
        plane_wave(stack(solid(0.0)), FREQUENCIES, [0, 50]).reflection,
    )


def test_a_plate_lies_on_it_on_a_wall():
    found = plane_wave(stack(PLATE, loaded()), FREQUENCIES, [0, 50]).reflection
    expected = plane_wave(stack(PLATE, solid(PLATE_STRESS)), FREQUENCIES, [0, 50]).reflection
    assert np.allclose(found, expected, rtol=1e-12, atol=0)
    assert not np.allclose(found, plane_wave(stack(PLATE, solid(0.0)), FREQUENCIES, [0, 50]).reflection, rtol=1e-4)


def test_a_plate_lies_on_it_on_a_shaken_base():
    found = base_motion(stack(loaded(), PLATE, termination="free"), FREQUENCIES).transmissibility
    expected = base_motion(stack(solid(PLATE_STRESS), PLATE, termination="free"), FREQUENCIES).transmissibility
    assert np.allclose(found, expected, rtol=1e-12, atol=0)


def test_what_lies_below_or_beyond_a_gap_does_not_press():
    gap = {"type": "fluid", "thickness": 0.02}
    for layers in ([loaded(), PLATE], [PLATE, gap, loaded()]):
        others = [solid(0.0) if layer.get("name") == "foam" else layer for layer in layers]
        assert np.allclose(
            plane_wave(stack(*layers), FREQUENCIES).reflection, plane_wave(stack(*others), FREQUENCIES).reflection
        )


def test_all_that_lies_above_counts():
    film = {"type": "membrane", "surface_density": 0.5}
    felt = {"type": "limp", "thickness": 0.01, "frame_density": 30.0, "porosity": 0.95, "flow_resistivity": 2e4,
            "tortuosity": 1.0, "viscous_length": 1e-4, "thermal_length": 2e-4}  # fmt: skip
    total = PLATE_STRESS + GRAVITY * (0.5 + 0.3)
    (*_, foam) = stack(film, felt, PLATE, loaded()).at_rest()
    assert foam.static_stress == pytest.approx(total)


def test_samples_of_the_load_broadcast():
    several = stack(PLATE, loaded()).replaced({"layers.plate.thickness": np.array([1e-3, 3e-3])[:, None]})
    found = plane_wave(several, FREQUENCIES).reflection
    for row, h in zip(found, (1e-3, 3e-3), strict=True):
        one = plane_wave(stack({**PLATE, "thickness": h}, loaded()), FREQUENCIES).reflection
        assert np.allclose(row, one, rtol=1e-12, atol=0)


def test_fields_inside_see_the_load():
    foam = fields(stack(PLATE, loaded()), 300.0, points=6)[1]
    other = fields(stack(PLATE, solid(PLATE_STRESS)), 300.0, points=6)[1]
    assert np.allclose(foam.values, other.values, rtol=1e-9)
    assert foam.position[-1] == pytest.approx(0.026)


def test_a_mass_that_is_not_known_is_told():
    sheet = {"type": "perforated_plate", "thickness": 1e-3, "hole_radius": 5e-4, "perforation": 0.05}
    with pytest.warns(ValidityWarning, match="the mass of layer perforated_plate is not known"):
        stack(sheet, loaded()).at_rest()


def test_a_line_extrapolated_too_far_is_refused():
    with pytest.raises(InputError, match="layer foam: no modulus is left at 1000 Pa"):
        plane_wave(stack(loaded(stiffening=-2e-3, static_stress=1000.0)), FREQUENCIES)


def test_the_example_of_the_readme():
    text = Path(__file__).parents[1].joinpath("README.md").read_text()
    (example,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    stack = Stack.model_validate(parse_yaml(example, Path("stack.yaml")).data)
    absorption = plane_wave(stack, FREQUENCIES).absorption
    assert np.all((absorption > 0) & (absorption <= 1))
