"""Density and bulk modulus of the gas in pores: limits that are known, and models that contain each other."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.special import jv

from multilayer.media.empirical import delany_bazley, miki
from multilayer.media.gas import dry_air
from multilayer.media.narrow import narrow_gas
from multilayer.media.pore_models import PORE_MODELS
from multilayer.media.pore_sizes import flow_resistivity, horoshenkov_swift
from multilayer.media.porous import (
    champoux_allard_modulus,
    johnson_density,
    lafarge_modulus,
    limp_density,
    pride_density,
    pride_lafarge_modulus,
)
from multilayer.media.relaxation import wilson, wilson_of_resistivity

AIR = dry_air()
OMEGA = 2 * np.pi * np.geomspace(1.0, 5e4, 30)
PORES = {
    "porosity": 0.95, "flow_resistivity": 2e4, "tortuosity": 1.4, "viscous_length": 6e-5, "thermal_length": 1.3e-4,
    "thermal_permeability": 4e-9, "static_viscous_tortuosity": 2.1, "static_thermal_tortuosity": 1.7,
    "median_pore_size": 1e-4, "pore_size_deviation": 0.3,
}  # fmt: skip
SEMI_EMPIRICAL = ["jca", "jcal", "jcapl", "wilson", "horoshenkov_swift"]
SLOW, FAST = 1e-6, 1e9


def fluid(name, omega):
    """Return density and modulus of one model, by functions that check no range."""
    fields, function = PORE_MODELS[name].variants[-1]
    return function(np.asarray(omega), AIR, **{field: PORES[field] for field in fields})


def static_resistivity(name):
    if name != "horoshenkov_swift":
        return PORES["flow_resistivity"]
    return flow_resistivity(PORES["porosity"], PORES["median_pore_size"], PORES["pore_size_deviation"], AIR)


@pytest.mark.parametrize("name", SEMI_EMPIRICAL)
class TestLimits:
    def test_darcy_flow_at_low_frequencies(self, name):
        density, _ = fluid(name, SLOW)
        assert density * 1j * SLOW == pytest.approx(static_resistivity(name), rel=1e-9)

    def test_isothermal_at_low_frequencies(self, name):
        _, bulk = fluid(name, SLOW)
        assert bulk == pytest.approx(AIR.pressure / PORES["porosity"], rel=1e-8)

    def test_tortuous_mass_at_high_frequencies(self, name):
        tortuosity = np.exp(4 * (0.3 * np.log(2)) ** 2) if name == "horoshenkov_swift" else PORES["tortuosity"]
        density, _ = fluid(name, FAST)
        assert density.real == pytest.approx(tortuosity * AIR.density / PORES["porosity"], rel=0.01)

    def test_adiabatic_at_high_frequencies(self, name):
        _, bulk = fluid(name, FAST)
        assert bulk.real == pytest.approx(AIR.heat_capacity_ratio * AIR.pressure / PORES["porosity"], rel=0.01)

    def test_no_energy_is_created(self, name):
        density, bulk = fluid(name, OMEGA)
        assert np.all(density.imag <= 0)
        assert np.all(bulk.imag >= 0)


class TestModelsInOneAnother:
    def test_lafarge_is_champoux_allard(self):
        phi, length = PORES["porosity"], PORES["thermal_length"]
        ours = lafarge_modulus(OMEGA, phi, length, phi * length**2 / 8, AIR)
        assert_allclose(ours, champoux_allard_modulus(OMEGA, phi, length, AIR), rtol=1e-13)

    def test_pride_is_johnson(self):
        given = [PORES[name] for name in ("porosity", "flow_resistivity", "tortuosity", "viscous_length")]
        phi, sigma, tortuosity, length = given
        shape = 8 * AIR.viscosity * tortuosity / (sigma * phi * length**2)
        ours = pride_density(OMEGA, *given, tortuosity * (1 + shape / 4), AIR)
        assert_allclose(ours, johnson_density(OMEGA, *given, AIR), rtol=1e-13)

    def test_pride_lafarge_is_lafarge(self):
        given = [PORES[name] for name in ("porosity", "thermal_length", "thermal_permeability")]
        shape = 8 * given[2] / (given[0] * given[1] ** 2)
        ours = pride_lafarge_modulus(OMEGA, *given, 1 + shape / 4, AIR)
        assert_allclose(ours, lafarge_modulus(OMEGA, *given, AIR), rtol=1e-13)

    def test_pride_has_the_static_tortuosity(self):
        density, _ = fluid("jcapl", SLOW)
        assert density.real == pytest.approx(2.1 * AIR.density / PORES["porosity"], rel=1e-6)

    def test_wilson_by_its_times(self):
        phi, tortuosity, sigma = PORES["porosity"], PORES["tortuosity"], PORES["flow_resistivity"]
        time = 2 * AIR.density * tortuosity / (sigma * phi)
        times = {"vorticity_time": time, "entropy_time": AIR.prandtl * time}
        known = {"porosity": phi, "tortuosity": tortuosity}
        assert_allclose(
            wilson(OMEGA, AIR, **known, **times), wilson_of_resistivity(OMEGA, AIR, **known, flow_resistivity=sigma)
        )


RADIUS = 1.5e-4


class TestStraightTubes:
    """In straight round tubes Zwikker and Kosten's solution is exact, and every model is an approximation of it."""

    TUBES = {  # noqa: RUF012
        "porosity": 0.6, "flow_resistivity": 8 * AIR.viscosity / (0.6 * RADIUS**2), "tortuosity": 1.0,
        "viscous_length": RADIUS, "thermal_length": RADIUS, "thermal_permeability": 0.6 * RADIUS**2 / 8,
        "static_viscous_tortuosity": 4 / 3, "static_thermal_tortuosity": 4 / 3, "median_pore_size": RADIUS,
        "pore_size_deviation": 0.0,
    }  # fmt: skip

    @pytest.mark.parametrize(
        ("name", "density", "modulus"),
        [("jca", 0.06, 0.02), ("jcapl", 0.02, 0.01), ("wilson", 0.07, 0.02), ("horoshenkov_swift", 0.07, 0.02)],
    )
    def test_model_is_near_the_exact_solution(self, name, density, modulus):
        exact = [value / 0.6 for value in narrow_gas(OMEGA, "tube", RADIUS, AIR)]
        fields, function = PORE_MODELS[name].variants[-1]
        ours = function(OMEGA, AIR, **{field: self.TUBES[field] for field in fields})
        assert_allclose(ours[0], exact[0], rtol=density)
        assert_allclose(ours[1], exact[1], rtol=modulus)

    def test_exact_solution_by_bessel_functions_of_the_first_kind(self):
        s = RADIUS * np.sqrt(-1j * OMEGA[:20] * AIR.density / AIR.viscosity)
        t = s * np.sqrt(AIR.prandtl)
        gamma = AIR.heat_capacity_ratio
        density, bulk = narrow_gas(OMEGA[:20], "tube", RADIUS, AIR)
        assert_allclose(density, AIR.density / (1 - 2 * jv(1, s) / (s * jv(0, s))), rtol=1e-9)
        assert_allclose(bulk, gamma * AIR.pressure / (1 + (gamma - 1) * 2 * jv(1, t) / (t * jv(0, t))), rtol=1e-12)

    def test_low_and_high_frequencies(self):
        density, bulk = narrow_gas(1e-3, "tube", RADIUS, AIR)
        assert density.imag * -1e-3 == pytest.approx(8 * AIR.viscosity / RADIUS**2, rel=1e-9)
        assert density.real == pytest.approx(4 / 3 * AIR.density, rel=1e-6)
        assert bulk == pytest.approx(AIR.pressure, rel=1e-6)
        density, bulk = narrow_gas(1e10, "tube", 1e-2, AIR)
        assert density == pytest.approx(AIR.density, rel=1e-5)
        assert bulk == pytest.approx(AIR.heat_capacity_ratio * AIR.pressure, rel=1e-5)


