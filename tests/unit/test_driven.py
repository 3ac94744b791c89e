"""Responses to prescribed excitations against closed forms of infinite plates, and against other responses."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.matrix.wave import Wave
from multilayer.media.gas import Gas, dry_air
from multilayer.response import diffuse_field
from multilayer.response.driven import _FiniteRadiation, driven, input_mobility, transfer
from multilayer.response.excitations import Excitation, PointForce, Rain, TappingMachine, TurbulentFlow
from multilayer.response.finite_size import Window, radiation_impedance
from multilayer.response.plane_wave import plane_wave
from multilayer.stack import Stack

STEEL = {"thickness": 1e-3, "density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3, "loss_factor": 0.01}
CONCRETE = {"thickness": 0.14, "density": 2300.0, "young_modulus": 3e10, "poisson_ratio": 0.2, "loss_factor": 0.05}
THIN_GAS = {"density": 1e-3}  # so that it hardly loads a plate
F = np.array([100.0, 500.0, 2000.0])


def plate(layer: dict[str, float], **fields: object) -> Stack:
    return Stack(layers=[{"type": "elastic_plate", **layer}], **{"termination": "ambient", **fields})


def mass(layer: dict[str, float]) -> float:
    return layer["density"] * layer["thickness"]


def stiffness(layer: dict[str, float]) -> float:
    return layer["young_modulus"] * layer["thickness"] ** 3 / (12 * (1 - layer["poisson_ratio"] ** 2))


def test_input_mobility_of_a_thin_plate() -> None:
    # L. Cremer: 1/(8 sqrt(D m)), of the complex stiffness, too
    found = input_mobility(plate(STEEL, ambient=THIN_GAS), F)
    np.testing.assert_allclose(found, 1 / (8 * np.sqrt(stiffness(STEEL) * (1 + 0.01j) * mass(STEEL))), rtol=1e-3)


def test_a_point_force_radiates_by_mass_alone_below_coincidence() -> None:
    # Cremer, Heckl & Ungar: rho F^2/(2 pi c m^2), whatever the stiffness
    stack = plate(STEEL, ambient=THIN_GAS)
    gas = stack.ambient.gas
    expected = gas.density / (2 * np.pi * gas.sound_speed * mass(STEEL) ** 2)
    # (f/fc)^2 terms: fc is 12 kHz
    np.testing.assert_allclose(driven(stack, F[:2], PointForce()).radiated_power, expected, rtol=3e-3)


def test_power_is_conserved() -> None:
    stack = plate(STEEL)
    found = driven(stack, F, PointForce(), tolerance=1e-5)
    # losses of a plate: eta w times twice the potential energy, int D k^4/w |v|^2, more than m w int |v|^2 by little
    lost = found.input_power - found.radiated_power - found.radiated_in_front
    np.testing.assert_allclose(lost, 0.01 * 2 * np.pi * F * mass(STEEL) * found.front_velocity, rtol=0.02)
    np.testing.assert_allclose(found.radiated_power, found.radiated_in_front, rtol=1e-9)


@pytest.mark.filterwarnings("ignore:.*bending wavelength")  # the theory is the same
def test_above_coincidence_a_concrete_floor_radiates_its_share_of_the_losses() -> None:
    frequency = np.array([1000.0, 2000.0])
    stack = plate(CONCRETE)
    gas, omega = stack.ambient.gas, 2 * np.pi * frequency
    found = driven(stack, frequency, PointForce())
    critical = gas.sound_speed**2 / (2 * np.pi) * np.sqrt(mass(CONCRETE) / stiffness(CONCRETE))
    radiation = gas.impedance / np.sqrt(1 - critical / frequency) / (omega * mass(CONCRETE))
    power = 1 / (8 * np.sqrt(stiffness(CONCRETE) * mass(CONCRETE)))
    np.testing.assert_allclose(found.radiated_power, power * radiation / (0.05 + 2 * radiation), rtol=0.05)
    np.testing.assert_allclose(found.radiation_efficiency, 1 / np.sqrt(1 - critical / frequency), rtol=0.05)


class DiffuseSound(Excitation):
    """The blocked pressure of waves from all directions, 1 Pa^2/Hz of them arriving."""

    per_area = True

    def spectrum(self, frequency: RealArray, wavenumber: RealArray, gas: Gas) -> RealArray:
        k0 = 2 * np.pi * frequency / gas.sound_speed
        cosine = np.sqrt(np.maximum(1 - (wavenumber / k0) ** 2, 1e-300))
        return np.where(wavenumber < k0, 8 * np.pi / (k0**2 * cosine), 0.0)


@pytest.mark.parametrize("kind", ["elastic_plate", "orthotropic"])
def test_a_diffuse_field_is_one_such_excitation(kind: str) -> None:
    layers: list[dict[str, object]] = [{"type": "elastic_plate", **STEEL}]
    if kind == "orthotropic":
        layers = [
            {
                "type": "orthotropic_plate", "thickness": 1e-3, "density": 7800.0, "young_modulus_x": 2e11,
                "young_modulus_y": 5e10, "poisson_ratio_xy": 0.3, "shear_modulus_xy": 3e10, "loss_factor": 0.02,
            }
        ]  # fmt: skip
    stack = Stack(layers=[*layers, {"type": "fluid", "thickness": 0.05}], termination="ambient")
    found = driven(stack, F, DiffuseSound())
    assert found.radiated_power is not None
    arriving = 1 / (2 * stack.ambient.gas.impedance)
    expected = diffuse_field(stack, F, max_angle=90).transmission_coefficient
    np.testing.assert_allclose(found.radiated_power / arriving, expected, rtol=3e-3)


def test_below_grazing_the_transfer_is_that_of_a_plane_wave() -> None:
    stack = Stack(
        layers=[
            {"type": "elastic_solid", "thickness": 0.02, "density": 1200, "young_modulus": 3e9, "poisson_ratio": 0.3},
            {"type": "fluid", "thickness": 0.1},
        ],
        termination="ambient",
    )
    gas = dry_air()
    wave = Wave.incident(F, 40.0, gas)
    answer, known = transfer(stack, wave), plane_wave(stack, F, 40.0)
    impedance = gas.impedance / np.cos(np.deg2rad(40.0))
    assert known.transmission is not None
    np.testing.assert_allclose(answer.back, known.transmission / impedance / 2, rtol=1e-9)
    np.testing.assert_allclose(answer.front, (1 - known.reflection) / impedance / 2, rtol=1e-6)


def test_a_plate_above_grazing_by_its_closed_form() -> None:
    gas, stack = dry_air(), plate(STEEL)
    k = np.array([3.0, 10.0, 100.0, 1e4])
    omega = 2 * np.pi * 100.0
    load = gas.density * omega / (-1j * np.sqrt(k**2 - (omega / gas.sound_speed) ** 2))
    sheet = 1j * omega * mass(STEEL) + stiffness(STEEL) * (1 + 0.01j) * k**4 / (1j * omega)
    answer = transfer(stack, Wave(np.array(100.0), k, gas))
    np.testing.assert_allclose(answer.front, 1 / (sheet + 2 * load), rtol=1e-9)
    np.testing.assert_allclose(answer.back, answer.front, rtol=1e-12)
    assert not np.any(answer.radiation)


def test_thin_plates_and_thin_solids_have_one_mobility() -> None:
    solid = Stack(layers=[{"type": "elastic_solid", **STEEL}], termination="ambient")
    np.testing.assert_allclose(input_mobility(solid, F, 0.02), input_mobility(plate(STEEL), F, 0.02), rtol=5e-3)


def test_a_solid_gives_way_to_a_point_without_bound() -> None:
    with pytest.raises(InputError, match="radius"):
        input_mobility(Stack(layers=[{"type": "elastic_solid", **STEEL}], termination="ambient"), 500.0)


def test_free_waves_without_losses_are_refused() -> None:
    with pytest.raises(InputError, match="loss_factor"):
        input_mobility(plate(STEEL | {"loss_factor": 0.0}), 500.0)


def test_rain_carries_the_momentum_of_its_drops() -> None:
    rain = Rain()
    gas = dry_air()
    volume = np.pi / 6 * 0.005**3
    low = rain.spectrum(np.array(1.0), np.array(0.0), gas)
    assert low == pytest.approx(2 * (0.040 / 3600 / volume) * (1000 * volume * 7.0) ** 2, rel=1e-4)
    # the transform of the force of a sphere's slices, numerically
    s = (np.arange(20000) + 0.5) / 20000
    force = 1000 * np.pi * 7.0**2 * 0.005**2 * (s - s**2)
    pulse = abs(np.mean(force * np.exp(-2j * np.pi * 1500 * s * 0.005 / 7.0))) * 0.005 / 7.0
    expected = 2 * 0.040 / 3600 / volume * pulse**2
    assert rain.spectrum(np.array(1500.0), np.array(0.0), gas) == pytest.approx(expected, rel=1e-6)
    # drops at different places and times: as many point forces
    stack = plate(STEEL)
    of_rain, of_force = driven(stack, F, rain), driven(stack, F, PointForce(radius=0.0025))
    assert of_rain.radiated_power is not None
    assert of_force.radiated_power is not None
    ratio = rain.spectrum(F, np.zeros(3), gas)
    np.testing.assert_allclose(of_rain.radiated_power, ratio * of_force.radiated_power, rtol=1e-9)


def test_the_mean_of_a_turbulent_flow_over_the_azimuth() -> None:
    flow = TurbulentFlow(speed=50.0, boundary_layer_thickness=0.02, friction_velocity=1.8)
    gas, azimuth = dry_air(), np.arange(20000) * 360 / 20000
    for k in (0.1, 5.0, 17.0, 18.0, 40.0, 2000.0):
        mean = np.mean(flow.towards(np.array(100.0), np.array(k), azimuth, gas))
        assert flow.spectrum(np.array(100.0), np.array(k), gas) == pytest.approx(mean, rel=1e-6)


def test_a_turbulent_flow_presses_as_much_as_its_spectrum_at_a_point() -> None:
    flow = TurbulentFlow(speed=50.0, boundary_layer_thickness=0.02, friction_velocity=1.8)
    gas = dry_air()
    k = np.geomspace(1e-3, 1e7, 400001)
    whole = trapezoid(flow.spectrum(np.array(300.0), k, gas) * k**2 / (2 * np.pi), np.log(k))
    point = flow.at_a_point(np.array(300.0), gas)
    assert whole == pytest.approx(point, rel=1e-4)
    # its pressure is a few times the shear at the wall
    f = np.geomspace(0.1, 1e6, 20001)
    rms = np.sqrt(trapezoid(flow.at_a_point(f, gas) * f, np.log(f)))
    assert 2 < rms / (gas.density * 1.8**2) < 5


def test_hammers_on_soft_floors() -> None:
    rigid, hammers = TappingMachine(), TappingMachine(restitution=1.0)
    gas = dry_air()
    low = rigid.spectrum(np.array(100.0), np.array(0.0), gas)
    assert low == pytest.approx(2 * 10 * (0.5 * 0.886) ** 2, rel=1e-3)
    assert hammers.spectrum(np.array(100.0), np.array(0.0), gas) == pytest.approx(4 * low)
    stack = plate(STEEL)
    mobility = input_mobility(stack, F, 0.015)
    of_force, of_hammer = driven(stack, F, PointForce(radius=0.015)), driven(stack, F, rigid)
    assert of_hammer.radiated_power is not None
    assert of_force.radiated_power is not None
    factor = low / np.abs(1 + 1j * 2 * np.pi * F * 0.5 * mobility) ** 2
    np.testing.assert_allclose(of_hammer.radiated_power, factor * of_force.radiated_power, rtol=1e-6)
    np.testing.assert_allclose(of_hammer.input_mobility, mobility, rtol=1e-9)


WINDOW = Window(1.4, 1.1)


def test_below_coincidence_a_finite_panel_radiates_by_its_edges() -> None:
    # near field of the force, and bending waves of energy Re(Y)/(eta w) that radiate as the window says
    layer = STEEL | {"loss_factor": 0.001}
    stack = plate(layer, ambient=THIN_GAS)
    gas, omega = stack.ambient.gas, 2 * np.pi * F
    found, infinite = driven(stack, F, PointForce(), window=WINDOW), driven(stack, F, PointForce())
    assert found.radiated_power is not None
    assert infinite.radiated_power is not None
    bending = (omega**2 * mass(STEEL) / stiffness(STEEL)) ** 0.25
    k0 = omega / gas.sound_speed
    # the mean over the width of the resonance and over some standing waves: that of edges
    edges = 2 * (1.4 + 1.1) / (np.pi * 1.4 * 1.1) * k0**2 / (bending**2 - k0**2) ** 1.5
    velocity = 1 / (8 * np.sqrt(stiffness(STEEL) * mass(STEEL))) / (0.001 * omega * mass(STEEL))
    expected = infinite.radiated_power + gas.impedance * edges * velocity
    np.testing.assert_allclose(found.radiated_power[1:], expected[1:], rtol=0.3)
    assert np.all(found.radiated_power > 3 * infinite.radiated_power)
    # the motion is that of the infinite stack
    np.testing.assert_allclose(found.back_velocity, infinite.back_velocity, rtol=1e-3)


@pytest.mark.filterwarnings("ignore:.*bending wavelength")
def test_above_coincidence_the_size_hardly_matters() -> None:
    frequency, stack = np.array([1000.0, 2000.0]), plate(CONCRETE)
    found, infinite = (
        driven(stack, frequency, TappingMachine(), window=WINDOW),
        driven(stack, frequency, TappingMachine()),
    )
    np.testing.assert_allclose(found.radiated_power, infinite.radiated_power, rtol=0.1)


def test_the_edges_are_the_mean_of_the_radiation_of_short_waves() -> None:
    k0 = np.array([10.0])
    radiation = _FiniteRadiation(WINDOW, k0, 1.0)
    k = np.linspace(50.0, 70.0, 401)
    exact = radiation_impedance(WINDOW, k0, k).real
    edges = 2 * 2.5 / (np.pi * 1.54) * 100 / (k**2 - 100) ** 1.5
    assert np.mean(exact) == pytest.approx(np.mean(edges), rel=0.05)
    beyond = np.array([radiation.largest * 1.5])
    assert radiation.resistance(np.array([0]), beyond)[0] == pytest.approx(
        2 * 2.5 / (np.pi * 1.54) * 100 / (beyond[0] ** 2 - 100) ** 1.5
    )
    within = np.array([3.0, 20.0, 50.0])
    near = radiation_impedance(WINDOW, k0, within).real
    np.testing.assert_allclose(radiation.resistance(np.zeros(3, dtype=int), within), near, rtol=1e-6)
