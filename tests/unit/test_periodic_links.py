"""Lines at equal distances: a wall solved otherwise, and what follows from symmetry, mass and distance."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError
from multilayer.matrix.wave import Wave
from multilayer.response import Window, diffuse_field
from multilayer.response import linked_transmission as linked
from multilayer.response.bands import band_points
from multilayer.response.construction import Construction
from multilayer.response.driven_leaves import DrivenLeaves, front_velocity
from multilayer.response.linked_transmission import linked_transmission
from multilayer.response.links import Leaf, LineLinks, PointLinks
from multilayer.response.system import between_gas, solve_or_explain
from multilayer.stack import Stack
from validation import walls

FREQUENCY = np.array([160.0, 500.0, 1250.0])
BOARD = {"type": "elastic_plate", "loss_factor": 0.05, **walls.BOARD}
WOOL = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.07, "flow_resistivity": 8e3}
FOAM = {
    "type": "poroelastic", "name": "foam", "thickness": 0.03, "porosity": 0.97, "flow_resistivity": 1e4,
    "tortuosity": 1.5, "viscous_length": 1e-4, "thermal_length": 2e-4, "frame_density": 30.0,
    "young_modulus": 1e5, "loss_factor": 0.2, "poisson_ratio": 0.3,
}  # fmt: skip
AIR = {"type": "fluid", "thickness": 0.1}
SKIN = {"type": "elastic_plate", "name": "skin", "thickness": 1e-5, "density": 1e-3, "young_modulus": 1e5,
        "poisson_ratio": 0.0}  # fmt: skip
WALL = [{"name": "front", **BOARD}, WOOL, {"name": "back", **BOARD}]
LINES = LineLinks(between=("front", "back"), spacing=0.6, periodic=True)

pytestmark = pytest.mark.filterwarnings("ignore::multilayer.errors.ValidityWarning")  # Miki's range


def transmission(layers, lines=(LINES,), frequency=FREQUENCY, **field):
    return linked_transmission(Stack(layers=layers, termination="ambient"), lines, frequency, **field)


def enough_directions(monkeypatch):
    """Take more directions than usual, which err by some tenths of a decibel at single frequencies."""
    monkeypatch.setattr(linked, "_LATTICES", ((34, 21), (89, 55), (4181, 2584)))


def decibels(one, other):
    return 10 * np.log10(one / other)


@pytest.mark.parametrize(
    "studs", [walls.Studs(0.6, 0.0, 0.05), walls.Studs(0.4, 1e-6, 0.1), walls.Studs(1.2, 0.0, 0.2)]
)
def test_a_wall_that_is_solved_as_a_whole(studs, monkeypatch):
    """`validation.walls.periodic` shares nothing with it but the formulae of the wool."""
    enough_directions(monkeypatch)
    monkeypatch.setattr(walls, "_THETAS", 96)
    monkeypatch.setattr(walls, "_AZIMUTHS", 96)
    layers = [{**layer, "loss_factor": studs.loss_factor} if layer is not WOOL else layer for layer in WALL]
    line = LineLinks(between=("front", "back"), spacing=studs.spacing, compliance=studs.compliance, periodic=True)
    frequency = np.array([*FREQUENCY, 4000.0])  # the last beyond coincidence
    assert np.abs(decibels(transmission(layers, [line], frequency), walls.periodic(frequency, studs))).max() < 0.1


@pytest.mark.parametrize(("compliance", "fasteners"), [(0.0, 0.3), (1e-6, 0.5)])
def test_a_wall_with_fasteners_that_is_solved_as_a_whole(compliance, fasteners, monkeypatch):
    """A plain sum over both kinds of harmonics, of so many that 0.5 % of the plates' mobility are left out."""
    enough_directions(monkeypatch)
    monkeypatch.setattr(walls, "_THETAS", 48)
    monkeypatch.setattr(walls, "_AZIMUTHS", 48)
    studs = walls.Studs(0.4, compliance, 0.05, fasteners)
    frequency = np.array([100.0, 315.0, 800.0])
    line = LineLinks(between=("front", "back"), spacing=0.4, compliance=compliance, periodic=True, fasteners=fasteners)
    assert np.abs(decibels(transmission(WALL, [line], frequency), walls.periodic(frequency, studs))).max() < 0.1


