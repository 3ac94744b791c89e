"""Bonded solids in bending: Oberst's free damping layer, the constrained one of Ross, Kerwin & Ungar."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.response import plane_wave
from multilayer.stack import Ambient, Stack

SLOW = Ambient(sound_speed=34.0)  # short waves at low frequencies: bending alone
FREQUENCY = np.array([30.0, 60.0])
ANGLE = 80.0
OMEGA = 2 * np.pi * FREQUENCY
K = OMEGA / 34.0 * np.sin(np.radians(ANGLE))
ALUMINIUM = {"density": 2700.0, "young_modulus": 7e10, "poisson_ratio": 0.33}
PLANE = 7e10 / (1 - 0.33**2)


def stiffness(*layers):
    """Return the bending stiffness, N m, that the layers have for waves of wavenumber K, from what they reflect."""
    result = plane_wave(Stack(layers=layers, termination="ambient", ambient=SLOW), FREQUENCY, ANGLE)
    r, t, wave = result.reflection, result.transmission, SLOW.gas.impedance / np.cos(np.radians(ANGLE))
    impedance = 2 * wave * (1 + r - t) / (1 - r + t)
    mass = sum(layer.density * layer.thickness for layer in layers)
    return (impedance - 1j * OMEGA * mass) * 1j * OMEGA / K**4


def core(shear_modulus, thickness, loss=0.8):
    """Return a rubber, nearly incompressible, of a complex shear modulus."""
    young = 2 * 1.49 * shear_modulus * (1 + 1j * loss)
    return ElasticSolid(thickness=thickness, density=1000.0, young_modulus=young, poisson_ratio=0.49)


def face(thickness):
    return ElasticSolid(thickness=thickness, **ALUMINIUM)


def test_one_plate():
    assert_allclose(stiffness(face(2e-3)), PLANE * 8e-9 / 12, rtol=2e-4)
    assert_allclose(stiffness(ElasticPlate(thickness=2e-3, **ALUMINIUM)), PLANE * 8e-9 / 12, rtol=1e-6)


def test_one_plate_of_several_layers():
    assert_allclose(stiffness(face(0.5e-3), face(0.7e-3), face(0.8e-3)), stiffness(face(2e-3)), rtol=1e-6)


@pytest.mark.parametrize("thickness", [0.5e-3, 2e-3, 5e-3])
def test_free_layer(thickness):
    """H. Oberst, Acustica 2 (1952) Beiheft 4, 181-194: two plates about their common neutral axis."""
    young = 2e9 * (1 + 0.4j)
    damping = ElasticSolid(thickness=thickness, density=1500.0, young_modulus=young, poisson_ratio=0.33)
    h = np.array([1e-3, thickness])
    e = np.array([PLANE, young / (1 - 0.33**2)])
    z = np.array([0.5e-3, 1e-3 + thickness / 2])
    axis = np.sum(e * h * z) / np.sum(e * h)
    expected = np.sum(e * (h**3 / 12 + h * (z - axis) ** 2))
    ours = stiffness(face(1e-3), damping)
    assert_allclose(ours, expected, rtol=4e-3)  # he leaves out shear, which is 0.35 % of 5 mm at 60 Hz
    assert_allclose(ours.imag / ours.real, expected.imag / expected.real, rtol=2e-3)


def rku(h1, h2, h3, shear):
    """Return the stiffness of two faces and a core of a complex shear modulus, at the wavenumbers K.

    D. Ross, E. E. Ungar & E. M. Kerwin, in J. E. Ruzicka (ed.), Structural Damping, ASME 1959, 49-88; E. M. Kerwin, J.
    Acoust. Soc. Am. 31 (1959) 952-962, without the core's own extension: ``D1 + D3 + d^2 S g / (1 + g)``, S that of
    both faces in series, ``g = G / (S h2 k^2)``, d the distance of their middles.
    """
    series = PLANE * h1 * h3 / (h1 + h3)
    g = shear / (series * h2 * K**2)
    return PLANE * (h1**3 + h3**3) / 12 + (h2 + (h1 + h3) / 2) ** 2 * series * g / (1 + g)


@pytest.mark.parametrize("shear", [1e4, 1e5, 1e6, 1e7])
@pytest.mark.parametrize(("h1", "h2", "h3"), [(1e-3, 1e-4, 1e-3), (2e-3, 5e-5, 3e-4), (1e-3, 2e-3, 1e-3)])
def test_constrained_layer(h1, h2, h3, shear):
    """From a core that slips (g far below 1) to one that holds."""
    ours, expected = stiffness(face(h1), core(shear, h2), face(h3)), rku(h1, h2, h3, shear * (1 + 0.8j))
    assert_allclose(ours, expected, rtol=0.01)
    # beside the shear in the core, its extension loses 2e-5 at most
    assert_allclose(ours.imag / ours.real, expected.imag / expected.real, rtol=0.01, atol=2e-5)


def test_most_damping_in_between():
    """Ungar: the loss factor has one maximum, where g is about 1 / sqrt((1 + Y) (1 + loss^2))."""
    shears = np.geomspace(1e3, 1e8, 200)
    h1, h2, h3 = 1e-3, 1e-4, 1e-3
    series, distance = PLANE * 5e-4, 1.1e-3
    loss = []
    for shear in shears:
        d = stiffness(face(h1), core(shear, h2), face(h3))[1]
        loss.append(d.imag / d.real)
    geometry = distance**2 * series / (PLANE * 2e-9 / 12)
    g = shears[np.argmax(loss)] / (series * h2 * K[1] ** 2)
    assert g == pytest.approx(1 / np.sqrt((1 + geometry) * (1 + 0.8**2)), rel=0.1)
