"""Air in tubes, in slits and in thin gaps."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import ValidityWarning
from multilayer.layers.fluid import Fluid
from multilayer.layers.viscothermal_fluid import ViscothermalFluid
from multilayer.media.gas import dry_air
from multilayer.media.narrow import narrow_gas
from multilayer.response import plane_wave
from multilayer.stack import Stack

AIR = dry_air()
FREQUENCIES = np.array([100.0, 1000.0, 3000.0])
OMEGA = 2 * np.pi * FREQUENCIES
ANGLES = np.array([0.0, 40.0, 80.0])


def surface(layer, angle=0.0):
    return plane_wave(Stack(layers=(layer,)), FREQUENCIES, angle).surface_impedance


class TestTubesAndSlits:
    @pytest.mark.parametrize(
        ("field", "shape", "half"), [("tube_radius", "tube", 3e-4), ("slit_width", "slit", 1.5e-4)]
    )
    def test_a_bundle_on_a_wall(self, field, shape, half):
        density, bulk = narrow_gas(OMEGA, shape, half, AIR)
        k = OMEGA * np.sqrt(density / bulk)
        expected = -1j * np.sqrt(density * bulk) / np.tan(k * 0.05) / 0.8
        layer = ViscothermalFluid(thickness=0.05, **{field: 3e-4}, open_area=0.8)
        assert_allclose(surface(layer), expected, rtol=1e-11)

    @pytest.mark.parametrize("field", ["tube_radius", "slit_width"])
    def test_local_reaction(self, field):
        layer = ViscothermalFluid(thickness=0.05, **{field: 5e-4})
        assert_allclose(surface(layer, ANGLES), surface(layer)[:, None] * np.ones(3), rtol=1e-11)

    def test_two_lengths_make_one(self):
        whole, front, back = (ViscothermalFluid(thickness=h, tube_radius=2e-4) for h in (0.05, 0.02, 0.03))
        matrices = [layer.transfer_matrix(FREQUENCIES, 30.0) for layer in (front, back, whole)]
        assert_allclose(matrices[0] @ matrices[1], matrices[2], rtol=1e-10)

    def test_wide_tubes_are_a_locally_reacting_fluid(self):
        layer = ViscothermalFluid(thickness=0.05, tube_radius=0.025)
        assert_allclose(surface(layer), surface(Fluid(thickness=0.05)), rtol=0.02)


class TestGap:
    def test_wide_gap_is_a_fluid(self):
        layers = ViscothermalFluid(thickness=0.03), Fluid(thickness=0.03)
        ours, free = (surface(layer, ANGLES[:2]) for layer in layers)
        assert_allclose(ours, free, rtol=0.02)

    def test_film_is_isothermal_at_low_frequencies(self):
        """A film in front of a wall is a spring P0 / h."""
        impedance = plane_wave(Stack(layers=(ViscothermalFluid(thickness=1e-4),)), 10.0).surface_impedance
        assert impedance * 2j * np.pi * 10.0 == pytest.approx(AIR.pressure / 1e-4, rel=0.003)

    def test_pumping_along_the_walls(self):
        """The film admits i w h / K - i kx^2 h / (w density), with the density of the flow in the slit."""
        thickness = 1e-4
        density, bulk = narrow_gas(OMEGA, "slit", thickness / 2, AIR)
        kx = OMEGA / AIR.sound_speed * np.sin(np.radians(80.0))
        admittance = 1j * thickness * (OMEGA / bulk - kx**2 / (OMEGA * density))
        assert_allclose(1 / surface(ViscothermalFluid(thickness=thickness), 80.0), admittance, rtol=1e-4)
        assert np.all(admittance.real > 0)


class TestFields:
    def test_one_geometry(self):
        with pytest.raises(ValueError, match="tube_radius and slit_width exclude each other"):
            ViscothermalFluid(thickness=0.05, tube_radius=1e-3, slit_width=1e-3)

    def test_open_area_needs_walls_across(self):
        with pytest.raises(ValueError, match="open_area goes with tube_radius or slit_width"):
            ViscothermalFluid(thickness=0.05, open_area=0.5)

    def test_range(self):
        with pytest.warns(ValidityWarning, match=r"half widths \(m\) from 1e-05; here it is 5e-06"):
            surface(ViscothermalFluid(thickness=0.05, tube_radius=5e-6))
        with (
            pytest.warns(ValidityWarning, match=r"up to 10000; here it is 1\.643e\+04 \(3000 Hz\)"),
            pytest.warns(ValidityWarning, match=r"width of a tube / wavelength up to 0\.5; .* \(1000 to 3000 Hz\)"),
        ):
            surface(ViscothermalFluid(thickness=0.05, tube_radius=0.1))