def test_fasteners_close_to_each_other_hold_all_along():
    close = LineLinks(between=("front", "back"), spacing=0.6, periodic=True, fasteners=0.01)
    assert np.abs(decibels(transmission(WALL, [close]), transmission(WALL))).max() < 0.05


def test_fasteners_far_from_each_other_are_points():
    """What each gives way hinders here as much as the leaves do."""
    damped = [{**layer, "loss_factor": 0.5} if layer is not WOOL else layer for layer in WALL]
    frequency, leaves = np.array([400.0, 800.0]), {"between": ("front", "back"), "spacing": 1.0}
    airborne = diffuse_field(Stack(layers=damped, termination="ambient"), frequency).transmission_coefficient
    lines = transmission(damped, [LineLinks(**leaves, compliance=1.5e-6, periodic=True, fasteners=1.0)], frequency)
    points = transmission(damped, [PointLinks(**leaves, compliance=1.5e-6)], frequency)
    assert np.all(points > 1.7 * airborne)
    assert np.abs(decibels(lines - airborne, points - airborne)).max() < 0.5


def test_a_leaf_passes_the_force_of_fasteners_on():
    """Links in two pieces, a light leaf between, are one link that gives way as much as both."""
    half = {**WOOL, "thickness": 0.035}
    layers = [WALL[0], half, SKIN, half, {**WALL[2], "thickness": 0.009}]
    held = {"spacing": 0.6, "periodic": True, "fasteners": 0.5}
    both = [LineLinks(between=pair, compliance=2e-7, **held) for pair in (("front", "skin"), ("skin", "back"))]
    one = LineLinks(between=("front", "back"), compliance=4e-7, **held)
    low = FREQUENCY[:1]
    whole = transmission([WALL[0], WOOL, layers[-1]], [one], low)
    assert np.abs(decibels(transmission(layers, both, low), whole)).max() < 0.05


STACKS = {
    "wool": WALL,
    "air": [WALL[0], {**AIR, "thickness": 0.2}, WALL[2]],
    "foam": [FOAM, WALL[0], {**FOAM, "name": "second"}, WALL[2]],
    "three": [WALL[0], AIR, {**WALL[2], "name": "middle"}, WOOL, WALL[2]],
    "concrete": [
        {**BOARD, "name": name, "thickness": 0.1, "density": 2300.0, "young_modulus": 3e10, "loss_factor": 0.01}
        if name
        else AIR
        for name in ("front", "", "back")
    ],
}


@pytest.mark.parametrize("name", STACKS)
def test_answers_of_leaves_between_nodes(name):
    """As they are solved there."""
    stack = Stack(layers=STACKS[name], termination="ambient")
    frequency = np.array([20.0, 500.0, 3000.0, 12_500.0])
    which = np.repeat(np.arange(4), 500)
    sound = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    plates = [i for i, layer in enumerate(stack.layers) if layer.type == "elastic_plate"]
    driven = DrivenLeaves(stack, [Leaf(i, i) for i in plates], frequency, 10 * sound)
    rng = np.random.default_rng(1)
    slow = sound[which] * rng.uniform(1, 9, len(which))
    fast = sound[which] * np.sqrt(rng.uniform(0, 1, len(which)))
    exact, found = driven.solved(which, fast), driven.answers(which, fast)
    off = [
        off_mobility(driven.mobility(which, slow), driven.solved(which, slow).mobility),
        off_mobility(found.mobility, exact.mobility),
        np.abs(found.passed - exact.passed).max(axis=0) / np.abs(exact.passed).max(axis=0),
        np.abs(found.blocked - exact.blocked) / 2,
    ]
    assert np.median(off) < 1e-6
    assert np.max(off) < 5e-3


def off_mobility(mobility, exact):
    size = np.sqrt(np.abs(np.einsum("iin->in", exact)))  # other entries fade with the depth of the cavity
    return (np.abs(mobility - exact) / (size[:, None] * size)).max(axis=(0, 1))


