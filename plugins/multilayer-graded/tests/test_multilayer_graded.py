"""Graded layers against closed forms, an independent integrator, many thin layers, and the laws of layers."""

import re
from pathlib import Path
from typing import ClassVar, Literal

import numpy as np
import pytest
from multilayer_graded import Graded
from scipy.integrate import solve_ivp

from multilayer import Stack, load_stack, plane_wave
from multilayer.config import dump_yaml, parse_yaml
from multilayer.errors import InputError
from multilayer.layers import Layer
from multilayer.layers.fluid import Fluid
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.paths import with_values
from multilayer.response.fields import fields, power_balance
from multilayer.testing import check_layer

FREQUENCIES = np.geomspace(10.0, 2e4, 15)
ANGLES = [0.0, 40.0, 80.0]

GAS = {"type": "fluid", "density": 1.2, "sound_speed": 340.0}
PORES = {"type": "equivalent_fluid", "porosity": 0.98, "flow_resistivity": 3e3, "tortuosity": 1.0,
         "viscous_length": 2e-4, "thermal_length": 4e-4}  # fmt: skip
DENSE_PORES = {**PORES, "porosity": 0.9, "flow_resistivity": 6e4, "tortuosity": 1.6, "viscous_length": 3e-5}
RUBBER = {"type": "elastic_solid", "density": 60.0, "young_modulus": "200+20j kPa", "poisson_ratio": 0.3}
DENSE_RUBBER = {**RUBBER, "density": 300.0, "young_modulus": "2+0.6j MPa", "poisson_ratio": 0.1}
STEEL = {"type": "elastic_solid", "density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}
ALUMINIUM = {"type": "elastic_solid", "density": 2700.0, "young_modulus": 7e10, "poisson_ratio": 0.33}
FOAM = {"type": "poroelastic", "porosity": 0.98, "flow_resistivity": 5e3, "tortuosity": 1.02, "viscous_length": 1e-4,
        "thermal_length": 2e-4, "frame_density": 10.0, "young_modulus": "100+10j kPa",
        "poisson_ratio": 0.3}  # fmt: skip
DENSE_FOAM = {**FOAM, "flow_resistivity": 5e4, "tortuosity": 1.2, "viscous_length": 4e-5, "thermal_length": 1e-4,
              "frame_density": 40.0, "young_modulus": "400+100j kPa", "poisson_ratio": 0.2}  # fmt: skip
ZENER = {"law": "fractional_zener", "relaxed_modulus": 1e5, "unrelaxed_modulus": 1e6, "relaxation_time": 1e-4,
         "order": 0.6}  # fmt: skip


def graded(front, back, thickness=0.05, profile="linear"):
    given = {"thickness": thickness, "front": front, "back": back, "profile": profile}
    return Graded.model_validate(given)


PAIRS = {
    "fluid": (GAS, {**GAS, "density": 6.0, "sound_speed": 250.0}),
    "equivalent_fluid": (PORES, DENSE_PORES),
    "solid": (RUBBER, DENSE_RUBBER),
    "metal": (ALUMINIUM, STEEL),
    "by laws": (
        {**RUBBER, "young_modulus": ZENER},
        {**RUBBER, "young_modulus": {**ZENER, "relaxed_modulus": 2e5, "order": 0.4}},
    ),
    "poroelastic": (FOAM, DENSE_FOAM),
}


@pytest.mark.parametrize("profile", ["linear", "exponential"])
@pytest.mark.parametrize("pair", PAIRS)
def test_laws_of_layers(pair, profile):
    layer = graded(*PAIRS[pair], thickness=0.01, profile=profile)
    check_layer(layer, frequency=[1.0, 31.0, 1e3, 1e4], lossless=pair in ("fluid", "metal"))


@pytest.mark.parametrize("pair", PAIRS)
def test_no_gradient_is_a_homogeneous_layer(pair):
    material, _ = PAIRS[pair]
    ours = plane_wave(Stack(layers=(graded(material, material),), termination="ambient"), FREQUENCIES, ANGLES)
    plain = Stack.model_validate({"layers": [{**material, "thickness": 0.05}], "termination": "ambient"})
    theirs = plane_wave(plain, FREQUENCIES, ANGLES)
    assert np.allclose(ours.reflection, theirs.reflection, rtol=0, atol=1e-10)
    assert np.allclose(ours.transmission, theirs.transmission, rtol=1e-8, atol=0)


def exponential_impedance(h, ratio, density, speed, frequency, kx):
    """Return p/v3 in front of a wall behind a fluid of density rho exp(a z), one speed of sound throughout.

    ``p'' - a p' + k3^2 p = 0`` has constant coefficients: p = exp(a z/2) (cos q(z-h) - a/(2q) sin q(z-h)).
    """
    omega, a = 2 * np.pi * frequency, np.log(ratio) / h
    q = np.sqrt(omega**2 / speed**2 - kx**2 - a**2 / 4 + 0j)
    pressure = np.cos(q * h) + a / (2 * q) * np.sin(q * h)
    slope = (omega**2 / speed**2 - kx**2) / q * np.sin(q * h)
    return -1j * omega * density * pressure / slope


@pytest.mark.parametrize("ratio", [1.001, 3.0, 100.0, 1e-3])
@pytest.mark.parametrize("h", [1e-3, 0.1, 2.0])
def test_exponential_density_of_a_fluid(h, ratio):
    back = {**GAS, "density": 1.2 * ratio}
    result = plane_wave(Stack(layers=(graded(GAS, back, h, "exponential"),)), FREQUENCIES, ANGLES)
    kx = 2 * np.pi * FREQUENCIES[:, None] / dry_air().sound_speed * np.sin(np.radians(ANGLES))
    z = exponential_impedance(h, ratio, 1.2, 340.0, FREQUENCIES[:, None], kx)
    front = dry_air().impedance / np.cos(np.radians(ANGLES))
    assert np.max(np.abs(result.reflection - (z - front) / (z + front))) < 1e-10


def test_exponential_solid_on_a_wall():
    """E and rho grow alike: u'' + a u' + k^2 u = 0, and u = 0 on the wall."""
    h, ratio, loss = 0.04, 8.0, 0.1
    front = {**RUBBER, "young_modulus": 2e5, "loss_factor": loss}
    back = {**front, "density": 60.0 * ratio, "young_modulus": 2e5 * ratio}
    found = plane_wave(Stack(layers=(graded(front, back, h, "exponential"),)), FREQUENCIES).surface_impedance
    modulus = 2e5 * (1 + 1j * loss) * 0.7 / (1.3 * 0.4)
    omega, a = 2 * np.pi * FREQUENCIES, np.log(ratio) / h
    q = np.sqrt(omega**2 * 60.0 / modulus - a**2 / 4)
    # u = exp(-a z/2) sin q(h - z): p/v3 = -C u'/(i w u) at z = 0
    expected = modulus * (a / 2 + q / np.tan(q * h)) / (1j * omega)
    assert np.allclose(found, expected, rtol=1e-10, atol=0)


@pytest.mark.parametrize("profile", ["linear", "exponential"])
@pytest.mark.parametrize("pair", ["equivalent_fluid", "solid", "by laws", "poroelastic"])
def test_against_a_runge_kutta_method(pair, profile):
    """The transfer of the state from face to face, by steps of order 8 whose size the integrator chooses."""
    layer = graded(*PAIRS[pair], thickness=0.02, profile=profile)
    wave = Wave.incident(700.0, 50.0, dry_air())
    family = layer.front.field_equations(wave).family

    def slope(z, state):
        equations = layer.at(z / 0.02).field_equations(wave)
        x, y = (np.array(m, dtype=complex) for m in (equations.x, equations.y))
        matrix = np.zeros((family.size, family.size), dtype=complex)
        matrix[np.ix_(family.even, family.odd)], matrix[np.ix_(family.odd, family.even)] = x, y
        return (matrix * scale / scale[:, None] @ state.reshape(family.size, -1)).ravel()

    scale = np.array([1.0 if name.startswith("v") else 400.0 for name in family.components])
    start = np.eye(family.size, dtype=complex).ravel()
    done = solve_ivp(slope, (0, 0.02), start, method="DOP853", rtol=1e-12, atol=1e-13)
    propagator = done.y[:, -1].reshape(family.size, -1)
    ours = np.linalg.inv(layer.transfer_matrix(700.0, 50.0)) * scale / scale[:, None]
    assert np.max(np.abs(ours - propagator)) < 1e-9 * np.max(np.abs(propagator))


@pytest.mark.parametrize("pair", ["solid", "poroelastic"])
def test_many_thin_layers_come_near(pair):
    layer, frequencies = graded(*PAIRS[pair]), FREQUENCIES[:10]
    exact = plane_wave(Stack(layers=(layer,)), frequencies, ANGLES).reflection
    errors = []
    for n in (20, 40):
        middles = [layer.at((i + 0.5) / n).model_copy(update={"thickness": 0.05 / n}) for i in range(n)]
        steps = plane_wave(Stack(layers=tuple(middles)), frequencies, ANGLES).reflection
        errors.append(np.max(np.abs(steps - exact)))
    assert errors[1] < 0.02
    assert errors[0] / errors[1] > 3  # of second order


def test_parts_are_the_whole():
    layer = graded(FOAM, DENSE_FOAM)
    whole, parts = (
        plane_wave(Stack(layers=layers), FREQUENCIES, ANGLES).reflection for layers in ((layer,), layer.sliced(3))
    )
    assert np.max(np.abs(whole - parts)) < 1e-9


def test_fields_and_power_inside():
    stack = Stack(layers=(graded(PORES, DENSE_PORES),))
    (state,) = fields(stack, 500.0, points=11)
    assert state.values.shape == (2, 11)
    assert state.position[-1] == pytest.approx(0.05)
    assert np.abs(state["v3"][-1]) < 1e-12
    assert np.abs(power_balance(stack, FREQUENCIES).residual).max() < 1e-10


def test_properties_of_the_faces_are_fields_of_the_stack():
    stack = Stack(layers=(graded(RUBBER, DENSE_RUBBER).model_copy(update={"name": "pad"}),))
    values = np.array([60.0, 100.0])
    several = plane_wave(with_values(stack, {"layers.pad.front.density": values[:, None]}), FREQUENCIES).reflection
    for row, value in zip(several, values, strict=True):
        one = plane_wave(with_values(stack, {"layers.pad.front.density": float(value)}), FREQUENCIES).reflection
        assert np.allclose(row, one, rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"front": {**GAS, "thickness": 0.1}, "back": GAS}, "front: has a thickness of its own"),
        ({"front": GAS, "back": RUBBER}, "back.type: is elastic_solid, the front is fluid"),
        (
            {"front": {"type": "membrane", "surface_density": 1.0}, "back": {"type": "membrane", "surface_density": 1}},
            "front: a layer of type membrane cannot be graded",
        ),
        ({"front": FOAM, "back": {**FOAM, "porosity": 0.9}}, "back.porosity: differs from the front's"),
        (
            {"front": RUBBER, "back": {**RUBBER, "young_modulus": ZENER}},
            "back.young_modulus: differs from the front's",
        ),
        (
            {"front": RUBBER, "back": {**RUBBER, "poisson_ratio": -0.1}, "profile": "exponential"},
            "back.poisson_ratio: no exponential leads from 0.3 to -0.1",
        ),
        ({"front": GAS, "back": GAS, "profile": "steep"}, "profile: 'steep' is not allowed"),
        ({"front": {**GAS, "densty": 1.0}, "back": GAS}, "there is no such field; did you mean 'density'"),
    ],
)
def test_what_cannot_be_graded_is_refused(tmp_path, given, words):

    given = {"type": "graded", "thickness": 0.05, **given}
    file = tmp_path / "stack.yaml"
    text = dump_yaml({"layers": [given]})
    file.write_text(text)
    with pytest.raises(InputError) as caught:
        load_stack(file)
    assert words in str(caught.value)


def test_a_graded_layer_is_a_layer():
    assert issubclass(Graded, Layer)


def test_the_example_of_the_readme():
    text = Path(__file__).parents[1].joinpath("README.md").read_text()
    (example,) = re.findall(r"```yaml\n(.*?)```", text, re.DOTALL)
    stack = Stack.model_validate(parse_yaml(example, Path("stack.yaml")).data)
    absorption = plane_wave(stack, FREQUENCIES).absorption
    assert np.all((absorption > 0) & (absorption <= 1))


def test_it_is_isotropic_in_its_plane_as_its_materials_are():
    class Grooved(Fluid):
        type: Literal["grooved"] = "grooved"
        isotropic_in_plane: ClassVar[bool] = False

    for kind, expected in ((Fluid, True), (Grooved, False)):
        faces = {name: kind(thickness=1.0, density=density) for name, density in (("front", 1.2), ("back", 2.0))}
        assert Stack(layers=(Graded(thickness=0.05, **faces),)).isotropic_in_plane is expected
