"""The diffuse field against closed forms and a very fine quadrature."""

import numpy as np
import pytest

from multilayer.errors import InputError, ValidityWarning
from multilayer.response import diffuse_field, plane_wave
from multilayer.stack import Stack

FREQUENCY = np.geomspace(50, 20e3, 15)
PANE = {"type": "elastic_plate", "thickness": 6e-3, "density": 2500, "young_modulus": 65e9, "poisson_ratio": 0.22}
GLASS = Stack.model_validate({"layers": [{**PANE, "loss_factor": 0.02}], "termination": "ambient"})
FOAM = {
    "type": "poroelastic", "thickness": 0.05, "porosity": 0.98, "flow_resistivity": 15e3, "tortuosity": 1.05,
    "viscous_length": 1e-4, "thermal_length": 2.5e-4, "frame_density": 25, "young_modulus": 140e3,
    "poisson_ratio": 0.3, "loss_factor": 0.1,
}  # fmt: skip


def _trapezoid(stack, max_angle, weighting=np.ones_like, n=20001):
    s = np.linspace(0, np.sin(np.deg2rad(max_angle)) ** 2, n)
    angle = np.rad2deg(np.arcsin(np.sqrt(s)))
    angle, weight = angle[:-1], weighting(angle)[:-1]
    found = plane_wave(stack, FREQUENCY, angle)
    tau = None if found.transmission_loss is None else 10 ** (-found.transmission_loss / 10) @ weight / weight.sum()
    return found.absorption @ weight / weight.sum(), tau


@pytest.mark.parametrize("max_angle", [45.0, 78.0, 90.0])
def test_a_limp_wall_has_a_closed_form(max_angle: float) -> None:
    # tau = 1 / (1 + (a cos)^2) without dissipation, a = w m / (2 Z0): its mean over s = sin^2 is a logarithm
    limp = Stack.model_validate({"layers": [{**PANE, "young_modulus": 1.0}], "termination": "ambient"})
    found = diffuse_field(limp, FREQUENCY, max_angle, tolerance_db=1e-6)
    a2 = (np.pi * FREQUENCY * 15.0 / limp.ambient.gas.impedance) ** 2
    upper = np.sin(np.deg2rad(max_angle)) ** 2
    exact = np.log((1 + a2) / (1 + a2 * (1 - upper))) / (a2 * upper)
    assert found.transmission_coefficient == pytest.approx(exact, rel=1e-6)


def test_coincidence_is_resolved_within_the_tolerance() -> None:
    found = diffuse_field(GLASS, FREQUENCY, tolerance_db=0.01)
    _, tau = _trapezoid(GLASS, 78.0)
    assert np.abs(10 * np.log10(found.transmission_coefficient / tau)).max() < 0.01
    assert found.transmission_loss_error.max() <= 0.01
    # work goes where it is needed: smooth curves take one panel or three, a dip more
    assert found.angles.min() <= 45 < found.angles.max()


def test_absorption_and_weighting() -> None:
    foam = Stack.model_validate({"layers": [FOAM]})

    def weighting(angle):
        return np.exp(-2 * np.deg2rad(angle) ** 2)

    found = diffuse_field(foam, FREQUENCY, weighting=weighting)
    exact, _ = _trapezoid(foam, 78.0, weighting)
    assert found.absorption == pytest.approx(exact, abs=1e-4)
    assert found.transmission_loss is None
    assert np.abs(found.absorption - diffuse_field(foam, FREQUENCY).absorption).max() > 0.01


def test_weightings_by_name() -> None:
    def gaussian(angle):
        return np.exp(-2 * np.deg2rad(angle) ** 2)

    found, plain = (diffuse_field(GLASS, FREQUENCY, weighting=name) for name in ("gaussian", "uniform"))
    assert np.array_equal(
        found.transmission_loss, diffuse_field(GLASS, FREQUENCY, weighting=gaussian).transmission_loss
    )
    assert np.array_equal(plain.transmission_loss, diffuse_field(GLASS, FREQUENCY).transmission_loss)
    # below coincidence oblique waves come through more easily, and they count less
    assert np.all(found.transmission_loss[:5] > plain.transmission_loss[:5] + 0.3)
    with pytest.raises(InputError, match="no weighting 'gausian'; did you mean 'gaussian'"):
        diffuse_field(GLASS, 100.0, weighting="gausian")


def test_a_small_cone_is_normal_incidence() -> None:
    found = diffuse_field(GLASS, FREQUENCY, 0.01)
    assert found.transmission_loss == pytest.approx(plane_wave(GLASS, FREQUENCY).transmission_loss, abs=1e-4)


def test_shapes_and_threads() -> None:
    single = diffuse_field(GLASS, 500.0)
    assert single.transmission_loss.shape == ()
    many = np.geomspace(100, 5000, 400)
    one, two = (diffuse_field(GLASS, many, workers=n).transmission_loss for n in (1, 2))
    assert one == pytest.approx(two, abs=0.02)


def test_what_is_not_reached_is_said() -> None:
    with pytest.warns(ValidityWarning, match=r"of 15 frequencies"):
        diffuse_field(GLASS, FREQUENCY, tolerance_db=1e-9, max_panels=2)


@pytest.mark.parametrize("max_angle", [0.0, -1.0, 90.1])
def test_angles_out_of_range(max_angle: float) -> None:
    with pytest.raises(InputError, match="above 0 and at most 90"):
        diffuse_field(GLASS, 100.0, max_angle)


def test_narrow_resonances_of_a_double_wall_need_a_tight_tolerance() -> None:
    # cavities without losses: dips in the transmission loss that are far narrower than a panel of angles
    cavity = {"type": "fluid", "thickness": 0.05}
    wall = Stack.model_validate({"layers": [GLASS.layers[0], cavity, GLASS.layers[0]], "termination": "ambient"})
    nodes, weights = np.polynomial.legendre.leggauss(20)
    n = 8000
    s = np.sin(np.deg2rad(78.0)) ** 2 * ((np.arange(n)[:, None] + 0.5 * (1 + nodes)) / n).ravel()
    loss = plane_wave(wall, 4000.0, np.rad2deg(np.arcsin(np.sqrt(s)))).transmission_loss
    exact = -10 * np.log10(10 ** (-loss / 10) @ np.tile(weights, n) / (2 * n))
    found = diffuse_field(wall, 4000.0, tolerance_db=1e-6, max_panels=1000)
    assert found.transmission_loss == pytest.approx(exact, abs=1e-3)
