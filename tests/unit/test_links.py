"""Links between leaves: mobilities, the closed forms of Sharp and Davy, a periodic wall, what they refuse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import trapezoid

from multilayer.errors import InputError, ValidityWarning
from multilayer.response import Window, diffuse_field, plane_wave
from multilayer.response.beside import Sound, stack_shares
from multilayer.response.construction import Construction, paths, wall_shares
from multilayer.response.linked_transmission import linked_transmission
from multilayer.response.links import LineLinks, PointLinks
from multilayer.response.single_links import line_mobility
from multilayer.stack import Stack

FREQUENCY = np.array([500.0, 1000.0, 1600.0])
WOOL = {
    "type": "limp", "name": "wool", "thickness": 0.3, "porosity": 0.98, "flow_resistivity": 2e4, "tortuosity": 1.0,
    "viscous_length": 8e-5, "thermal_length": 1.6e-4, "frame_density": 60,
}  # fmt: skip
HEAVY = {  # limp: its critical frequency lies near 50 kHz
    "type": "elastic_plate", "thickness": 0.01, "density": 4000, "young_modulus": 7e7, "poisson_ratio": 0.0,
    "loss_factor": 0.05,
}  # fmt: skip
MASS, STIFFNESS = 40.0, 7e7 * 1e-6 / 12
WALL = Stack(layers=[{"name": "front", **HEAVY}, WOOL, {"name": "back", **HEAVY}], termination="ambient")
BETWEEN = {"between": ("front", "back")}
APART = 40.0  # m: the sound of each by itself


def structure_borne(links, stack=WALL, **field):
    """Return what links transmit beside the layers."""
    alone = diffuse_field(stack, FREQUENCY, field.get("max_angle", 78.0), tolerance_db=1e-3).transmission_coefficient
    return linked_transmission(stack, links, FREQUENCY, **field) - alone


@pytest.mark.parametrize("compliance", [0.0, 1e-7, 1e-6])
def test_studs_are_those_of_sharp_and_davy(compliance):
    """T. E. Vigran, Building Acoustics (2008), eq. (8.27), of limp leaves and studs far apart; 0 is Sharp's."""
    gas, omega = WALL.ambient.gas, 2 * np.pi * FREQUENCY
    g = 2 * MASS * np.sqrt(gas.sound_speed**2 * np.sqrt(MASS / STIFFNESS))
    hindered = g**2 + (4 * omega**1.5 * MASS**2 * gas.sound_speed * compliance - g) ** 2
    expected = 64 * gas.density**2 * gas.sound_speed**3 / (hindered * APART * omega**2)
    found = structure_borne([LineLinks(**BETWEEN, spacing=APART, compliance=compliance)], max_angle=90.0)
    assert np.abs(10 * np.log10(found / expected)).max() < 0.35


def test_ties_are_those_of_sharp():
    """Power (8 / pi^3) rho c (c/fc)^2 v^2 of a point that moves with v, half of the front leaf's motion 2 p/(w m)."""
    gas, omega = WALL.ambient.gas, 2 * np.pi * FREQUENCY
    critical = gas.sound_speed**2 / (2 * np.pi) * np.sqrt(MASS / STIFFNESS)
    power = 8 / np.pi**3 * gas.impedance * (gas.sound_speed / critical) ** 2 / (omega * MASS) ** 2
    expected = power * 2 * gas.impedance / 5**2  # twice: of a diffuse field half of the power meets the wall
    found = structure_borne([PointLinks(**BETWEEN, spacing=5.0)], max_angle=90.0)
    above = slice(1, None)  # of the airborne sound, to which the wave as it came adds by pressure
    assert np.abs(10 * np.log10(found / expected))[above].max() < 0.05


def test_line_mobility_is_the_mean_of_all_wavenumbers():
    mass, stiffness, omega = 9.0, 40 * (1 + 0.2j), 2 * np.pi * 500
    k = np.linspace(-2000, 2000, 200_001)
    mean = trapezoid(1j * omega / (stiffness * k**4 - mass * omega**2), k) / (2 * np.pi)
    found = line_mobility(np.array(mass), np.array(stiffness), np.array(omega))
    assert found == pytest.approx(mean, rel=1e-3)


def test_soft_links_carry_nothing():
    soft = linked_transmission(WALL, [LineLinks(**BETWEEN, spacing=0.6, compliance=1e3)], FREQUENCY)
    assert_allclose(soft, diffuse_field(WALL, FREQUENCY).transmission_coefficient, rtol=5e-3)


