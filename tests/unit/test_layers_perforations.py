"""Perforated plates with slits, plates that move, loud sound and flows: closed forms and published numbers."""

from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.integrate import quad

from multilayer.config import parse_yaml
from multilayer.config.validate import validate
from multilayer.errors import InputError, ValidityWarning
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.fluid import Fluid
from multilayer.layers.membrane import Membrane
from multilayer.layers.perforated_plate import PerforatedPlate
from multilayer.media.gas import dry_air
from multilayer.media.perforations import (
    end_friction,
    end_length,
    grazing_mass,
    grazing_resistance,
    jet_resistance,
    maa_slit_impedance,
    slit_end_length,
    surface_resistance,
)
from multilayer.response import plane_wave
from multilayer.stack import Stack

AIR = dry_air()
Z0 = AIR.impedance
FREQUENCIES = np.array([50.0, 500.0, 3000.0])
OMEGA = 2 * np.pi * FREQUENCIES
MICRO = {"thickness": 0.2e-3, "hole_radius": 0.1e-3, "perforation": 0.01, "model": "maa"}
SLITS = {"thickness": 0.5e-3, "slit_width": 0.1e-3, "perforation": 0.02}
BOARD = {"density": 700.0, "young_modulus": 2e9, "poisson_ratio": 0.3}


def jump(layer, frequency=FREQUENCIES, angle=0.0):
    """Return the pressure difference over the velocity, from the transmission into air."""
    result = plane_wave(Stack(layers=(layer,), termination="ambient"), frequency, angle)
    return 2 * Z0 / np.cos(np.radians(angle)) * (1 / result.transmission - 1)


class TestSlits:
    @pytest.mark.parametrize("phi", [0.02, 0.2, 0.6])
    def test_end_of_slits_in_a_thin_sheet(self, phi):
        """Potential flow, its velocity in the slit 1/sqrt(sin^2(pi phi/2) - sin^2(pi y/d)): an even pressure there."""
        edge = np.sin(np.pi * phi / 2)
        y = lambda t: np.arcsin(edge * np.sin(t)) / np.pi  # noqa: E731  (d = 1)
        t = (np.arange(4000) + 0.5) / 4000 * np.pi - np.pi / 2  # equal steps of t let equal flows pass
        n = np.arange(1, 1500)[:, None]
        at = 0.3 * phi / 2
        harmonics = 2 * np.mean(np.cos(2 * np.pi * n * y(t)), axis=1)[:, None]
        pressure = np.sum(harmonics / (2 * np.pi * n) * np.cos(2 * np.pi * n * at))
        # of unit mean velocity in the channel; in the slit it is 1 / phi
        assert phi * pressure == pytest.approx(slit_end_length(phi, phi), rel=0.01)

    @pytest.mark.parametrize("phi", [0.02, 0.2, 0.6])
    def test_a_piston_in_the_slit_has_little_more(self, phi):
        """Ingard 1953: an even velocity, by modes of the channel in front; an upper bound of thick plates."""
        n = np.arange(1, 20000)
        piston = phi * np.sum(np.sin(np.pi * n * phi) ** 2 / (np.pi * n) ** 3) / phi**2
        assert 0 < piston - slit_end_length(phi, phi) < 0.1 * phi

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_flow_resistance(self, model):
        """Poiseuille between plates: 12 viscosity h / (phi w^2)."""
        plate = PerforatedPlate(model=model, **SLITS)
        assert jump(plate, 0.01).real == pytest.approx(12 * AIR.viscosity * 0.5e-3 / (0.02 * 1e-8), rel=0.002)

    def test_maa_approximation(self):
        """Maa 2000 for design: 12 viscosity t / w^2 sqrt(1 + k^2 / 18), density t (1 + 1 / sqrt(25 + 2 k^2))."""
        k = np.geomspace(0.2, 10, 30)
        omega = k**2 * 4 * AIR.viscosity / (AIR.density * 1e-8)
        args = (0.1e-3, 0.02, 1.0, AIR)
        inside = (maa_slit_impedance(omega, 1e-3, *args) - maa_slit_impedance(omega, 0.0, *args)) * 0.02
        assert_allclose(inside.real, 12 * AIR.viscosity * 1e-3 / 1e-8 * np.sqrt(1 + k**2 / 18), rtol=0.08)
        assert_allclose(inside.imag / omega, AIR.density * 1e-3 * (1 + 1 / np.sqrt(25 + 2 * k**2)), rtol=0.06)

    def test_the_two_models_are_alike(self):
        band = np.linspace(200, 2000, 50)
        both = [
            plane_wave(Stack(layers=(PerforatedPlate(model=m, **SLITS), Fluid(thickness=0.05))), band).absorption
            for m in ("atalla_sgard", "maa")
        ]
        assert_allclose(*both, atol=0.06)

    def test_air_in_wide_slits(self):
        mass = AIR.density / 0.1 * (2e-3 + 2 * slit_end_length(5e-3, 0.1))
        ours = jump(PerforatedPlate(thickness=2e-3, slit_width=5e-3, perforation=0.1), np.array([1000.0]))
        assert ours.imag / (2 * np.pi * 1000) == pytest.approx(mass, rel=0.03)

    def test_slits_may_be_most_of_the_plate(self):
        assert np.all(np.isfinite(jump(PerforatedPlate(thickness=1e-3, slit_width=1e-3, perforation=0.9))))