class TestSlits:
    def test_exact_solution_by_the_hyperbolic_tangent(self):
        z = 1e-4 * np.sqrt(1j * OMEGA * AIR.density / AIR.viscosity)
        t = z * np.sqrt(AIR.prandtl)
        gamma = AIR.heat_capacity_ratio
        density, bulk = narrow_gas(OMEGA, "slit", 1e-4, AIR)
        assert_allclose(density, AIR.density / (1 - np.tanh(z) / z), rtol=1e-9)
        assert_allclose(bulk, gamma * AIR.pressure / (1 + (gamma - 1) * np.tanh(t) / t), rtol=1e-12)

    def test_poiseuille_flow(self):
        density, _ = narrow_gas(1e-3, "slit", 1e-4, AIR)
        assert density.imag * -1e-3 == pytest.approx(12 * AIR.viscosity / 2e-4**2, rel=1e-9)
        assert density.real == pytest.approx(6 / 5 * AIR.density, rel=1e-6)

    def test_wide_slits_do_not_overflow(self):
        density, bulk = narrow_gas(2 * np.pi * 5e4, "slit", 1.0, AIR)
        assert density == pytest.approx(AIR.density, rel=1e-4)
        assert bulk == pytest.approx(AIR.heat_capacity_ratio * AIR.pressure, rel=1e-4)