def test_a_light_leaf_between_passes_the_force_on():
    """Two links on one line, compliances in series."""
    skin = {"type": "elastic_plate", "name": "skin", "thickness": 1e-5, "density": 100, "young_modulus": 1e5}
    thin = {**WOOL, "thickness": 0.15}
    layers = [WALL.layers[0], thin, {**skin, "poisson_ratio": 0.0}, {**thin, "name": "more"}, WALL.layers[2]]
    stack = Stack(layers=layers, termination="ambient")
    line = {"spacing": 5.0}
    both = [LineLinks(between=pair, compliance=2e-7, **line) for pair in (("front", "skin"), ("skin", "back"))]
    one = [LineLinks(**BETWEEN, compliance=4e-7, **line)]
    assert_allclose(structure_borne(both, stack), structure_borne(one, stack), rtol=0.02)


def test_apart_links_are_weaker_than_those_on_one_line():
    layers = [WALL.layers[0], WOOL, {"name": "middle", **HEAVY}, {**WOOL, "name": "more"}, WALL.layers[2]]
    stack = Stack(layers=layers, termination="ambient")
    first, second = (("front", "middle"), ("middle", "back"))
    aligned = [LineLinks(between=pair, spacing=0.6) for pair in (first, second)]
    apart = [LineLinks(between=first, spacing=0.6), LineLinks(between=second, spacing=0.61)]
    one, other = (linked_transmission(stack, links, FREQUENCY) for links in (aligned, apart))
    assert np.all(10 * np.log10(one / other) > 3)


@pytest.mark.parametrize("angle", [0.0, 60.0])
def test_plane_waves(angle):
    links = [LineLinks(**BETWEEN, spacing=0.6, compliance=1e3)]
    expected = 10 ** (-plane_wave(WALL, FREQUENCY, angle).transmission_loss / 10)
    assert_allclose(linked_transmission(WALL, links, FREQUENCY, angle), expected, rtol=1e-3)
    rigid = [LineLinks(**BETWEEN, spacing=0.6)]
    assert np.all(linked_transmission(WALL, rigid, FREQUENCY, angle) > 10 * expected)


def test_plane_waves_average_to_the_diffuse_field():
    links = [LineLinks(**BETWEEN, spacing=0.6, compliance=1e-7)]
    nodes, weights = np.polynomial.legendre.leggauss(20)
    s = np.sin(np.deg2rad(78)) ** 2 * (nodes + 1) / 2
    waves = [linked_transmission(WALL, links, FREQUENCY, float(np.rad2deg(np.arcsin(np.sqrt(v))))) for v in s]
    assert_allclose(linked_transmission(WALL, links, FREQUENCY), weights / 2 @ np.array(waves), rtol=3e-3)


@pytest.mark.parametrize("sound", [Sound(), Sound(0.0)])
def test_finite_walls(sound):
    window = Window(4.0, 2.5)
    wall = Construction(**dict(WALL), links=[{"kind": "line", **BETWEEN, "spacing": 0.6, "compliance": 1e3}])
    found = wall_shares(wall, FREQUENCY, sound, window).transmission
    assert_allclose(found, stack_shares(WALL, FREQUENCY, sound, window).transmission, rtol=5e-3)


def test_boards_upon_each_other_are_one_leaf():
    board = {key: value for key, value in HEAVY.items() if key != "name"} | {"thickness": 0.005}
    doubled = [{"name": "front", **board}, board, WOOL, board, {"name": "back", **board}]
    stack = Stack(layers=doubled, termination="ambient")
    softer = {**HEAVY, "young_modulus": 7e7 / 4}  # two boards that slip bend four times as easily
    single = Stack(layers=[{"name": "front", **softer}, WOOL, {"name": "back", **softer}], termination="ambient")
    links = [LineLinks(**BETWEEN, spacing=0.6)]
    found, expected = (linked_transmission(one, links, FREQUENCY) for one in (stack, single))
    assert_allclose(found, expected, rtol=1e-6)


def test_parts_of_a_wall():
    wall = Construction(
        **dict(WALL), area=10.0, links=[{"kind": "line", **BETWEEN, "spacing": 0.6}],
        beside=[{"type": "flanking", "transmission_loss": 70}],
    )  # fmt: skip
    found = paths(wall, FREQUENCY, Sound())
    assert list(found) == ["stack", "links", "flanking 1"]
    total = linked_transmission(WALL, wall.links, FREQUENCY) + 1e-7
    assert_allclose(wall_shares(wall, FREQUENCY, Sound()).transmission, total, rtol=1e-9)


