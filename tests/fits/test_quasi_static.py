"""The quasi-static method: closed loop with the finite elements of a glued disc."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.errors import InputError
from multilayer.experiments.two_plate.transmissibility import Transmissibility
from multilayer.fits.classical.quasi_static import Compression, burst_stiffness, two_shapes, young_modulus
from multilayer.media.rod import rod_transmissibility
from multilayer.rig.shape_factor import static_shape_factor

MODULUS = 2e5 * (1 + 0.2j)
TALL, FLAT = (0.0225, 0.04), (0.0225, 0.0125)


def stiffness(radius: float, thickness: float, nu: float) -> complex:
    """Return the stiffness of a glued disc, N/m."""
    return MODULUS * np.pi * radius**2 / thickness * static_shape_factor(nu, radius / (2 * thickness))


def discs(nu: float, shapes=(TALL, FLAT), **stds: float) -> tuple[Compression, Compression]:
    one, other = (Compression(stiffness(*shape, nu), *shape, **stds) for shape in shapes)
    return one, other


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.45])
def test_one_disc_gives_the_modulus(nu):
    assert young_modulus(stiffness(*FLAT, nu), *FLAT, nu) == pytest.approx(MODULUS, rel=1e-12)


@pytest.mark.parametrize("nu", [0.0, 0.12, 0.3, 0.45, 0.49])
def test_two_shapes_give_modulus_and_poisson_ratio(nu):
    found = two_shapes(*discs(nu))
    assert found.poisson_ratio == pytest.approx(nu, abs=1e-5)
    assert found.young_modulus == pytest.approx(MODULUS, rel=1e-5)
    assert (found.told, found.remarks) == (True, [])
    assert (found.poisson_ratio_std, found.storage_modulus_std) == (0.0, 0.0)


def test_order_of_the_discs_does_not_matter():
    one, other = discs(0.3, stiffness_std=0.01)
    assert two_shapes(one, other) == two_shapes(other, one)


@pytest.mark.slow
def test_standard_deviations_are_those_of_solving_again():
    """Every measured quantity of both discs off by one standard deviation, one after the other."""
    nu, stds = 0.35, {"stiffness": 0.01, "radius": 0.002, "thickness": 0.004}
    tall, flat = discs(nu, **{f"{name}_std": std for name, std in stds.items()})
    said = two_shapes(tall, flat)
    shifts = []
    for name, std in stds.items():
        for pair in ((_off(tall, name, std), flat), (tall, _off(flat, name, std))):
            found = two_shapes(*pair)
            shifts.append((found.poisson_ratio - nu, found.young_modulus.real / MODULUS.real - 1))
    spread = np.linalg.norm(shifts, axis=0)
    assert said.poisson_ratio_std == pytest.approx(spread[0], rel=0.1)
    assert said.storage_modulus_std / MODULUS.real == pytest.approx(spread[1], rel=0.1)


def _off(disc: Compression, name: str, by: float) -> Compression:
    return replace(disc, **{name: getattr(disc, name) * (1 + by)})


def test_near_zero_the_ratio_says_little():
    found = two_shapes(*discs(0.0, stiffness_std=0.01))
    assert found.poisson_ratio == 0.0
    assert found.poisson_ratio_std > 0.1
    assert not found.told
    assert "too alike to tell Poisson's ratio" in found.remarks[0]


def test_shapes_too_alike_are_told():
    alike = two_shapes(*discs(0.3, ((0.0225, 0.025), (0.0225, 0.022)), stiffness_std=0.02))
    apart = two_shapes(*discs(0.3, stiffness_std=0.02))
    assert not alike.told
    assert "S = 0.45 and 0.511 are too alike" in alike.remarks[-1]
    assert apart.told
    assert apart.poisson_ratio_std < alike.poisson_ratio_std


def test_same_shape_is_refused():
    one, other = discs(0.3, ((0.0225, 0.025), (0.045, 0.05)))
    with pytest.raises(InputError, match=r"both discs have the shape S = 0.45.*take discs of different radius"):
        two_shapes(one, other)


def test_beyond_the_edge():
    tall, flat = discs(0.0, stiffness_std=0.01)
    lower = Compression(flat.stiffness * 0.98, *FLAT, stiffness_std=0.01)
    found = two_shapes(tall, lower)
    assert found.poisson_ratio == 0.0
    assert "beyond 0 " in found.remarks[0]
    with pytest.raises(InputError, match="check which disc is which, the gluing"):
        two_shapes(tall, Compression(flat.stiffness * 0.8, *FLAT, stiffness_std=0.01))
    with pytest.raises(InputError, match=r"Poisson's ratios from 0 to 0\.5 allow 1 to"):
        two_shapes(tall, Compression(flat.stiffness * 8, *FLAT, stiffness_std=0.01))


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"stiffness": -1.0}, "stiffness: -1 is not allowed; it must be above 0"),
        ({"radius": 0.0}, "radius: 0 is not allowed; it must be above 0"),
        ({"thickness": float("nan")}, "thickness: nan is not allowed; it must be above 0"),
        ({"stiffness_std": 1.5}, "stiffness_std: 1.5 is not allowed; it is relative, from 0 to below 1"),
    ],
)
def test_bad_input(change, text):
    with pytest.raises(InputError, match=text):
        Compression(**{"stiffness": 1e4, "radius": 0.02, "thickness": 0.02, **change})


def test_poisson_ratio_out_of_range():
    with pytest.raises(InputError, match=r"poisson_ratio: 0\.5 is not allowed"):
        young_modulus(1e4, *FLAT, 0.5)


class TestBurst:
    DENSITY, LENGTH, LOAD = 90.0, 0.025, 7.85

    def burst(self, share: float, **stds: float) -> tuple[complex, Transmissibility]:
        """Return the true stiffness per area, and the transmissibility at a share of the resonance."""
        per_area = MODULUS / self.LENGTH
        resonance = np.sqrt(abs(per_area) / (self.LOAD + self.DENSITY * self.LENGTH / 2)) / (2 * np.pi)
        f = share * resonance
        motion = complex(rod_transmissibility(f, MODULUS, self.DENSITY, self.LENGTH, self.LOAD))
        return per_area, Transmissibility(f, motion, **stds)

    @pytest.mark.parametrize("share", [0.02, 0.05, 0.099])
    def test_far_below_the_resonance_it_is_the_stiffness(self, share):
        true, measured = self.burst(share)
        found = burst_stiffness(measured, self.LOAD, self.DENSITY * self.LENGTH)
        assert found.quasi_static
        assert found.stiffness == pytest.approx(true, rel=2e-3)
        assert found.frequency == pytest.approx(share * found.resonance, rel=2e-3)

    def test_near_the_resonance_it_is_not(self):
        _, measured = self.burst(0.11)
        assert not burst_stiffness(measured, self.LOAD, self.DENSITY * self.LENGTH).quasi_static

    def test_a_gain_error_counts_a_hundredfold(self):
        _, measured = self.burst(0.1, gain=0.003)
        found = burst_stiffness(measured, self.LOAD, self.DENSITY * self.LENGTH)
        assert found.relative_std == pytest.approx(0.3, rel=0.1)
        wrong = Transmissibility(measured.frequency, measured.value * (1 + 1e-6))
        moved = burst_stiffness(wrong, self.LOAD, self.DENSITY * self.LENGTH).stiffness - found.stiffness
        assert abs(moved.real / found.stiffness.real) / 1e-6 * 0.003 == pytest.approx(found.relative_std, rel=1e-3)
