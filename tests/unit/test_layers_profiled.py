"""Corrugated and ribbed plates: limits, second moments by summation, published formulae, coincidence."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.corrugated_plate import CorrugatedPlate
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.ribbed_plate import RibbedPlate
from multilayer.media.gas import dry_air
from multilayer.media.plates import Rigidities, corrugated, flat_resonance, ribbed, sinusoidal, trapezoidal
from multilayer.response import diffuse_field, plane_wave
from multilayer.stack import Stack

AIR = dry_air()
STEEL = {"density": 7800.0, "young_modulus": 2.1e11, "poisson_ratio": 0.3}
ROOF = {"thickness": 6e-4, **STEEL, "period": 0.076, "height": 0.018}
DECK = {"thickness": 7e-4, **STEEL, "period": 0.2, "height": 0.04, "crest_width": 0.03, "trough_width": 0.12}
RIBS = {"thickness": 2e-3, **STEEL, "rib_height": 0.02, "rib_width": 3e-3, "rib_spacing": 0.1}
E, NU = 2.1e11, 0.3


def line(profile, period, points=400001):
    """Return s / period, and the integrals of z^2 and of the squared cosine, of a line z(x) given by its corners."""
    x, z = profile
    at = np.linspace(0, period, points)
    z = np.interp(at, x, z)
    dx, dz = np.diff(at), np.diff(z)
    ds, middle = np.hypot(dx, dz), (z[1:] + z[:-1]) / 2
    middle = middle - np.sum(middle * ds) / np.sum(ds)
    return np.sum(ds) / period, np.sum(middle**2 * ds) / period, np.sum(dx**2 / ds) / period


class TestProfiles:
    def test_sine(self):
        x = np.linspace(0, 0.076, 100001)
        expected = line((x, 0.009 * np.sin(2 * np.pi * x / 0.076)), 0.076)
        profile = sinusoidal(0.076, 0.018)
        assert_allclose((profile.length, profile.square, profile.flatness), expected, rtol=1e-6)

    def test_shallow_sine(self):
        """Briassoulis 1986: amplitude^2 / 2."""
        assert sinusoidal(0.076, 1e-4).square == pytest.approx(0.5e-4**2 / 2, rel=1e-4)

    @pytest.mark.parametrize(("crest", "trough"), [(0.03, 0.12), (0.05, 0.05), (0.01, 0.01)])
    def test_trapezoids(self, crest, trough):
        run = (0.2 - crest - trough) / 2
        corners = (np.cumsum([0, crest, run, trough, run]), [0.04, 0.04, 0, 0, 0.04])
        profile = trapezoidal(0.2, 0.04, crest, trough)
        assert_allclose((profile.length, profile.square, profile.flatness), line(corners, 0.2), rtol=1e-4)

    def test_upright_flanks(self):
        profile = trapezoidal(0.1, 0.02, 0.05, 0.05)
        assert profile.length == pytest.approx(1.4)
        assert profile.square == pytest.approx((0.1 * 0.01**2 + 2 * 0.02**3 / 12) / 0.1)

    def test_flat_pieces_of_bies_and_hansen(self):
        """Sum of b (z^2 + (h^2 + b^2) / 24 + (h^2 - b^2) cos(2 angle) / 24), about the neutral axis."""
        h, flank, run = 7e-4, np.hypot(0.025, 0.04), 0.025
        pieces = [(0.03, 0.04, 0.0), (0.12, 0.0, 0.0), *[(flank, 0.02, np.arctan2(0.04, run))] * 2]
        centre = sum(b * z for b, z, _ in pieces) / sum(b for b, *_ in pieces)
        moment = h * sum(
            b * ((z - centre) ** 2 + (h**2 + b**2) / 24 + (h**2 - b**2) * np.cos(2 * angle) / 24)
            for b, z, angle in pieces
        )
        ours = trapezoidal(0.2, 0.04, 0.03, 0.12)
        assert E * moment / 0.2 == pytest.approx(corrugated(E, 0.0, h, ours).x, rel=1e-12)


class TestCorrugated:
    def test_across_and_mixed(self):
        """Timoshenko & Woinowsky-Krieger, section 86: l / s of the sheet's stiffness, s / l of its twist."""
        profile = sinusoidal(0.076, 0.018)
        ours = corrugated(E, NU, 6e-4, profile)
        assert ours.y == pytest.approx(E * 6e-4**3 / 12 / (1 - NU**2) / profile.length)
        twist = E * 6e-4**3 / 12 / (1 + NU) * profile.length
        assert ours.mixed == pytest.approx(twist + NU * ours.y)

    def test_loses_as_its_modulus(self):
        lossless, damped = (corrugated(e, NU, 6e-4, sinusoidal(0.076, 0.018)) for e in (E, E * (1 + 0.1j)))
        assert damped.at(0.6) == pytest.approx((1 + 0.1j) * lossless.at(0.6))


