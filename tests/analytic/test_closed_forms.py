"""Formulae that can be written on one line."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.layers.fluid import fluid_faces
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.response import base_motion, plane_wave
from tests.analytic.materials import AIR, ALUMINIUM, FOAM, FOAM2, GEL, RUBBER, SHEET, WATER, stack

AIR_IMPEDANCE = dry_air().impedance
FREQUENCIES = np.array([[20.0], [500.0], [7e3]])
ANGLES = np.array([0.0, 30.0, 75.0])
COSINES = np.cos(np.radians(ANGLES))
OMEGA = 2 * np.pi * FREQUENCIES


def plane(panel):
    return plane_wave(panel, FREQUENCIES[:, 0], ANGLES)


def test_air_on_a_wall():
    phase = OMEGA / dry_air().sound_speed * COSINES * 0.1
    result = plane(stack((AIR, 0.1), termination="rigid"))
    assert_allclose(result.surface_impedance, -1j * AIR_IMPEDANCE / COSINES / np.tan(phase), rtol=1e-9, atol=1e-9)
    assert_allclose(result.absorption, 0, atol=1e-13)


def test_limp_sheet_obeys_the_mass_law():
    limp = {**SHEET, "young_modulus": 1e-6}
    result = plane(stack((limp, 1e-3)))
    expected = 1 / (1 + 1j * OMEGA * 2.7 * COSINES / (2 * AIR_IMPEDANCE))
    assert_allclose(result.transmission, expected, rtol=1e-12)
    assert_allclose(result.transmission_loss, -20 * np.log10(np.abs(expected)), rtol=1e-12)


def test_sheet_is_transparent_at_coincidence():
    lossless = {**SHEET, "loss_factor": 0.0}
    stiffness = 70e9 * 1e-3**3 / (12 * (1 - 0.33**2))
    critical = dry_air().sound_speed ** 2 / (2 * np.pi) * np.sqrt(2.7 / stiffness)
    result = plane_wave(stack((lossless, 1e-3)), critical / np.sin(np.radians(60)) ** 2, 60.0)
    assert_allclose(np.abs(result.transmission), 1, atol=1e-9)


@pytest.mark.parametrize("thickness", [1e-3, 1.0, 100.0])
def test_fluid_at_its_critical_angle(thickness):
    """Where the wave runs along the layer, k3 = 0, the two waves are one; what remains is the mass."""
    wave = Wave(np.float64(500.0), np.float64(2 * np.pi * 500.0 / 343.0), dry_air())
    faces = fluid_faces(wave, thickness, 1.2, 1.2 * 343.0**2)
    transfer = np.linalg.solve(faces.back.T, faces.front.T).T
    assert_allclose(transfer, [[1, 1j * wave.omega * 1.2 * thickness], [0, 1]], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("termination", ["rigid", "ambient", "free"])
def test_solid_at_normal_incidence_is_a_transmission_line(termination):
    modulus, nu, h, omega = RUBBER["young_modulus"], 0.3, 0.026, OMEGA[:, 0]
    stiffness = modulus * (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    impedance, phase = np.sqrt(242 * stiffness), omega * np.sqrt(242 / stiffness) * h
    t = 1j * np.tan(phase)
    behind = {"free": 0.0, "ambient": AIR_IMPEDANCE}.get(termination)
    expected = impedance / t if behind is None else impedance * (behind + impedance * t) / (impedance + behind * t)
    result = plane_wave(stack((RUBBER, h), termination=termination), FREQUENCIES[:, 0])
    assert_allclose(result.surface_impedance, expected, rtol=1e-9)


@pytest.mark.parametrize(
    ("density", "thickness", "modulus"),
    [(242, 0.026, 806919 + 363114j), (87, 0.025, 121447 + 27933j), (9, 0.025, 54967 + 4947j)],
)
def test_loaded_rod(density, thickness, modulus):
    """Pritz 1982; Bonfiglio & Pompoli 2015, eq. (11), with the materials of their table 1."""
    frequency = np.linspace(100, 1500, 15)
    mass = 7.8  # kg/m2, of a top plate that is thin and stiff enough to move as one
    sample = {"type": "elastic_solid", "density": density, "young_modulus": modulus, "poisson_ratio": 0.0}
    plate = {"type": "elastic_solid", "density": mass / 1e-6, "young_modulus": 1e18, "poisson_ratio": 0.0}
    gl = 2j * np.pi * frequency * np.sqrt(density / modulus) * thickness
    expected = 1 / (np.cosh(gl) + mass / (density * thickness) * gl * np.sinh(gl))
    result = base_motion(stack((sample, thickness), (plate, 1e-6), termination="free"), frequency)
    assert_allclose(result.transmissibility, expected, rtol=1e-9)


@pytest.mark.parametrize("termination", ["rigid", "ambient", "free"])
@pytest.mark.parametrize("fields", [AIR, WATER, ALUMINIUM, RUBBER, GEL, FOAM, FOAM2], ids=lambda f: f["type"])
def test_an_interface_without_contrast_is_invisible(fields, termination):
    whole, parts = stack((fields, 0.05)), stack((fields, 0.02), (fields, 0.03))
    one, two = (plane(panel.model_copy(update={"termination": termination})) for panel in (whole, parts))
    assert_allclose(one.reflection, two.reflection, atol=1e-10)
    if termination == "ambient":
        assert_allclose(one.transmission, two.transmission, rtol=1e-9)


def test_two_sheets_are_one_of_their_mass_at_normal_incidence():
    one, two = stack((SHEET, 2e-3)), stack((SHEET, 1e-3), (SHEET, 1e-3))
    assert_allclose(plane(one).transmission[:, 0], plane(two).transmission[:, 0], rtol=1e-12)


def test_slip_differs_from_bond_but_not_at_normal_incidence():
    layers = (ALUMINIUM, 1e-3), (FOAM2, 0.03)
    bonded, slipping = (plane(stack(*layers, slip=pairs)) for pairs in ((), ((0, 1),)))
    assert_allclose(bonded.transmission[:, 0], slipping.transmission[:, 0], rtol=1e-10)
    assert np.all(np.abs(bonded.transmission / slipping.transmission - 1)[:, 1:] > 1e-6)