class TestEndFriction:
    """Surface resistance times the squared velocity along the walls, in the limit of a thin boundary layer."""

    def of_boundary_layers(self, inertance, area, half_width, depth=1e-2, step=1e-9):
        """A step of all walls into the gas changes the inertance by the squared velocity along them: both faces, too.

        Less what the walls of the opening themselves have, but for its ends.
        """
        change = inertance(half_width - step, depth + 2 * step) - inertance(half_width, depth)
        along = 2 * depth / half_width if area is round_area else depth / half_width
        return (change / step * area(half_width) - along) * surface_resistance(OMEGA, AIR)

    def test_of_holes(self):
        inertance = lambda a, h: (h + 2 * end_length(a, 1e-9)) / round_area(a)  # noqa: E731
        found = end_friction(OMEGA, "tube", AIR)
        assert_allclose(found, self.of_boundary_layers(inertance, round_area, 2e-3), rtol=0.02)  # 0.82 or 0.85 radii
        assert_allclose(found, 4 * surface_resistance(OMEGA, AIR), rtol=0.1)  # Ingard's estimate

    def test_of_slits(self):
        pitch = 10.0
        inertance = lambda b, h: (h + 2 * slit_end_length(2 * b, 2 * b / pitch)) / (2 * b)  # noqa: E731
        expected = self.of_boundary_layers(inertance, lambda b: 2 * b, 2e-3)
        assert_allclose(end_friction(OMEGA, "slit", AIR), expected, rtol=1e-3)

    def test_as_a_lengthened_pore(self):
        """Of a wide hole Atalla & Sgard's pore, longer by the mass at its ends, loses nearly as much more there."""
        phi, frequency = 1e-3, np.array([100.0, 1000.0])
        thin, thick = (
            jump(PerforatedPlate(thickness=h, hole_radius=2e-3, perforation=phi), frequency).real * phi
            for h in (1e-3, 2e-3)
        )
        ends = 2 * thin - thick  # what does not grow with the thickness
        assert_allclose(end_friction(2 * np.pi * frequency, "tube", AIR), ends, rtol=0.15)


def round_area(radius):
    return np.pi * radius**2