class TestEmpirical:
    SIGMA = 2e4

    @pytest.fixture
    def omega(self):
        return 2 * np.pi * self.SIGMA * np.geomspace(0.02, 1.0, 12)

    def impedance_and_wavenumber(self, model, omega):
        density, bulk = model(omega, AIR, flow_resistivity=self.SIGMA)
        return np.sqrt(density * bulk) / AIR.impedance, np.sqrt(density / bulk) * AIR.sound_speed

    def test_a_value_by_hand(self):
        # f / sigma = 0.1: 9.08 x 100^-0.75 = 0.28714, 11.9 x 100^-0.73 = 0.41261, and so on
        impedance, wavenumber = self.impedance_and_wavenumber(delany_bazley, np.array(2 * np.pi * 0.1 * self.SIGMA))
        assert impedance == pytest.approx(1.28714 - 0.41261j, abs=2e-5)
        assert wavenumber == pytest.approx(1.42996 - 0.68051j, abs=2e-5)

    def test_delany_bazley_is_near_the_fit_of_allard_and_champoux(self, omega):
        """Appl. Acoust. 3 (1970) against J. Acoust. Soc. Am. 91 (1992) 3346, two fits to the same data."""
        x = AIR.density * omega / (2 * np.pi) / self.SIGMA
        ours = self.impedance_and_wavenumber(delany_bazley, omega)
        assert_allclose(ours[0], 1 + 0.0571 * x**-0.754 - 0.087j * x**-0.732, rtol=0.01)
        assert_allclose(ours[1], 1 + 0.0978 * x**-0.7 - 0.189j * x**-0.595, rtol=0.01)

    def test_miki_is_near_delany_bazley(self, omega):
        for ours, theirs in zip(
            self.impedance_and_wavenumber(miki, omega), self.impedance_and_wavenumber(delany_bazley, omega), strict=True
        ):
            assert_allclose(ours, theirs, rtol=0.1)

    @pytest.mark.parametrize("model", [delany_bazley, miki])
    def test_passive_in_the_range(self, model, omega):
        density, bulk = model(omega, AIR, flow_resistivity=self.SIGMA)
        assert np.all(density.imag <= 0)
        assert np.all(bulk.imag >= 0)


class TestPoreSizes:
    def test_characteristic_lengths(self):
        """Both approach their limits as Johnson's and Champoux and Allard's do, with the lengths of the 2019 paper."""
        phi, size, deviation = (PORES[name] for name in ("porosity", "median_pore_size", "pore_size_deviation"))
        spread = (deviation * np.log(2)) ** 2
        omega = np.array([1e8, 1e9])
        density, bulk = horoshenkov_swift(
            omega, AIR, porosity=phi, median_pore_size=size, pore_size_deviation=deviation
        )
        sigma = flow_resistivity(phi, size, deviation, AIR)
        viscous, thermal = size * np.exp(-2.5 * spread), size * np.exp(1.5 * spread)
        assert_allclose(density, johnson_density(omega, phi, sigma, np.exp(4 * spread), viscous, AIR), rtol=1e-4)
        assert_allclose(bulk, champoux_allard_modulus(omega, phi, thermal, AIR), rtol=1e-4)

    def test_flow_resistivity_is_the_static_limit_of_a_spread(self):
        wide, narrow = (flow_resistivity(0.4, 1e-4, deviation, AIR) for deviation in (0.5, 0.0))
        assert narrow == pytest.approx(8 * AIR.viscosity / (0.4 * 1e-8))
        assert wide / narrow == pytest.approx(np.exp(10 * (0.5 * np.log(2)) ** 2))


class TestLimp:
    def test_heavy_frame_does_not_move(self):
        rigid, _ = fluid("jca", OMEGA)
        assert_allclose(limp_density(rigid, PORES["porosity"], 1e9, AIR), rigid, rtol=1e-4)

    def test_frame_and_gas_move_as_one_at_low_frequencies(self):
        rigid, _ = fluid("jca", SLOW)
        total = 30 + PORES["porosity"] * AIR.density
        assert limp_density(rigid, PORES["porosity"], 30.0, AIR) == pytest.approx(total, rel=1e-6)