@pytest.mark.parametrize("name", STACKS)
def test_a_wave_that_arrives_is_a_pressure_on_the_first_leaf(name):
    """By reciprocity; beside the solution of the whole with that wave."""
    stack = Stack(layers=STACKS[name], termination="ambient")
    frequency = np.array([20.0, 500.0, 3000.0, 12_500.0])
    plates = [i for i, layer in enumerate(stack.layers) if layer.type == "elastic_plate"]
    sound = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    driven = DrivenLeaves(stack, [Leaf(i, i) for i in plates], frequency, 10 * sound)
    for angle in (0.0, 45.0, 89.0):
        wave = Wave.incident(frequency, angle, stack.ambient.gas)
        system = between_gas(stack, wave)
        whole = solve_or_explain(system, stack, wave)
        answers = driven.solved(np.arange(4), wave.kx.real)
        assert_allclose(answers.blocked * answers.passed[0], whole.transmitted, rtol=1e-8)
        for leaf, plate in enumerate(plates):
            moved = front_velocity(system, plate, whole.layers[plate])
            assert_allclose(answers.blocked * answers.mobility[0, leaf], moved, rtol=1e-8)


def test_more_directions_change_little(monkeypatch):
    soft = LineLinks(between=("front", "back"), spacing=0.6, compliance=1e-6, periodic=True)
    frequency = np.geomspace(100, 4000, 25)
    usual = [transmission(WALL, [line], frequency) for line in (LINES, soft)]
    enough_directions(monkeypatch)
    more = [transmission(WALL, [line], frequency) for line in (LINES, soft)]
    gap = decibels(np.array(usual), np.array(more))
    assert np.sqrt(np.mean(gap**2)) < 0.15
    assert np.abs(gap).max() < 1.0


def test_means_over_bands_take_fewer_directions(monkeypatch):
    bands = band_points(np.array([125.0, 500.0, 2000.0]), "third octaves")
    of_bands = transmission(WALL, frequency=bands.ravel(), together=bands.shape[1]).reshape(bands.shape)
    enough_directions(monkeypatch)
    exact = transmission(WALL, frequency=bands.ravel()).reshape(bands.shape)
    assert np.abs(decibels(of_bands.mean(axis=1), exact.mean(axis=1))).max() < 0.1
    assert np.abs(decibels(of_bands, exact)).max() > 0.1  # errors of single frequencies cancel


def test_extremes(monkeypatch):
    """1 Hz and 20 kHz, beside a solution as a whole; a harmonic that grazes exactly; angles of 0 and 89.9 degrees."""
    monkeypatch.setattr(walls, "_THETAS", 96)
    studs, frequency = walls.Studs(0.6, 0.0, 0.05), np.array([1.0, 20_000.0])
    assert decibels(transmission(WALL, frequency=frequency), walls.periodic(frequency, studs)) == pytest.approx(
        0, abs=0.3
    )
    air = {"sound_speed": 340.0}
    grazes = linked_transmission(
        Stack(ambient=air, layers=WALL, termination="ambient"),
        [LineLinks(between=("front", "back"), spacing=0.34, periodic=True)],
        1000.0 * np.array([1 - 1e-8, 1]),
        0.0,
    )
    assert grazes[1] == pytest.approx(grazes[0], rel=0.1)
    for angle in (0.0, 89.9):
        assert np.all((tau := transmission(WALL, angle=angle)) > 0)
        assert np.all(tau < 1)
    near, nearer = (transmission(WALL, angle=angle) for angle in (89.997, 89.998))  # falls as the cosine, or its square
    assert np.all(np.abs(np.log(near / nearer) / np.log(3 / 2) - 1.5) < 0.51)


def test_lines_far_apart_are_refused_where_they_take_too_many_harmonics():
    with pytest.raises(InputError, match="leave 'periodic' and 'fasteners' out"):
        transmission(WALL, [LineLinks(between=("front", "back"), spacing=50.0, periodic=True)], np.array([2e4]))
    held = LineLinks(between=("front", "back"), spacing=1.0, periodic=True, fasteners=1.0)
    with pytest.raises(InputError, match="write links of kind: point"):
        transmission(WALL, [held], np.array([5e4]))