class TestMoving:
    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_heavy_is_still(self, model):
        still, heavy = (PerforatedPlate(**{**MICRO, "model": model}, density=d) for d in (None, 1e9))
        assert_allclose(jump(heavy), jump(still), rtol=1e-5)

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_without_holes_it_is_a_plate(self, model):
        plate = PerforatedPlate(
            model=model, thickness=0.01, hole_radius=1e-7, perforation=1e-9, **BOARD, loss_factor=0.02
        )
        solid = ElasticPlate(thickness=0.01, **BOARD, loss_factor=0.02)
        assert_allclose(jump(plate, angle=70.0), jump(solid, angle=70.0), rtol=1e-6)

    def test_foil_and_holes_in_parallel(self):
        """Lee, Lee & Ng 2005, but for the momentum of the air in the holes."""
        foil = 1j * OMEGA * 1400 * 0.2e-3 * 0.99
        parallel = 1 / (1 / foil + 1 / jump(PerforatedPlate(**MICRO)))
        assert_allclose(jump(PerforatedPlate(**MICRO, density=1400.0)), parallel, rtol=3e-3)

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    def test_drag_carries_a_light_foil(self, model):
        """Holes so fine that no air passes: foil and air weigh together, density h + phi rho0 h."""
        fine = {"thickness": 0.2e-3, "hole_radius": 1e-7, "perforation": 0.3, "model": model}
        mass = 0.2e-3 * (0.7 * 10 + 0.3 * AIR.density)
        matrix = PerforatedPlate(**fine, density=10.0).transfer_matrix(20.0)
        assert matrix[0, 1].imag / (2 * np.pi * 20) == pytest.approx(mass, rel=1e-3)

    def test_by_the_equations_of_motion(self):
        """The two equations of the docstring, solved as they stand."""
        phi, h, kx, omega = 0.15, 0.0125, OMEGA * np.sin(1.0) / AIR.sound_speed, OMEGA
        holes = {"thickness": h, "hole_radius": 3e-3, "perforation": phi, "model": "maa"}
        z = phi * jump(PerforatedPlate(**holes), angle=np.degrees(1.0))
        stiffness = 2e9 * h**3 / 12 / (1 - 0.09) * (1 + 0.05j)
        plate = 1j * omega * 700 * h * (1 - phi) + stiffness * kx**4 / (1j * omega)
        air = 1j * omega * AIR.density * h
        for i in range(3):
            # unknown v, u of a pressure difference of 1
            system = [[air[i], z[i]], [plate[i] + phi * air[i], phi * air[i]]]
            v, u = np.linalg.solve(system, [1, 1])
            ours = jump(PerforatedPlate(**holes, **BOARD, loss_factor=0.05), angle=np.degrees(1.0))[i]
            assert ours == pytest.approx(1 / (v + phi * u), rel=1e-9)

    def test_a_light_foil_absorbs_otherwise(self):
        """Its mass and the cavity: a peak below that of the holes in a foil that is held."""
        band = np.linspace(100, 1500, 800)
        still, light = (
            plane_wave(Stack(layers=(PerforatedPlate(**MICRO, density=d), Fluid(thickness=0.05))), band).absorption
            for d in (None, 300.0)
        )
        assert np.abs(still - light).max() > 0.1
        mass = Membrane(surface_density=0.99 * 300 * 0.2e-3)
        assert plane_wave(Stack(layers=(mass, Fluid(thickness=0.05))), band).absorption.max() < 1e-9


