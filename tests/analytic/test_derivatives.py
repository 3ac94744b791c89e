"""Derivatives against differences in 120 digits: every family, coupling and end, thin foils and thick walls."""

import numpy as np
import pytest

from multilayer.paths import locate
from multilayer.response import base_motion_derivatives, plane_wave_derivatives
from tests.analytic import mp_reference
from tests.analytic.materials import ALUMINIUM, FOAM2, stack
from tests.analytic.test_against_mp import ENDS, MIXED, SINGLE, name_of

FREQUENCIES = [1.0, 300.0, 2e4]
ANGLES = [0.0, 45.0, 89.0]
PAIRS = [(name, ENDS[(i + j) % len(ENDS)]) for i, name in enumerate(MIXED) for j in (0, 2)]


def assert_close(computed, exact, response, value, what):
    """Within 1e-8 of its size; a change of the field by its own size, within 1e-12 of the response that it changes."""
    allowed = 1e-8 * abs(exact) + 1e-12 * max(abs(response), 1e-2 * (what[0] == "R")) / (abs(value) or 1.0)
    assert abs(computed - exact) <= allowed, (what, computed, exact)


def draw(seed, *choices):
    """Return one of each; which, a name and an end decide."""
    rng = np.random.default_rng([ord(letter) for letter in seed])
    return [rng.integers(len(choice)) for choice in choices]


def assert_plane_wave_agrees(panel, seed):
    found = plane_wave_derivatives(panel, None, FREQUENCIES, ANGLES)
    assert not found.by_differences
    place, i, j = draw(seed, found.fields, FREQUENCIES, ANGLES)
    path = found.fields[place]
    exact = mp_reference.plane_wave_slopes(panel, path, FREQUENCIES[i], ANGLES[j])
    for kind, name, slope in zip("RT", ("reflection", "transmission"), exact, strict=False):
        response, value = getattr(found.response, name)[i, j], locate(panel, path).value
        what = (kind, path, FREQUENCIES[i], ANGLES[j])
        assert_close(getattr(found, name)[place, i, j], slope, response, value, what)


@pytest.mark.parametrize(("name", "end"), PAIRS, ids=lambda item: item if item in MIXED else name_of(item))
def test_plane_waves(name, end):
    assert_plane_wave_agrees(MIXED[name].model_copy(update={"termination": end}), f"{name}{name_of(end)}")


@pytest.mark.filterwarnings("ignore:.*bending wavelength")  # the theory is the same
@pytest.mark.parametrize("name", [name for name in SINGLE if name != "air 10 m"])  # which reflects nothing
def test_one_layer_in_air(name):
    assert_plane_wave_agrees(stack(SINGLE[name]), name)


def test_slip_on_a_wall():
    panel = stack((ALUMINIUM, 1e-3), (FOAM2, 0.02), termination="rigid", slip=((1, "termination"),))
    assert_plane_wave_agrees(panel, "slip")


@pytest.mark.parametrize("name", MIXED)
def test_base_motion(name):
    end = "ambient" if len(name) % 2 else "free"
    panel = MIXED[name].model_copy(update={"termination": end})
    found = base_motion_derivatives(panel, None, FREQUENCIES)
    place, i = draw(f"{name}{end}", found.fields, FREQUENCIES)
    path = found.fields[place]
    (exact,) = mp_reference.base_motion_slopes(panel, path, FREQUENCIES[i])
    response, value = found.response.transmissibility[i], locate(panel, path).value
    assert_close(found.transmissibility[place, i], exact, response, value, ("M", path, FREQUENCIES[i]))


def test_every_field_of_a_foam_between_plates():
    panel = stack((ALUMINIUM | {"loss_factor": 0.01}, 1e-3), (FOAM2, 0.05), termination="ambient")
    found = plane_wave_derivatives(panel, None, 700.0, 50.0)
    for place, path in enumerate(found.fields):
        exact = mp_reference.plane_wave_slopes(panel, path, 700.0, 50.0)
        value = locate(panel, path).value
        for kind, name, slope in zip("RT", ("reflection", "transmission"), exact, strict=True):
            assert_close(getattr(found, name)[place], slope, getattr(found.response, name), value, (kind, path))