def test_a_window_at_one_frequency():
    """Where its radiation is integrated for each direction."""
    window, frequency = Window(4.0, 2.5), np.array([3000.0, 3001.0])
    alone = transmission(WALL, frequency=frequency[:1], window=window)
    assert_allclose(alone, transmission(WALL, frequency=frequency, window=window)[:1], rtol=1e-6)


@pytest.mark.parametrize("window", [None, Window(4.0, 2.5)])
def test_soft_lines_carry_nothing(window):
    soft = LineLinks(between=("front", "back"), spacing=0.6, compliance=1e3, periodic=True)
    alone = diffuse_field(Stack(layers=WALL, termination="ambient"), FREQUENCY, window=window)
    assert_allclose(transmission(WALL, [soft], window=window), alone.transmission_coefficient, rtol=3e-3)


def test_lines_far_apart_do_not_know_of_each_other():
    """But for the air and the cavity, which single links leave out where they move a leaf."""
    damped = [{**layer, "loss_factor": 0.5} if layer is not WOOL else layer for layer in WALL]
    far = {"between": ("front", "back"), "spacing": 4.0}
    whole = transmission(damped, [LineLinks(**far, periodic=True)])
    single = transmission(damped, [LineLinks(**far)])
    assert np.abs(decibels(whole, single)).max() < 0.3


def test_both_sides_of_a_wall_are_alike_in_a_diffuse_field(monkeypatch):
    """By reciprocity: as much goes from all directions to all directions either way."""
    enough_directions(monkeypatch)
    layers = [FOAM, {"name": "front", **BOARD}, WOOL, {"name": "back", **BOARD, "thickness": 0.02}]
    one, other = (transmission(order, max_angle=90.0) for order in (layers, layers[::-1]))
    assert np.abs(decibels(one, other)).max() < 0.15


def test_the_room_may_begin_anywhere():
    """A layer of its air in front of a wall, and one behind it, change nothing but what is interpolated."""
    assert_allclose(transmission([AIR, *WALL, AIR]), transmission(WALL), rtol=1e-5)


def test_a_light_leaf_between_passes_the_force_on():
    half = {**WOOL, "thickness": 0.035}
    layers = [WALL[0], half, SKIN, half, WALL[2]]
    low = FREQUENCY[:2]
    both = [
        LineLinks(between=pair, spacing=0.6, compliance=2e-7, periodic=True)
        for pair in (("front", "skin"), ("skin", "back"))
    ]
    one = LineLinks(between=("front", "back"), spacing=0.6, compliance=4e-7, periodic=True)
    assert np.abs(decibels(transmission(layers, both, low), transmission(WALL, [one], low))).max() < 0.05


def test_plane_waves_average_to_the_diffuse_field():
    """Within what either rule leaves."""
    nodes, weights = np.polynomial.legendre.leggauss(16)
    s = np.sin(np.deg2rad(78)) ** 2 * (nodes + 1) / 2
    waves = [transmission(WALL, angle=float(np.rad2deg(np.arcsin(np.sqrt(value))))) for value in s]
    assert np.abs(decibels(weights / 2 @ np.array(waves), transmission(WALL))).max() < 0.2


@pytest.mark.parametrize(
    ("links", "text"),
    [
        ([{"periodic": True}, {"periodic": True, "spacing": 0.4}], "of one spacing"),
        ([{"periodic": True, "fasteners": 0.3}, {"periodic": True, "spacing": 0.6}], "the same 'spacing' and 'fasten"),
        ([{"fasteners": 0.3}], "write 'periodic: true'"),
        ([{"periodic": True}, {"spacing": 0.4}], "must all be such lines"),
        ([{"periodic": "perhaps"}], "periodic"),
        ([{"periodic": True, "kind": "point"}], "periodic"),
        ([{"periodic": True, "between": ["front", "slab"]}], "periodic lines hold thin plates"),
    ],
)
def test_refused(links, text):
    slab = {"type": "elastic_solid", "name": "slab", "thickness": 0.1, "density": 2300, "young_modulus": 3e10}
    layers = [*WALL[:2], WALL[2], WOOL, {**slab, "poisson_ratio": 0.2}]
    fields = {"kind": "line", "between": ["front", "back"], "spacing": 0.6}
    with pytest.raises(InputError, match=text):
        Construction(layers=layers, termination="ambient", links=[{**fields, **these} for these in links])