class TestLoudSoundAndFlows:
    def test_fundamental_of_a_jet(self):
        """Melling 1973: the part of density (1 - phi^2) u abs(u) / (2 C^2) in phase with u, by quadrature."""
        peak, c, phi = 3.0, 0.76, 0.1
        drop = lambda t: AIR.density * (1 - phi**2) / (2 * c**2) * (peak * np.cos(t)) * abs(peak * np.cos(t))  # noqa: E731
        fundamental = quad(lambda t: drop(t) * np.cos(t) / np.pi, 0, 2 * np.pi)[0]
        assert jet_resistance(peak / np.sqrt(2), 0.0, phi, c, AIR) == pytest.approx(fundamental / peak)
        # his 1.2 u_rms
        assert 8 * np.sqrt(2) / (3 * np.pi) == pytest.approx(1.2, abs=0.001)

    def test_fundamental_beside_a_faster_flow(self):
        flow, peak, c, phi = 5.0, 2.0, 0.8, 0.1
        drop = lambda t: AIR.density * (1 - phi**2) / (2 * c**2) * (flow + peak * np.cos(t)) ** 2  # noqa: E731
        fundamental = quad(lambda t: drop(t) * np.cos(t) / np.pi, 0, 2 * np.pi)[0]
        assert jet_resistance(0.0, flow, phi, c, AIR) == pytest.approx(fundamental / peak)

    def test_bias_flow_after_bauer(self):
        """Bauer 1977: 1.15 Mach numbers of the impedance of air."""
        assert jet_resistance(0.0, 0.05 * AIR.sound_speed, 0.0, 0.93, AIR) / Z0 == pytest.approx(1.15 * 0.05, rel=0.01)

    @pytest.mark.parametrize("model", ["atalla_sgard", "maa"])
    @pytest.mark.parametrize(
        ("field", "value", "resistance"),
        [
            ("hole_velocity", 4.0, jet_resistance(4.0, 0.0, 0.01, 0.76, AIR)),
            ("bias_velocity", 2.0, jet_resistance(0.0, 2.0, 0.01, 0.76, AIR)),
        ],
    )
    def test_added_to_the_plate(self, model, field, value, resistance):
        plate = {**MICRO, "model": model}
        added = jump(PerforatedPlate(**plate, **{field: value})) - jump(PerforatedPlate(**plate))
        assert_allclose(added, resistance / 0.01, rtol=1e-3)

    def test_grazing_flow_takes_mass_and_adds_resistance(self):
        mach = 0.2
        added = jump(PerforatedPlate(**MICRO, grazing_mach=mach)) - jump(PerforatedPlate(**MICRO))
        assert_allclose(added.real * 0.01, 0.3 * mach * Z0 * (1 - 1e-4), rtol=1e-9)
        assert_allclose(added.imag * 0.01, -OMEGA * AIR.density * 0.17e-3 * (1 - 1 / 3.44), rtol=1e-9)
        assert grazing_mass(0.0) == 1
        assert grazing_resistance(0.0, 0.1, AIR) == 0

    def test_fast_flow(self):
        with pytest.warns(ValidityWarning, match=r"grazing_mach up to 0\.5; here it is 0\.6"):
            jump(PerforatedPlate(**MICRO, grazing_mach=0.6))


@pytest.mark.parametrize(
    ("fields", "path", "told"),
    [
        ("perforation: 0.1", "hole_radius", "is missing; a perforated plate takes hole_radius, or slit_width"),
        ("perforation: 0.1, hole_radius: 1 mm, slit_width: 1 mm", "slit_width", "does not belong here"),
        ("perforation: 0.8, hole_radius: 1 mm", "perforation", "must be below 0.785398, where the holes touch"),
        ("perforation: 0.1, hole_radius: 1 mm, young_modulus: 1 GPa", "young_modulus", "goes with density and"),
        ("perforation: 0.1, hole_radius: 1 mm, poisson_ratio: 0.3", "poisson_ratio", "goes with young_modulus"),
        ("perforation: 0.1, hole_radius: 1 mm, loss_factor: 0.3", "loss_factor", "goes with a young_modulus"),
        ("perforation: 0.1, slit_width: 1 mm, hole_velocity: 1, bias_velocity: 2", "hole_velocity", "stands beside"),
    ],
)
def test_mistakes(fields, path, told):
    text = f"layers:\n- {{type: perforated_plate, thickness: 1 mm, {fields}}}\n"
    with pytest.raises(InputError) as caught:
        validate(parse_yaml(text, Path("stack.yaml")), Stack)
    (problem,) = caught.value.problems
    assert problem.path == f"layers.0.{path}"
    assert told in problem.message
    assert problem.line == 2
