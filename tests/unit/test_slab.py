"""Slabs: what is known of waves by reciprocity, and derivatives by series and by waves, which are the same."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from multilayer.matrix import slab
from multilayer.matrix.adjoint import solve_with_adjoint
from multilayer.matrix.faces import LayerField
from multilayer.matrix.slab import Slab
from multilayer.matrix.small import multiply, stack_entries
from multilayer.matrix.solve import HalfSpace
from multilayer.matrix.wave import Wave
from multilayer.response.plane_wave import front_impedance
from multilayer.response.system import build_system
from tests.analytic.materials import ALUMINIUM, FOAM, FOAM2, GEL, RUBBER, WATER, stack

MEDIA = {"water": WATER, "aluminium": ALUMINIUM, "rubber": RUBBER, "gel": GEL, "stiff foam": FOAM, "foam": FOAM2}
FREQUENCY = np.array([1.0, 30.0, 1e3, 2e4])
ANGLE = np.array([0.0, 30.0, 60.0, 89.0])


def in_air(medium: dict[str, Any], thickness: float) -> tuple[Slab, LayerField]:
    """Return a slab with its field and adjoint field in air."""
    panel = stack((medium, thickness))
    wave = Wave.incident(FREQUENCY, ANGLE, panel.ambient.gas)
    system = build_system(panel, wave, HalfSpace(front_impedance(wave)))
    origin = system.layers[0].origin
    assert isinstance(origin, Slab)
    return origin, solve_with_adjoint(system).fields[0]


@pytest.mark.parametrize("name", MEDIA)
def test_inverses_of_states_by_reciprocity(name: str) -> None:
    origin, _ = in_air(MEDIA[name], 0.01)
    states = stack_entries(origin.waves(*origin.constants))
    halves = states[list(origin.family.even)], states[list(origin.family.odd)]
    for half, inverse in zip(halves, slab._inverses(origin.family, *halves), strict=True):
        eye = np.eye(len(half)).reshape(*half.shape[:2], *(1,) * (half.ndim - 2))
        np.testing.assert_allclose(multiply(inverse, half) - eye, 0, atol=2e-12)


@pytest.mark.parametrize("thickness", [1e-7, 1e-5, 1e-3])
@pytest.mark.parametrize("name", [name for name in MEDIA if name != "water"])  # whose derivatives know no other way
def test_derivatives_by_waves_are_those_by_series_however_thin(name: str, thickness: float) -> None:
    origin, field = in_air(MEDIA[name], thickness)
    assert origin.shear is not None
    taken = origin.thin & (np.abs(origin.shear) >= origin.wave.kx**2)  # others take the series
    assert np.any(taken)
    arguments = (origin.thickness, *origin.constants)
    by_waves = origin.by_medium(*origin._of_waves(origin._with_waves(field), *arguments))
    equations = origin.equations(*origin.constants)
    by_series = origin.by_medium(*slab._by_series(origin.family, *equations, thickness, field, 2.0))
    changes = [(a * c, b * c) for a, b, c in zip(by_waves, by_series, origin.coefficients[1:], strict=True)]
    size = sum(np.abs(exact) for _, exact in changes)
    for computed, exact in changes:
        assert np.max(np.where(taken, np.abs(computed - exact) / size, 0)) < 1e-12


def test_derivatives_of_a_fluid_by_series_are_those_by_waves() -> None:
    origin, field = in_air(WATER, 0.01)
    by_series = slab._by_series(origin.family, *origin.equations(*origin.constants), 0.01, field, 2.0)
    by_waves = origin._of_waves(origin._with_waves(replace(field)), origin.thickness, *origin.constants)
    good = np.broadcast_to(origin.thin & (origin.turn > 1e-2), by_series[0].shape)
    assert np.any(good)
    for computed, exact in zip(by_series, by_waves, strict=True):
        np.testing.assert_allclose(computed[good], exact[good], rtol=1e-10)


@pytest.mark.parametrize("turn", [0.03, 0.3, 2.0])
def test_nodes_integrate_products_of_exponentials(turn: float) -> None:
    nodes, weights = slab._gauss(slab._nodes(turn))
    assert np.sum(weights * np.exp(2 * turn * nodes)) == pytest.approx(np.expm1(2 * turn) / (2 * turn), rel=1e-14)
