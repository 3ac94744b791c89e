"""Air pumped through a frame that gives way, against its limits and finite elements."""

import numpy as np
import pytest

from multilayer.media.gas import dry_air
from multilayer.media.pumped_air import cylindrical_length
from multilayer.media.pumped_frame import pumped_frame_stiffness
from multilayer.media.rod import chain_transmissibility
from multilayer.rig import TwoPlateRig

F = np.array([50.0, 100.0, 200.0])
OMEGA = 2 * np.pi * F
SIZES = {"radius": 0.0225, "thickness": 0.025, "density": 60.0}


def test_a_stiff_frame_leaves_radial_diffusion():
    from scipy.special import jv

    stiff = np.full(F.shape, 1e12 + 0j)
    k2 = -1j * OMEGA * 6e4 / 101325
    x = np.sqrt(k2) * SIZES["radius"]
    expected = 101325 * (1 - 2 * jv(1, x) / (x * jv(0, x)))
    np.testing.assert_allclose(pumped_frame_stiffness(OMEGA, stiff, 6e4, **SIZES), expected, rtol=1e-5)


def test_air_that_cannot_leave_is_held_by_the_frame_alone():
    # thin: glued so near to its faces that the frame cannot move sideways either
    thin = {**SIZES, "thickness": 1e-5}
    found = pumped_frame_stiffness(OMEGA, np.full(F.shape, 1e5 + 0j), 1e15, **thin)
    np.testing.assert_allclose(found, 101325, rtol=1e-3)


def test_air_that_leaves_freely_adds_nothing():
    found = pumped_frame_stiffness(OMEGA, np.full(F.shape, 1e5 + 1e4j), 1e-3, **SIZES)
    assert np.max(np.abs(found)) < 0.1


@pytest.mark.parametrize(("modulus", "resistivity"), [(1e5, 6e4), (3e4, 6e4), (1e5, 3e5)])
def test_it_is_the_effect_that_finite_elements_show(modulus, resistivity):
    e = np.full(F.shape, modulus * (1 + 0.2j))
    length = cylindrical_length(0.98, resistivity, 1.0, dry_air())
    rig = TwoPlateRig(
        poisson_ratio=0.0, plate_thickness=3e-3, plate_modulus=2.1e13, plate_poisson_ratio=0.0, porosity=0.98,
        flow_resistivity=resistivity, tortuosity=1.0, viscous_length=length, thermal_length=2 * length,
        air=dry_air(), pore_rim="open", **SIZES,
    )  # fmt: skip
    plate = (np.full(F.shape, 2.1e13), 7850.0, 3e-3)
    air = pumped_frame_stiffness(OMEGA, e, resistivity, pore_modulus=101325 / 0.98, **SIZES)
    without, with_air = (chain_transmissibility(F, [(m, 60.0, 0.025), plate]) for m in (e, e + air))
    true = rig.transmissibility(F, e)
    effect = np.abs(true - without)
    assert np.all(effect / np.abs(true) > 0.01)
    assert np.max(np.abs(true - with_air) / effect) < 0.12


def test_it_is_computed_for_many_samples_at_once():
    e = np.array([[1e5 + 1e4j], [3e5 + 3e4j]]) * np.ones(F.shape)
    both = pumped_frame_stiffness(OMEGA, e, np.array([[1e4], [5e4]]), **SIZES)
    for row, sigma, one in zip(e, (1e4, 5e4), both, strict=True):
        np.testing.assert_allclose(pumped_frame_stiffness(OMEGA, row, sigma, **SIZES), one, rtol=1e-12)
