"""Holes and slits through a wall: published formulae, integrals, limits."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import hankel2

from multilayer.media.gas import dry_air
from multilayer.media.openings import disc_impedance, hole_passage, line_radiation, slit_passage, strip_impedance
from multilayer.response.finite_size import Window, radiation_impedance

AIR = dry_air()
THIN = replace(AIR, viscosity=1e-14)  # neither friction nor, at this Prandtl number, heat conduction
FREQUENCY = np.array([50.0, 100, 200, 400, 630])
ENDLESS = 1e5


def gomperts_kihlman(width, depth, m, n=1.0):
    """Return tau of an endless slit; n is 1 within a wall and 1/2 at its edge, m 8 in a diffuse field, 4 of a wave."""
    k = 2 * np.pi * FREQUENCY / AIR.sound_speed * width
    end, x = (np.log(8 / k) - np.euler_gamma) / np.pi, depth / width
    resonance = np.sin(k * (x + 2 * end)) ** 2 / np.cos(k * end) ** 2
    damping = k**2 / (2 * n**2) * (1 + np.cos(k * (x + 2 * end)) * np.cos(k * x))
    return m * k * np.cos(k * end) ** 2 / (2 * n**2 * (resonance + damping))


class TestRadiation:
    @pytest.mark.parametrize("x", [0.01, 0.3, 3.0, 20.0])
    def test_strip_is_the_mean_of_its_lines(self, x):
        nodes, weights = np.polynomial.legendre.leggauss(400)
        t = (nodes + 1) / 2
        u = x * t**4  # the logarithm at 0 is flat there
        mean = np.sum(weights / 2 * 4 * t**3 * (x - u) * hankel2(0, u))
        assert strip_impedance(x) == pytest.approx(mean, rel=1e-10)

    def test_series_of_a_narrow_strip_meets_the_closed_form(self):
        assert_allclose(strip_impedance(1e-3 * (1 - 1e-9)), strip_impedance(1e-3), rtol=1e-6)

    def test_disc(self):
        assert disc_impedance(1e-3) == pytest.approx(5e-7 + 8e-3j / (3 * np.pi), rel=1e-4)
        assert disc_impedance(300.0) == pytest.approx(1, abs=3e-3)

    @pytest.mark.parametrize("length", [0.05, 0.5, 5.0])
    def test_short_slit_radiates_as_a_rectangle(self, length):
        """The package's rectangular pistons, at k width = 0.009."""
        k, width = 9.0, 1e-3
        rectangle = radiation_impedance(Window(width, length), k, 0.0).real
        assert rectangle == pytest.approx(k * width / 2 * line_radiation(k * length), rel=2e-3)


class TestSlit:
    @pytest.mark.parametrize(("width", "depth"), [(2e-3, 0.04), (1e-2, 0.1), (1e-3, 0.1)])
    @pytest.mark.parametrize(("angle", "m", "up_to"), [(None, 8, 0.2), (0.0, 4, 0.67)])
    def test_without_losses_is_that_of_gomperts_and_kihlman(self, width, depth, angle, m, up_to):
        """Within 0.3 dB below the first resonance; waves along the slit, which they leave out, move that upwards."""
        found = slit_passage(FREQUENCY, width, ENDLESS, depth, THIN, angle).transmission
        below = up_to * AIR.sound_speed / 2 / (depth + 2 * width) > FREQUENCY
        assert below.sum() >= 3
        assert np.abs(10 * np.log10(found / gomperts_kihlman(width, depth, m)))[below].max() < 0.3

    def test_at_an_edge(self):
        """Four times as much reaches the other side, but for the mass of the air outside, which mirrors enlarge."""
        deep = {"width": 2e-3, "length": ENDLESS, "depth": 0.1, "gas": THIN}
        gain = slit_passage(FREQUENCY, at_edge=True, **deep).transmission / slit_passage(FREQUENCY, **deep).transmission
        assert np.all((gain > 3.3) & (gain < 4))

    @pytest.mark.parametrize("at_edge", [False, True])
    @pytest.mark.parametrize(
        ("width", "length", "depth"), [(1e-2, 0.1, 1e-3), (3e-3, 0.06, 5e-3), (2e-3, 0.1, 1e-2), (0.05, 0.1, 0.02)]
    )
    def test_short_one_is_a_rectangular_piston(self, width, length, depth, at_edge):
        """Its mass and resistance by a double integral over the window, the field by reciprocity: k length < 0.4."""
        k = 2 * np.pi * FREQUENCY[:3] / AIR.sound_speed
        k = k[k * length < 0.4]
        z = radiation_impedance(Window(width * (2 if at_edge else 1), length), k, 0.0)
        met = 4 * np.pi * z.real / (k**2 * width * length)
        blocked = 2 * z * np.cos(k * depth) + 1j * np.sin(k * depth) * (1 + z**2)
        found = slit_passage(FREQUENCY[: len(k)], width, length, depth, THIN, at_edge=at_edge).transmission
        assert np.abs(10 * np.log10(found * np.abs(blocked) ** 2 / (4 * met * z.real))).max() < 0.1

    def test_friction_of_a_narrow_slit(self):
        """Far below resonance the flow between plates, 12 mu d/w^2: tau = 8 rho c (rho w width/2)/R^2, and mass."""
        width, depth, f = 1e-4, 0.05, np.array([20.0])
        omega = 2 * np.pi * f
        resistance = 12 * AIR.viscosity * depth / width**2
        radiated = AIR.density * omega * width / 2
        expected = 8 * AIR.impedance * radiated / (resistance**2 + (1.2 * omega * AIR.density * depth) ** 2)
        assert_allclose(slit_passage(f, width, ENDLESS, depth, AIR).transmission, expected, rtol=0.02)

    def test_wide_one_is_an_open_window(self):
        found = slit_passage(np.array([2e5, 4e5]), 0.05, ENDLESS, 0.05, THIN)
        assert_allclose(found.transmission, 1, atol=0.03)

    @pytest.mark.parametrize("angle", [None, 0.0, 60.0])
    def test_what_is_not_lost_passes(self, angle):
        without, losing = (slit_passage(FREQUENCY, 1e-3, 1.0, 0.1, gas, angle) for gas in (THIN, AIR))
        assert_allclose(without.absorption, without.transmission, rtol=1e-2)
        assert np.all(losing.absorption > 1.1 * losing.transmission)


