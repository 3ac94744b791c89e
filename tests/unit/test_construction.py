"""Walls of several paths: areas, powers, what they refuse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError
from multilayer.media.openings import hole_passage, slit_passage
from multilayer.response import diffuse_field, plane_wave
from multilayer.response.beside import Sound, stack_shares
from multilayer.response.construction import Construction, paths, wall_shares
from multilayer.response.finite_size import Window
from multilayer.stack import Stack

FREQUENCY = np.array([125.0, 500.0, 2000.0])
FIELD = Sound()
GLASS = {"type": "elastic_plate", "thickness": 4e-3, "density": 2500, "young_modulus": 6e10, "poisson_ratio": 0.22}
BRICK = {"type": "elastic_plate", "thickness": 0.04, "density": 1700, "young_modulus": 5e9, "poisson_ratio": 0.2}
BRICK["loss_factor"] = GLASS["loss_factor"] = 0.02
WATER = {"type": "fluid", "density": 1000.0, "sound_speed": 1480.0}
WINDOW = {"type": "patch", "name": "window", "area": 2.0, "stack": {"layers": [GLASS], "termination": "ambient"}}


def wall(*beside, **fields):
    return Construction(**{"layers": [BRICK], "termination": "ambient", "area": 10.0, "beside": beside, **fields})


def tau(layer, frequency=FREQUENCY):
    return diffuse_field(Stack(layers=(layer,), termination="ambient"), frequency).transmission_coefficient


class TestPaths:
    def test_window_in_a_wall(self):
        expected = 0.8 * tau(BRICK) + 0.2 * tau(GLASS)
        assert_allclose(wall_shares(wall(WINDOW), FREQUENCY, FIELD).transmission, expected, rtol=1e-12)

    def test_without_anything_it_is_the_stack(self):
        plain = wall(area=None)
        assert plain.is_plain
        assert_allclose(wall_shares(plain, FREQUENCY, FIELD).transmission, tau(BRICK), rtol=1e-12)

    def test_patch_of_the_same_layers_changes_nothing(self):
        same = {**WINDOW, "stack": {"layers": [BRICK], "termination": "ambient"}}
        for sound in (FIELD, Sound(45.0)):
            one = stack_shares(wall(), FREQUENCY, sound)
            both = wall_shares(wall(same), FREQUENCY, sound)
            assert_allclose(both.transmission, one.transmission, rtol=1e-12)
            assert_allclose(both.absorption, one.absorption, rtol=1e-12)

    def test_openings(self):
        slit = {"type": "slit", "width": 2e-3, "length": 1.0, "depth": 0.1, "at_edge": True}
        hole = {"type": "hole", "radius": 0.01, "depth": 0.1, "count": 5}
        built = wall(slit, hole)
        gas, found = built.ambient.gas, paths(built, FREQUENCY, FIELD)
        leak = slit_passage(FREQUENCY, 2e-3, 1.0, 0.1, gas, at_edge=True)
        assert list(found) == ["stack", "slit 1", "hole 2"]
        assert_allclose(found["slit 1"].transmission, 2e-4 * leak.transmission, rtol=1e-12)
        through = hole_passage(FREQUENCY, 0.01, 0.1, gas).absorption
        assert_allclose(found["hole 2"].absorption, 5 * np.pi * 1e-4 / 10 * through, rtol=1e-12)

    def test_flanking_adds_power_and_no_absorption(self):
        found = wall_shares(wall({"type": "flanking", "transmission_loss": 40}), FREQUENCY, FIELD)
        assert_allclose(found.transmission, tau(BRICK) + 1e-4, rtol=1e-12)
        assert_allclose(found.absorption, stack_shares(wall(), FREQUENCY, FIELD).absorption, rtol=1e-12)

    def test_flanking_spectrum(self):
        spectrum = {"frequency": [100, 400, 1600], "transmission_loss": [30, 40, 60]}
        built = wall({"type": "flanking", "name": "floor", "spectrum": spectrum})
        found = paths(built, np.array([90.0, 200, 400, 2000]), FIELD)["floor"].transmission
        assert_allclose(-10 * np.log10(found), [30, 35, 40, 60], rtol=1e-9)
        with pytest.raises(InputError, match=r"says nothing of 50 Hz"):
            paths(built, np.array([50.0, 400.0]), FIELD)

    def test_absorbers_side_by_side(self):
        wool = {"type": "equivalent_fluid", "model": "miki", "thickness": 0.05, "flow_resistivity": 1e4}
        thick = {**wool, "thickness": 0.2}
        built = Construction(
            layers=[wool], area=4.0, beside=[{"type": "patch", "area": 1.0, "stack": {"layers": [thick]}}]
        )
        thin_one, thick_one = (diffuse_field(Stack(layers=(w,)), FREQUENCY).absorption for w in (wool, thick))
        found = wall_shares(built, FREQUENCY, FIELD)
        assert found.transmission is None
        assert_allclose(found.absorption, 0.75 * thin_one + 0.25 * thick_one, rtol=1e-12)

    def test_patches_have_their_own_size(self):
        sized = {key: value for key, value in WINDOW.items() if key != "area"} | {"width": 1.0, "height": 2.0}
        pane, big = Stack(layers=(GLASS,), termination="ambient"), Window(4, 2.5)
        for sound, alone in (
            (FIELD, lambda: diffuse_field(pane, FREQUENCY, window=Window(1, 2)).transmission_coefficient),
            (Sound(0.0), lambda: stack_shares(pane, FREQUENCY, Sound(0.0), Window(1, 2)).transmission),
        ):
            found = paths(wall(sized), FREQUENCY, sound, big)["window"].transmission
            assert_allclose(found, 0.2 * alone(), rtol=1e-12)

    def test_the_walls_air_counts(self):
        thin = {"temperature": 293.15, "density": 0.6}
        found = paths(wall(WINDOW, ambient=thin), FREQUENCY, Sound(0.0))["window"].transmission
        pane = Stack(layers=(GLASS,), termination="ambient", ambient=thin)
        assert_allclose(-10 * np.log10(found / 0.2), plane_wave(pane, FREQUENCY).transmission_loss, rtol=1e-12)


@pytest.mark.parametrize(
    ("beside", "fields", "text"),
    [
        ([WINDOW], {"area": None}, "area of the whole wall"),
        ([WINDOW], {"area": 2.0}, "nothing is left"),
        ([WINDOW, {**WINDOW, "area": 1.0}], {}, "called 'window' already"),
        ([{**WINDOW, "stack": {"layers": [GLASS]}}], {}, "must end alike"),
        ([{**WINDOW, "width": 1.0}], {}, "either an area, or width and height"),
        ([{key: value for key, value in WINDOW.items() if key != "area"} | {"width": 1.0}], {}, "either an area"),
        ([{"type": "slit", "width": 2.0, "length": 1.0, "depth": 0.1}], {}, "must not exceed the length"),
        ([{"type": "hole", "radius": 0.01, "depth": 0.1}], {"termination": "rigid"}, "leads nowhere"),
        (
            [{"type": "hole", "radius": 0.01, "depth": 0.1}],
            {"termination": WATER},
            "hole is filled .* 'termination: amb",
        ),
        (
            [{"type": "slit", "width": 0.01, "length": 1.0, "depth": 0.1}],
            {"termination": WATER},
            "slit is filled .* 'termination: ambient'",
        ),
        ([{"type": "flanking"}], {}, "either a transmission_loss"),
        ([{"type": "flanking", "spectrum": {"frequency": [2, 1], "transmission_loss": [3, 4]}}], {}, "must rise"),
        ([{"type": "flanking", "spectrum": {"frequency": [2], "transmission_loss": [3, 4]}}], {}, "2 values stand"),
        ([{"type": "door"}], {}, "allowed"),
    ],
)
def test_refused(beside, fields, text):
    with pytest.raises(InputError, match=text):
        wall(*beside, **fields)


def test_what_is_no_opening_may_lead_into_another_fluid():
    patch = {**WINDOW, "stack": {"layers": [GLASS], "termination": WATER}}
    wall(patch, {"type": "flanking", "transmission_loss": 40}, termination=WATER)


@pytest.mark.parametrize("sound", [FIELD, Sound(45.0)])
def test_a_size_takes_the_same_gas_on_both_sides(sound):
    """The radiation efficiency would be that of the fluid behind, in which waves may be evanescent."""
    stack = Stack(layers=(GLASS,), termination=WATER)
    with pytest.raises(InputError, match=r"^finite_size: .* 'termination: ambient', or leave the size out"):
        stack_shares(stack, FREQUENCY, sound, Window(1.4, 1.1))
    stack_shares(stack, FREQUENCY, sound)
    same = Stack(layers=(GLASS,), termination={"type": "fluid"})
    found = stack_shares(same, FREQUENCY, sound, Window(1.4, 1.1)).transmission
    expected = stack_shares(Stack(layers=(GLASS,), termination="ambient"), FREQUENCY, sound, Window(1.4, 1.1))
    assert_allclose(found, expected.transmission, rtol=1e-12)
