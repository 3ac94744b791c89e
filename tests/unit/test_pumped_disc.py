"""A mass on a porous disc whose air is pumped, against rods, limits and finite elements."""

import numpy as np
import pytest

from multilayer.media import pumped_disc
from multilayer.media.gas import dry_air
from multilayer.media.pumped_air import cylindrical_length
from multilayer.media.pumped_disc import dynamic_resistivity, pumped_disc_factor
from multilayer.media.rod import rod_transmissibility
from multilayer.rig import TwoPlateRig

F = np.array([100.0, 200.0, 300.0, 450.0, 600.0, 800.0, 1000.0, 1300.0])
OMEGA = 2 * np.pi * F
MODULUS = 2.5e5 * (1 + 0.25j) * F**0.2 / 500**0.2
MASS = 7850 * 3e-3


def disc(resistivity, thickness=0.025, radius=0.0225):
    return pumped_disc_factor(
        OMEGA, MODULUS, resistivity, radius=radius, thickness=thickness, density=100.0, mass_per_area=MASS
    )


def test_without_air_it_is_a_rod_under_a_mass():
    modes = pumped_disc._motion(OMEGA, MODULUS, 100.0, 0.025, MASS)
    np.testing.assert_allclose(modes, rod_transmissibility(F, MODULUS, 100.0, 0.025, MASS), rtol=3e-3)


def test_air_held_by_nothing_at_a_narrow_rim_changes_the_motion_by_its_mass_at_most():
    assert np.max(np.abs(disc(1.0, radius=1e-4) - 1)) < 0.02


def test_slow_flow_is_viscous_and_fast_flow_is_inertial():
    np.testing.assert_allclose(dynamic_resistivity(np.array([1e-3]), 1e4, 1.2), 1e4, rtol=1e-6)
    fast = np.array([1e12])
    np.testing.assert_allclose(dynamic_resistivity(fast, 1e4, 1.2), 1j * 1.2 * fast, rtol=1e-3)


def test_it_broadcasts_over_samples():
    both = disc(np.array([[1e4], [5e4]]))
    for sigma, one in zip((1e4, 5e4), both, strict=True):
        np.testing.assert_allclose(disc(sigma), one, rtol=1e-12)


@pytest.mark.parametrize(("thickness", "radius"), [(0.0125, 0.0225), (0.025, 0.0225), (0.025, 0.012)])
@pytest.mark.parametrize("resistivity", [1e4, 6e4])
def test_it_is_the_effect_that_finite_elements_show_beyond_resonance_too(resistivity, thickness, radius):
    length = cylindrical_length(0.97, resistivity, 1.0, dry_air())
    rig = TwoPlateRig(
        radius=radius, thickness=thickness, density=100.0, poisson_ratio=0.0, plate_thickness=3e-3,
        plate_density=7850.0, plate_modulus=2.1e14, plate_poisson_ratio=0.0, porosity=0.97,
        flow_resistivity=resistivity, tortuosity=1.0, viscous_length=length, thermal_length=2 * length,
        air=dry_air(), pore_rim="open",
    )  # fmt: skip
    rod = rod_transmissibility(F, MODULUS, 100.0, thickness, MASS)
    true = rig.transmissibility(F, MODULUS) / rod
    effect = np.abs(true - 1)
    error = np.abs(disc(resistivity, thickness, radius) - true)
    assert effect.max() > 0.01
    so_far = np.maximum.accumulate(effect)  # it changes its sign at resonances
    assert np.all(error < 0.1 * so_far + 2e-4)