class TestHole:
    @pytest.mark.parametrize(("angle", "m"), [(None, 8), (0.0, 4)])
    def test_small_hole(self, angle, m):
        """Mass of the hole and its ends, 16 a/(3 pi), and k^2 a^2/2 at either end."""
        a, depth, f = 5e-3, 0.1, np.array([50.0, 100.0])
        k = 2 * np.pi * f / AIR.sound_speed
        expected = m * (k * a) ** 2 / 2 / (k * (depth + 16 * a / (3 * np.pi))) ** 2
        assert_allclose(hole_passage(f, a, depth, THIN, angle).transmission, expected, rtol=0.02)

    def test_large_hole_is_an_open_window(self):
        assert_allclose(hole_passage(np.array([1e5]), 0.05, 0.1, THIN).transmission, 1, atol=0.05)

    def test_resonance_takes_in_what_a_diffuse_field_offers(self):
        """The most that a small lossless hole passes: of waves from all directions, 2 pi / k^2."""
        a, f = 5e-3, np.linspace(1000, 1700, 4001)
        passed = hole_passage(f, a, 0.1, THIN).transmission
        k = 2 * np.pi * f[np.argmax(passed)] / AIR.sound_speed
        assert passed.max() * np.pi * a**2 == pytest.approx(4 * np.pi / k**2, rel=5e-3)

    def test_plane_waves_average_to_the_diffuse_field(self):
        f = np.array([100.0, 1000.0, 5000.0])
        nodes, weights = np.polynomial.legendre.leggauss(40)
        cosine = (nodes + 1) / 2
        waves = [hole_passage(f, 0.02, 0.1, AIR, float(angle)).transmission for angle in np.rad2deg(np.arccos(cosine))]
        mean = 2 * np.einsum("a,af,a->f", weights / 2, waves, cosine)
        assert_allclose(hole_passage(f, 0.02, 0.1, AIR).transmission, mean, rtol=1e-6)


def test_plane_waves_average_to_a_diffuse_field_across_an_endless_slit():
    """Across a slit whose depth is nothing to waves along it: mean over the half-plane, of what meets it."""
    f, width = np.array([4000.0]), 0.03
    nodes, weights = np.polynomial.legendre.leggauss(200)
    sine = np.sin(np.pi / 2 * nodes)
    waves = [
        slit_passage(f, width, ENDLESS, 0.02, THIN, float(np.rad2deg(np.arcsin(abs(s))))).transmission for s in sine
    ]
    across = np.einsum("a,af,a->f", weights, waves, np.sqrt(1 - sine**2)) / (weights @ np.sqrt(1 - sine**2))
    k = 2 * np.pi * f / AIR.sound_speed
    at_right_angles = slit_passage(f, width, ENDLESS, 0.02, THIN, 0.0).transmission
    by_reciprocity = at_right_angles * strip_impedance(k * width).real / (k * width / 2) * np.pi / 2
    assert_allclose(across, by_reciprocity, rtol=1e-6)
