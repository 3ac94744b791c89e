"""Screens, membranes, orthotropic and perforated plates: closed forms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.fluid import Fluid
from multilayer.layers.membrane import Membrane
from multilayer.layers.orthotropic_plate import OrthotropicPlate
from multilayer.layers.perforated_plate import PerforatedPlate
from multilayer.layers.screen import Screen
from multilayer.matrix.wave import Wave
from multilayer.media.gas import dry_air
from multilayer.media.perforations import end_length, hole_pitch, maa_impedance
from multilayer.response import plane_wave
from multilayer.stack import Stack
from multilayer.testing import check_layer

AIR = dry_air()
Z0 = AIR.impedance
FREQUENCIES = np.array([50.0, 500.0, 3000.0])
OMEGA = 2 * np.pi * FREQUENCIES


def jump(layer, frequency=FREQUENCIES, angle=0.0):
    """Return the pressure difference over the velocity, from the transmission into air."""
    result = plane_wave(Stack(layers=(layer,), termination="ambient"), frequency, angle)
    return 2 * Z0 / np.cos(np.radians(angle)) * (1 / result.transmission - 1)


class TestScreen:
    def test_resistance(self):
        assert_allclose(jump(Screen(flow_resistance=500.0)), 500.0, rtol=1e-12)

    def test_resistivity_and_thickness(self):
        assert_allclose(jump(Screen(flow_resistivity=1e6, thickness=0.5e-3)), 500.0, rtol=1e-12)

    def test_free_to_move(self):
        parallel = 1 / (1 / 500 + 1 / (1j * OMEGA * 0.2))
        assert_allclose(jump(Screen(flow_resistance=500.0, surface_density=0.2)), parallel, rtol=1e-11)

    def test_absorption_of_a_matched_screen_a_quarter_wave_before_a_wall(self):
        gap = Fluid(thickness=0.1)
        frequency = AIR.sound_speed / 0.4
        result = plane_wave(Stack(layers=(Screen(flow_resistance=Z0), gap)), frequency)
        assert result.absorption == pytest.approx(1, abs=1e-12)

    @pytest.mark.parametrize(
        "fields",
        [
            {},
            {"thickness": 1e-3},
            {"flow_resistivity": 1e6},
            {"flow_resistance": 100.0, "thickness": 1e-3},
            {"flow_resistance": 100.0, "flow_resistivity": 1e6, "thickness": 1e-3},
        ],
    )
    def test_one_way_to_say_it(self, fields):
        with pytest.raises(ValueError, match="a screen takes flow_resistance, or flow_resistivity and thickness"):
            Screen(**fields)


class TestMembrane:
    def test_septum_follows_the_mass_law(self):
        result = plane_wave(Stack(layers=(Membrane(surface_density=5.0),), termination="ambient"), FREQUENCIES)
        expected = 10 * np.log10(1 + (OMEGA * 5.0 / (2 * Z0)) ** 2)
        assert_allclose(result.transmission_loss, expected, rtol=1e-10)

    def test_tension(self):
        angle, frequency = 60.0, np.array([500.0])
        kx = 2 * np.pi * frequency / AIR.sound_speed * np.sin(np.radians(angle))
        omega = 2 * np.pi * frequency
        expected = 1j * (omega * 0.3 - 1e3 * (1 + 0.1j) * kx**2 / omega)
        layer = Membrane(surface_density=0.3, tension=1e3, loss_factor=0.1)
        assert_allclose(jump(layer, frequency, angle), expected, rtol=1e-10)

    def test_transparent_where_its_wave_runs_with_the_sound(self):
        tension = 0.3 * (AIR.sound_speed / np.sin(np.radians(60.0))) ** 2
        layer = Membrane(surface_density=0.3, tension=tension)
        result = plane_wave(Stack(layers=(layer,), termination="ambient"), FREQUENCIES, 60.0)
        assert_allclose(result.transmission, 1.0, rtol=1e-9)

    def test_plate_without_stiffness(self):
        plate = ElasticPlate(thickness=1e-3, density=900.0, young_modulus=1e-6, poisson_ratio=0.3)
        assert_allclose(jump(Membrane(surface_density=0.9), angle=45.0), jump(plate, angle=45.0), rtol=1e-10)


WOOD = {
    "thickness": 0.01, "density": 450.0, "young_modulus_x": 11e9, "young_modulus_y": 0.5e9, "poisson_ratio_xy": 0.4,
    "shear_modulus_xy": 0.7e9,
}  # fmt: skip


def stiffness(**fields):
    wave = Wave.incident(1000.0, 45.0, AIR)
    return complex(OrthotropicPlate(**{**WOOD, **fields}).stiffness(wave))


class TestOrthotropicPlate:
    @pytest.mark.parametrize("azimuth", [0.0, 25.0, 90.0, 200.0])
    def test_isotropic(self, azimuth):
        steel = {"thickness": 2e-3, "density": 7800.0, "loss_factor": 0.01}
        ours = OrthotropicPlate(
            **steel, young_modulus_x=2e11, young_modulus_y=2e11, poisson_ratio_xy=0.3, azimuth=azimuth,
            shear_modulus_xy=2e11 / 2.6,
        )  # fmt: skip
        theirs = ElasticPlate(**steel, young_modulus=2e11, poisson_ratio=0.3)
        assert_allclose(jump(ours, angle=70.0), jump(theirs, angle=70.0), rtol=1e-11)

    def test_along_the_axes(self):
        plane = 1 - 0.4**2 * 0.5 / 11
        assert stiffness() == pytest.approx(11e9 * 1e-6 / 12 / plane, rel=1e-12)
        assert stiffness(azimuth=90.0) == pytest.approx(0.5e9 * 1e-6 / 12 / plane, rel=1e-12)

    def test_axes_may_be_exchanged(self):
        turned = stiffness(
            young_modulus_x=0.5e9, young_modulus_y=11e9, poisson_ratio_xy=0.4 * 0.5 / 11, azimuth=90.0 - 30.0
        )
        assert stiffness(azimuth=30.0) == pytest.approx(turned, rel=1e-12)

    def test_between_the_axes_the_shear_modulus_counts(self):
        """At 45 degrees D = (Dx + Dy + 2 nu_yx Dx + G h^3 / 3) / 4."""
        plane = 1 - 0.4**2 * 0.5 / 11
        expected = (11e9 + 0.5e9 + 2 * 0.4 * 0.5e9) / plane * 1e-6 / 48 + 0.7e9 * 1e-6 / 12
        assert stiffness(azimuth=45.0) == pytest.approx(expected, rel=1e-12)

    def test_losses(self):
        assert stiffness(loss_factor=0.02) == pytest.approx(stiffness() * (1 + 0.02j), rel=1e-12)
        law = {"law": "loss_factor", "young_modulus": 11e9, "loss_factor": 0.02}
        plate = OrthotropicPlate.model_validate({**WOOD, "young_modulus_x": law})
        assert plate.stiffness(Wave.incident(1000.0, 0.0, AIR)).imag > 0

    def test_angle_in_degrees(self):
        assert OrthotropicPlate.model_validate({**WOOD, "azimuth": "0.5 rad"}).azimuth == pytest.approx(
            28.6479, abs=1e-4
        )

    def test_damped_once(self):
        with pytest.raises(ValueError, match="loss_factor stands beside a modulus that has losses already"):
            OrthotropicPlate(**{**WOOD, "shear_modulus_xy": 0.7e9 + 1e7j}, loss_factor=0.01)

    def test_energy_is_positive(self):
        with pytest.raises(ValueError, match="energy is negative"):
            OrthotropicPlate(**{**WOOD, "poisson_ratio_xy": 5.0})


PLATE = {"thickness": 1e-3, "hole_radius": 1e-3, "perforation": 0.05}
MICRO = {"thickness": 0.3e-3, "hole_radius": 0.15e-3, "perforation": 0.01, "model": "maa"}


SLAB = {"thickness": 0.15, "density": 2300.0, "young_modulus": 30e9, "poisson_ratio": 0.2, "loss_factor": 0.03}
BEAMS = {k: v for k, v in SLAB.items() if k in ("thickness", "density", "loss_factor")} | {
    "young_modulus_x": 30e9, "young_modulus_y": 30e9, "poisson_ratio_xy": 0.2, "shear_modulus_xy": 12.5e9
}  # fmt: skip


@pytest.mark.parametrize("plate", [ElasticPlate(**SLAB), OrthotropicPlate(**BEAMS)])
class TestThickPlates:
    """Bending waves of six thicknesses: 1238 Hz."""

    def test_oblique_waves_bend_them(self, plate):
        with pytest.warns(ValidityWarning, match=r"bending wavelength / thickness from 6; here .* \(1250 to 3000 Hz\)"):
            jump(plate, np.array([500.0, 1200.0, 1250.0, 3000.0]), 45.0)

    @pytest.mark.parametrize("angle", [0.0, 5.0])
    def test_steep_waves_do_not(self, plate, angle):
        """To these they are a mass, however thick."""
        mass = 1j * 2 * np.pi * 3000 * 2300 * 0.15
        assert abs(jump(plate, np.array([3000.0]), angle)[0] / mass - 1) < 1 / 16


class TestPerforatedPlate:
    def test_end_of_a_single_hole(self):
        """A piston in a baffle: 8 / (3 pi) of its radius."""
        assert end_length(1.0, 1e-12) == pytest.approx(8 / (3 * np.pi), rel=0.003)

    def test_pitch(self):
        assert np.pi * 1e-6 / hole_pitch(1e-3, 0.05) ** 2 == pytest.approx(0.05)

    def test_mass_at_high_frequencies(self):
        mass = AIR.density / 0.05 * (1e-3 + 2 * end_length(1e-3, 0.05))
        ours = jump(PerforatedPlate(**PLATE), np.array([2000.0]))
        assert ours.imag / (2 * np.pi * 2000) == pytest.approx(mass, rel=0.06)

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_flow_resistance_at_low_frequencies(self, model):
        """Poiseuille: 8 viscosity h / (phi r^2)."""
        plate = {**MICRO, "model": model}
        poiseuille = 8 * AIR.viscosity * 0.3e-3 / (0.01 * 0.15e-3**2)
        assert jump(PerforatedPlate(**plate), np.array([0.01])).real == pytest.approx(poiseuille, rel=0.002)

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_air_pulsing_into_a_porous_material_weighs_its_tortuosity(self, model):
        plate = {**MICRO, "model": model}
        free, touched = (jump(PerforatedPlate(**plate, back_tortuosity=t), np.array([5e4])) for t in (1.0, 2.0))
        length = 0.85 * 0.15e-3 if model == "maa" else end_length(0.15e-3, 0.01)
        added = (touched - free).imag / (2 * np.pi * 5e4)
        assert added == pytest.approx(AIR.density * length / 0.01, rel=0.02)
        other = PerforatedPlate(**plate, front_tortuosity=2.0)
        assert_allclose(jump(other, np.array([5e4])), touched, rtol=1e-9)

    def test_nothing_flows_along_the_plate(self):
        thick = PerforatedPlate(thickness=0.05, hole_radius=1e-3, perforation=0.3)
        angles = np.array([0.0, 45.0, 80.0])
        impedance = plane_wave(Stack(layers=(thick,)), 1000.0, angles).surface_impedance
        assert_allclose(impedance, impedance[0], rtol=1e-12)

    def test_the_two_models_are_alike(self):
        band = np.linspace(200, 2000, 50)
        plates = (PerforatedPlate(**{**MICRO, "model": model}) for model in ("atalla_sgard", "maa"))
        ours, theirs = (plane_wave(Stack(layers=(plate, Fluid(thickness=0.05))), band).absorption for plate in plates)
        assert_allclose(ours, theirs, atol=0.06)

    def test_wide_pitch(self):
        with pytest.warns(ValidityWarning, match=r"pitch of the holes / wavelength up to 0\.5; .* \(2e\+04 Hz\)"):
            jump(PerforatedPlate(thickness=1e-3, hole_radius=4e-3, perforation=0.2), np.array([500.0, 2e4]))

    @pytest.mark.parametrize("fields", [{"perforation": 0.8}, {"hole_radius": 0.0}, {"front_tortuosity": 0.9}])
    def test_ranges(self, fields):
        with pytest.raises(ValueError, match="is not allowed"):
            PerforatedPlate(**{**PLATE, **fields})

    def test_in_front_of_a_solid_it_has_no_coupling_problem(self):
        plate = ElasticPlate(thickness=1e-3, density=2700.0, young_modulus=7e10, poisson_ratio=0.3)
        stack = Stack(layers=(PerforatedPlate(**PLATE), Fluid(thickness=0.02), plate), termination="ambient")
        assert np.all(plane_wave(stack, FREQUENCIES, [0.0, 60.0]).absorption >= 0)


class TestMaa:
    """D.-Y. Maa, J. Acoust. Soc. Am. 104 (1998) 2861-2866."""

    def test_his_approximation_is_within_six_percent(self):
        thickness, radius, phi = 0.5e-3, 0.2e-3, 0.01
        x = np.geomspace(0.3, 8, 40)  # his perforate constant k
        omega = x**2 * AIR.viscosity / AIR.density / radius**2
        end = maa_impedance(omega, 0.0, radius, phi, 1.0, AIR)
        ours = (maa_impedance(omega, thickness, radius, phi, 1.0, AIR) - end) * phi
        resistance = 8 * AIR.viscosity * thickness / radius**2 * np.sqrt(1 + x**2 / 32)
        mass = AIR.density * thickness * (1 + 1 / np.sqrt(9 + x**2 / 2))
        assert_allclose(ours.real, resistance, rtol=0.06)
        assert_allclose(ours.imag / omega, mass, rtol=0.06)

    def test_ends(self):
        omega, radius, phi = 2 * np.pi * 500.0, 0.2e-3, 0.01
        end = maa_impedance(omega, 0.0, radius, phi, 1.0, AIR)
        assert end.imag == pytest.approx(omega * AIR.density * 0.85 * 2 * radius / phi)
        x = radius * np.sqrt(omega * AIR.density / AIR.viscosity)
        # 32 eta t / (phi d^2) x sqrt(2) / 32 x k d / t
        assert end.real == pytest.approx(np.sqrt(2) * AIR.viscosity * x / (phi * 2 * radius))

    def test_peak_of_absorption(self):
        """4 r / (1 + r)^2 where mass and cavity cancel, w m = cot(w D / c)."""
        plate, depth = PerforatedPlate(**MICRO), 0.06
        band = np.linspace(400, 1500, 4401)
        absorption = plane_wave(Stack(layers=(plate, Fluid(thickness=depth))), band).absorption
        relative = jump(plate, band) / Z0
        reactance = relative.imag - 1 / np.tan(2 * np.pi * band * depth / AIR.sound_speed)
        at = int(np.argmin(np.abs(reactance)))
        r = relative[at].real
        assert absorption[at] == pytest.approx(4 * r / (1 + r) ** 2, rel=1e-6)
        assert absorption.max() == pytest.approx(absorption[at], rel=0.005)
        assert abs(band[np.argmax(absorption)] - band[at]) < 0.05 * band[at]


def test_screen_of_both_kinds_keeps_the_laws():
    check_layer(Screen(flow_resistivity=1e6, thickness=1e-3))


def test_unknown_path_into_a_screen():
    with pytest.raises(InputError, match="there is no 'flow_resistence'; did you mean 'flow_resistance'"):
        Stack(layers=(Screen(flow_resistance=1.0),)).replaced({"layers.0.flow_resistence": 2.0})