@pytest.mark.parametrize("periodic", [False, True])
def test_what_links_send_on_is_absorbed(periodic: bool):
    leaf = {"type": "elastic_plate", "thickness": 0.0125, "density": 700.0, "young_modulus": 3e9, "poisson_ratio": 0.2}
    layers = [{"name": "front", **leaf}, {"type": "fluid", "thickness": 0.09}, {"name": "back", **leaf}]
    links = [{"kind": "line", **BETWEEN, "spacing": 0.4, "periodic": periodic}]
    wall = Construction(layers=layers, termination="ambient", links=links)
    shares = wall_shares(wall, FREQUENCY, Sound(45.0))
    assert shares.transmission is not None
    assert_allclose(shares.absorption, shares.transmission, rtol=1e-6)  # nothing is lost in between


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")  # close to each other
@pytest.mark.parametrize("window", [None, Window(3.0, 3.0)])
@pytest.mark.parametrize("links", [{"kind": "line", "periodic": True}, {"kind": "line"}, {"kind": "point"}])
def test_a_wall_absorbs_no_less_than_nothing(links: dict, window: Window | None):
    leaf = {"type": "elastic_plate", "thickness": 0.0125, "density": 700.0, "young_modulus": 3e9, "poisson_ratio": 0.2}
    layers = [{"name": "front", **leaf}, {"type": "fluid", "thickness": 0.09}, {"name": "back", **leaf}]
    wall = Construction(layers=layers, termination="ambient", links=[{**links, **BETWEEN, "spacing": 0.3}])
    absorbed = wall_shares(wall, np.geomspace(50.0, 2000.0, 20), Sound(0.0), window).absorption
    assert np.all(absorbed >= -1e-12)
    assert window is not None or np.all(absorbed <= 1 + 1e-12)


def test_close_links_warn():
    with pytest.warns(ValidityWarning, match="spacing / bending wavelength of a leaf from 0.5"):
        linked_transmission(WALL, [LineLinks(**BETWEEN, spacing=0.01)], FREQUENCY)


@pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")  # close to each other
@pytest.mark.parametrize("sound", [Sound(), Sound(0.0)])
@pytest.mark.parametrize("kind", ["line", "point"])
def test_links_that_let_more_through_than_arrives_are_refused(kind: str, sound: Sound):
    frequency = np.array([125.0, 3000.0])
    leaf = {"type": "elastic_plate", "thickness": 0.0125, "density": 800.0, "young_modulus": 2.5e9}
    leaf |= {"poisson_ratio": 0.3, "loss_factor": 0.03}
    layers = [{"name": "front", **leaf}, {"type": "fluid", "thickness": 0.07}, {"name": "back", **leaf}]

    def shares(together: int = 1, **fields):
        link = {"kind": kind, **BETWEEN, "spacing": 0.02, **fields}
        wall = Construction(layers=layers, termination="ambient", links=[link])
        return wall_shares(wall, frequency, sound, together=together)

    with pytest.raises(InputError, match=r"links: so close, .* times as much through as arrives, at 125 Hz.*spacing"):
        shares()
    with pytest.raises(InputError, match="times as much through as arrives, at 1562 Hz"):
        shares(together=2)
    assert np.all(shares(spacing=0.6).transmission <= 1)
    if kind == "line":
        assert np.all(shares(periodic=True).transmission <= 1)


def test_the_same_links_twice_are_refused():
    one = {"kind": "line", **BETWEEN, "spacing": 0.6}
    with pytest.raises(InputError, match="held together already"):
        Construction(**dict(WALL), links=[one, {**one, "compliance": 1e-6}])
    Construction(**dict(WALL), links=[one, {**one, "spacing": 0.4}])


@pytest.mark.parametrize(
    ("links", "fields", "text"),
    [
        ({"between": ["front", "bakc"]}, {}, "no layer 'bakc'"),
        ({"between": ["front", "wool"]}, {}, "hold plates together"),
        ({"between": ["front", "front"]}, {}, "one leaf"),
        ({}, {"termination": "rigid"}, "between two rooms"),
        ({"kind": "area"}, {}, "allowed"),
        ({"spacing": 0.0}, {}, "above 0"),
        ({"compliance": "1e-6 m/N"}, {}, "wrong unit"),
    ],
)
def test_refused(links, fields, text):
    with pytest.raises(InputError, match=text):
        Construction(**{**dict(WALL), "links": [{"kind": "line", **BETWEEN, "spacing": 0.6, **links}], **fields})