class TestRibbed:
    def test_second_moment(self):
        """By thin strips, those of the plate stiffer by 1 / (1 - nu^2)."""
        h, height, width, spacing = 2e-3, 0.02, 3e-3, 0.1
        z = (np.arange(220000) + 0.5) * 1e-7
        weight = np.where(z < h, spacing / (1 - NU**2), width)
        centre = np.sum(weight * z) / np.sum(weight)
        expected = E * np.sum(weight * (z - centre) ** 2) * 1e-7 / spacing
        assert ribbed(E, NU, h, height, width, spacing).x == pytest.approx(expected, rel=1e-6)

    def test_across(self):
        """Timoshenko & Woinowsky-Krieger: E a h^3 / (12 (a - t + alpha^3 t)), with 1 / (1 - nu^2)."""
        expected = E * 0.1 * 8e-9 / (12 * (1 - NU**2) * (0.1 - 3e-3 + (2 / 22) ** 3 * 3e-3))
        assert ribbed(E, NU, 2e-3, 0.02, 3e-3, 0.1).y == pytest.approx(expected)

    @pytest.mark.parametrize(("height", "width", "constant"), [(0.01, 0.01, 0.1406e-8), (0.5, 1e-3, 0.5e-9 / 3)])
    def test_torsion(self, height, width, constant):
        """Of a square 0.1406 a^4, of a thin strip a third of a b^3."""
        flat = E * 8e-9 / 12 / (1 - NU**2)
        twist = ribbed(E, NU, 2e-3, height, width, 1.0).mixed - flat
        assert twist == pytest.approx(E / 2.6 * constant / 2, rel=2e-3)

    def test_ribs_side_by_side_are_a_thicker_plate(self):
        thick = E * 0.012**3 / 12 / (1 - NU**2)
        ours = ribbed(E, NU, 2e-3, 0.01, 0.0999999, 0.1)
        assert ours.y == pytest.approx(thick, rel=1e-3)
        assert (1 - NU**2) * thick < ours.x < thick


@pytest.mark.parametrize("azimuth", [0.0, 35.0, 90.0])
@pytest.mark.parametrize(
    "layer",
    [
        CorrugatedPlate(**{**ROOF, "height": 1e-9}, loss_factor=0.01),
        CorrugatedPlate(**{**DECK, "height": 1e-9, "thickness": 6e-4}, loss_factor=0.01),
        RibbedPlate(**{**RIBS, "thickness": 6e-4, "rib_height": 1e-10}, loss_factor=0.01),
    ],
    ids=["sine", "trapezoids", "ribs"],
)
def test_flat_it_is_a_plate(layer, azimuth):
    flat = ElasticPlate(thickness=6e-4, **STEEL, loss_factor=0.01)
    ours, theirs = (
        plane_wave(Stack(layers=(each,), termination="ambient"), [40.0, 90.0], 70.0, azimuth=azimuth).transmission
        for each in (layer, flat)
    )
    assert_allclose(ours, theirs, rtol=1e-6)


def test_coincidence_along_and_across():
    """A plate without losses is transparent where k sin(angle) is its bending wavenumber."""
    layer = CorrugatedPlate(**ROOF)
    profile = sinusoidal(0.076, 0.018)
    rigidities: Rigidities = corrugated(E, NU, 6e-4, profile)
    mass = 7800 * 6e-4 * profile.length
    frequency = (AIR.sound_speed / np.sin(np.radians(75))) ** 2 / (2 * np.pi) * np.sqrt(mass / rigidities.x)
    stack = Stack(layers=(layer,), termination="ambient")
    along, across = plane_wave(stack, frequency, 75.0, azimuth=[0.0, 90.0]).transmission
    assert abs(along) == pytest.approx(1, abs=1e-6)
    assert abs(across) == pytest.approx(
        abs(1 / (1 + 1j * np.pi * frequency * mass * np.cos(np.radians(75)) / AIR.impedance)), rel=0.01
    )


def test_corrugations_cost_transmission_loss():
    """Of one mass, a corrugated sheet has its coincidence decades lower and lets more through between."""
    roof = Stack(layers=(CorrugatedPlate(**ROOF, loss_factor=0.01),), termination="ambient")
    same = 6e-4 * sinusoidal(0.076, 0.018).length
    sheet = Stack(layers=(ElasticPlate(thickness=same, **STEEL, loss_factor=0.01),), termination="ambient")
    losses = [diffuse_field(stack, [500.0, 1000.0]).transmission_loss for stack in (roof, sheet)]
    assert np.all(losses[0] < losses[1] - np.array([2, 8]))


@pytest.mark.parametrize(
    ("kind", "fields", "told"),
    [
        (CorrugatedPlate, {**ROOF, "trough_width": 0.01}, "goes with crest_width; leave both out for a sine"),
        (CorrugatedPlate, {**DECK, "crest_width": 0.09}, "210 mm together, must fit into the period, 200 mm"),
        (RibbedPlate, {**RIBS, "rib_width": 0.1}, "must be below rib_spacing, 100 mm"),
    ],
)
def test_what_does_not_fit(kind, fields, told):
    with pytest.raises(InputError, match=told):
        kind(**fields)


@pytest.mark.parametrize(
    ("layer", "frequency", "told"),
    [
        (CorrugatedPlate(**ROOF), 3000.0, r"period / trace wavelength up to 0\.5"),
        (CorrugatedPlate(**DECK), 300.0, r"frequency / resonance of the flats up to 1"),
        (RibbedPlate(**{**RIBS, "thickness": 0.02}), 2500.0, r"rib_spacing / trace wavelength up to 0\.5"),
        (RibbedPlate(**{**RIBS, "thickness": 1e-3}), 500.0, r"frequency / resonance between ribs up to 1"),
    ],
)
def test_outside_the_range(layer, frequency, told):
    with pytest.warns(ValidityWarning, match=told):
        plane_wave(Stack(layers=(layer,), termination="ambient"), frequency, 80.0)


def test_resonance_of_a_flat():
    """A hinged strip of steel, 1 mm thick and 100 mm wide: 245 Hz."""
    wave = np.pi / 0.1  # half a wave across it
    expected = wave**2 * np.sqrt(E * 1e-9 / 12 / (1 - NU**2) / 7.8) / (2 * np.pi)
    assert flat_resonance(E, NU, 1e-3, 7800.0, 0.1) == pytest.approx(expected)
    assert expected == pytest.approx(245, abs=5)
