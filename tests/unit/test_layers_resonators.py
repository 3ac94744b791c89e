"""Arrays of Helmholtz resonators: closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.optimize import brentq
from scipy.special import j0, j1, jn_zeros

from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.fluid import Fluid
from multilayer.layers.helmholtz_resonators import HelmholtzResonators
from multilayer.layers.perforated_plate import PerforatedPlate
from multilayer.layers.viscothermal_fluid import ViscothermalFluid
from multilayer.media.gas import dry_air
from multilayer.media.perforations import duct_end_length, end_friction, end_length, surface_resistance
from multilayer.response import plane_wave
from multilayer.stack import Ambient, Stack

AIR = dry_air()
BOTTLES = {"neck_radius": 5e-3, "neck_length": 0.02, "pitch": 0.1, "cavity_depth": 0.1, "cavity_radius": 0.04}
SMALL = {"neck_radius": 5e-4, "neck_length": 1e-3, "pitch": 0.01, "cavity_depth": 0.02}
THIN_AIR = Ambient(viscosity=1e-11)  # no losses


@pytest.mark.parametrize("x", [0.02, 0.1, 0.3, 0.5, 0.7])
def test_end_in_a_duct(x):
    """A piston in the neck's mouth, by the modes of the duct, is an upper bound, 8 / (3 pi) r for a wide duct."""
    zeros = jn_zeros(1, 4000)
    piston = 4 / x * np.sum((j1(zeros * x) / j0(zeros)) ** 2 / zeros**3)
    assert piston - 0.035 < duct_end_length(1.0, 1 / x) < piston


class TestResonance:
    def surface(self, frequency, **fields):
        layer = HelmholtzResonators(**{**BOTTLES, **fields})
        return plane_wave(Stack(layers=(layer,), ambient=THIN_AIR), frequency).surface_impedance

    def resonance(self, **fields):
        return brentq(lambda f: float(self.surface(f, **fields).imag), 20, 800, xtol=1e-9)

    def length(self):
        return 0.02 + end_length(5e-3, np.pi * 5e-3**2 / 0.01) + duct_end_length(5e-3, 0.04)

    def test_small_cavity(self):
        """Helmholtz: c / (2 pi) sqrt(S / (V l))."""
        expected = AIR.sound_speed / (2 * np.pi) * np.sqrt(25 / 1600 / (0.01 * self.length()))
        assert self.resonance(cavity_depth=0.01) == pytest.approx(expected, rel=2e-3)

    def test_deep_cavity(self):
        """Ingard: k l tan(k D) = S / S_c."""
        k = brentq(lambda k: k * self.length() * np.tan(0.5 * k) - 25 / 1600, 1e-3, 3)
        assert self.resonance(cavity_depth=0.5) == pytest.approx(AIR.sound_speed * k / (2 * np.pi), rel=1e-4)

    def test_the_pitch_spreads_the_resonators(self):
        """The impedance is that of a resonator times the area it has, but for the outer end of the neck."""
        near, far = (self.surface(150.0, pitch=d) / d**2 for d in (0.08, 0.8))
        ends = [end_length(5e-3, np.pi * (5e-3 / d) ** 2) for d in (0.08, 0.8)]
        mass = 1j * 2 * np.pi * 150 * AIR.density * (ends[1] - ends[0]) / (np.pi * 5e-3**2)
        assert far - near == pytest.approx(mass, rel=1e-4)


def test_losses_of_the_neck():
    """At low frequencies Poiseuille: 8 viscosity l / r^2 in the neck, over its share of the area."""
    layer = HelmholtzResonators(**{**SMALL, "neck_radius": 1e-4})
    expected = 8 * AIR.viscosity * 1e-3 / 1e-8 / (np.pi * 1e-8 / 1e-4)
    assert layer.transfer_matrix(0.01)[0, 1].real == pytest.approx(expected, rel=0.01)


def test_as_a_perforated_plate_before_a_honeycomb():
    """But for the ends of the neck: Maa takes their mass without neighbours and walls, and a part of their friction."""
    band = np.linspace(200, 3000, 60)
    phi, cell = np.pi * 5e-4**2 / 1e-4, 0.01 / np.sqrt(np.pi)
    plate = PerforatedPlate(model="maa", thickness=1e-3, hole_radius=5e-4, perforation=phi)
    cells = ViscothermalFluid(thickness=0.02, tube_radius=cell)
    ours, theirs = (
        plane_wave(Stack(layers=layers), band).surface_impedance
        for layers in ((HelmholtzResonators(**SMALL),), (plate, cells))
    )
    shorter = 1.7 * 5e-4 - end_length(5e-4, phi) - duct_end_length(5e-4, cell)
    omega = 2 * np.pi * band
    less = surface_resistance(omega, AIR) - end_friction(omega, "tube", AIR)
    assert_allclose(theirs - ours, (1j * omega * AIR.density * shorter + less) / phi, rtol=1e-6)


def test_peak_of_absorption():
    """4 r / (1 + r)^2 where the reactance vanishes."""
    band = np.linspace(300, 1500, 12001)
    result = plane_wave(Stack(layers=(HelmholtzResonators(**SMALL),)), band)
    at = int(np.argmin(np.abs(result.surface_impedance.imag)))
    r = result.surface_impedance[at].real / AIR.impedance
    assert result.absorption[at] == pytest.approx(4 * r / (1 + r) ** 2, rel=1e-5)
    assert result.absorption.max() == pytest.approx(result.absorption[at], rel=0.01)


def test_locally_reacting():
    angles = np.array([0.0, 45.0, 80.0])
    impedance = plane_wave(Stack(layers=(HelmholtzResonators(**SMALL),)), 800.0, angles).surface_impedance
    assert_allclose(impedance, impedance[0], rtol=1e-12)


def test_something_else_behind():
    open_ended = Stack(layers=(HelmholtzResonators(**SMALL), Fluid(thickness=0.01)), termination="ambient")
    result = plane_wave(open_ended, 500.0)
    assert 0 < abs(result.transmission) < 1


@pytest.mark.parametrize(
    ("fields", "told"),
    [
        ({"cavity_radius": 0.1}, "cavities of 100 mm do not fit a pitch of 100 mm: at most 56.42 mm"),
        ({"neck_radius": 0.05}, "it must be below the cavity's, 40 mm"),
        ({"neck_radius": 0.06, "cavity_radius": None}, "it must be below the cavity's, 56.42 mm"),
    ],
)
def test_what_does_not_fit(fields, told):
    with pytest.raises(InputError, match=told):
        HelmholtzResonators(**{**BOTTLES, **fields})


@pytest.mark.parametrize(
    ("fields", "frequency", "told"),
    [
        ({"neck_length": 0.01}, 2000.0, r"pitch / wavelength up to 0\.5"),
        ({"neck_length": 0.1}, 500.0, r"neck_length / wavelength up to 0\.1"),
        ({"neck_radius": 0.038}, 100.0, r"neck_radius / cavity_radius up to 0\.9"),
    ],
)
def test_outside_the_range(fields, frequency, told):
    with pytest.warns(ValidityWarning, match=told):
        plane_wave(Stack(layers=(HelmholtzResonators(**{**BOTTLES, **fields}),)), frequency)
