"""Fits of modulus laws: parameters found again, their covariance, bounds, and what is refused."""

from typing import Annotated

import numpy as np
import pytest
from numpy.testing import assert_allclose
from pydantic import Field

from multilayer.errors import InputError
from multilayer.fits.law_fit import fit_law
from multilayer.media.laws import (
    LAWS,
    Constant,
    FractionalZener,
    FreeForm,
    HavriliakNegami,
    KelvinVoigt,
    LossFactor,
    Maxwell,
    ModulusLaw,
    Table,
    Zener,
)
from multilayer.registry import RegistryError
from multilayer.units import Unit

FREQUENCIES = np.geomspace(1.0, 1e5, 40)
PLATEAUS = {"relaxed_modulus": 1e5, "unrelaxed_modulus": 3e6, "relaxation_time": 2e-4}
SKEWED = HavriliakNegami(**PLATEAUS, order=0.6, asymmetry=0.5)
WITHOUT_LISTS = [
    Constant(young_modulus=2e6),
    LossFactor(young_modulus=2e6, loss_factor=0.05),
    KelvinVoigt(young_modulus=1e5, viscosity=3.0),
    Zener(**PLATEAUS),
    FractionalZener(**PLATEAUS, order=0.4),
    SKEWED,
]


def noisy(law, relative, seed=0):
    rng = np.random.default_rng(seed)
    noise = rng.standard_normal(FREQUENCIES.size) + 1j * rng.standard_normal(FREQUENCIES.size)
    return law(FREQUENCIES) * np.exp(relative * noise)


@pytest.mark.parametrize("law", WITHOUT_LISTS, ids=lambda law: law.law)
def test_finds_a_law_again_by_its_name(law):
    found = fit_law(law.law, FREQUENCIES, law(FREQUENCIES))
    expected = {name: value for name, value in law if name != "law"}
    assert found.parameters == pytest.approx(expected, rel=1e-5)
    assert found.mean_relative_error < 1e-7
    assert found.law.law == law.law


@pytest.mark.parametrize("name", [name for name, law in LAWS.working() if not issubclass(law, Table) and not law.wraps])
def test_every_registered_law_can_be_fitted(name):
    counts_elements = LAWS[name].spread.__func__ is not ModulusLaw.spread.__func__
    elements = 4 if counts_elements else None
    found = fit_law(name, FREQUENCIES, SKEWED(FREQUENCIES), elements=elements, starts=2)
    assert isinstance(found.law, LAWS[name])
    assert_allclose(found.modelled, found.law(FREQUENCIES))
    assert found.mean_magnitude_error <= found.mean_relative_error < 2.0


class Thick(KelvinVoigt):
    viscosity: Annotated[float, Field(ge=2.0), Unit("Pa*s")]


def test_the_least_that_a_field_may_be_is_a_bound():
    found = fit_law(Thick, FREQUENCIES, KelvinVoigt(young_modulus=1e5, viscosity=1.0)(FREQUENCIES))
    assert found.parameters["viscosity"] == pytest.approx(2.0)
    assert found.on_bound == ("viscosity",)


def test_maxwell_branches_are_found_again():
    law = Maxwell(relaxed_modulus=1e5, branch_modulus=(2e5, 1e6), relaxation_time=(3e-2, 1e-4))
    found = fit_law("maxwell", FREQUENCIES, law(FREQUENCIES), elements=2)
    order = np.argsort(found.law.relaxation_time)[::-1]
    assert_allclose(np.array(found.law.relaxation_time)[order], law.relaxation_time, rtol=1e-4)
    assert_allclose(np.array(found.law.branch_modulus)[order], law.branch_modulus, rtol=1e-4)


def test_a_free_form_follows_any_law():
    found = fit_law("free_form", FREQUENCIES, SKEWED(FREQUENCIES), elements=16, starts=0)
    assert found.mean_relative_error < 0.01
    assert "frequency.0" not in found.parameters


def test_all_good_starts_end_alike():
    found = fit_law("havriliak_negami", FREQUENCIES, noisy(SKEWED, 0.01), starts=4)
    assert found.misfits.size == 5
    assert np.all(np.diff(found.misfits) >= 0)
    assert found.misfits[1] == pytest.approx(found.misfits[0], rel=1e-3)


class TestUncertainty:
    def test_covers_the_truth(self):
        """Errors over standard deviations of two parameters each, with the deviation given and estimated."""
        truth = np.array([3e6, 0.6])
        for given in (0.02, None):
            scores = []
            for seed in range(40):
                found = fit_law(
                    "havriliak_negami", FREQUENCIES, noisy(SKEWED, 0.02, seed), relative_std=given, starts=0
                )
                values = np.array([found.parameters[name] for name in ("unrelaxed_modulus", "order")])
                stds = np.array([found.std[name] for name in ("unrelaxed_modulus", "order")])
                scores.append((values - truth) / stds)
            assert np.sqrt(np.mean(np.square(scores))) == pytest.approx(1.0, abs=0.25)

    def test_halves_with_half_the_noise(self):
        wide, narrow = (fit_law(Zener, FREQUENCIES, noisy(Zener(**PLATEAUS), s), starts=1) for s in (0.02, 0.01))
        assert narrow.std["relaxation_time"] == pytest.approx(wide.std["relaxation_time"] / 2, rel=0.02)

    def test_is_not_known_with_as_many_unknowns_as_data(self):
        f = np.array([100.0, 1000.0])
        e = FractionalZener(relaxed_modulus=1e5, unrelaxed_modulus=1e6, relaxation_time=2e-5, order=0.4)(f)
        measured = e * np.exp([0.01 - 0.02j, -0.015 + 0.01j])
        found = fit_law("fractional_zener", f, measured)
        assert not found.on_bound
        assert np.all(np.isnan(list(found.std.values())))
        stated = fit_law("fractional_zener", f, measured, relative_std=0.02)
        assert min(stated.std.values()) > 0

    def test_of_a_parameter_on_a_bound_is_not_told(self):
        found = fit_law("havriliak_negami", FREQUENCIES, SKEWED(FREQUENCIES), bounds={"order": (0.7, 1.0)})
        assert found.on_bound == ("order",)
        assert found.parameters["order"] == pytest.approx(0.7, rel=1e-4)
        assert found.std["order"] == 0.0


class TestPassiveRange:
    def test_a_solution_on_the_limit_is_found(self):
        """alpha beta = 1."""
        law = HavriliakNegami(**PLATEAUS, order=0.4, asymmetry=2.5)
        found = fit_law("havriliak_negami", FREQUENCIES, law(FREQUENCIES))
        assert found.mean_relative_error < 1e-3
        assert found.parameters["order"] * found.parameters["asymmetry"] <= 1 + 1e-12
        assert found.on_bound == ("asymmetry",)

    def test_data_that_fall_give_a_modulus_that_stays(self):
        found = fit_law("zener", FREQUENCIES, SKEWED(FREQUENCIES).real[::-1] + 1e3j)
        assert found.parameters["unrelaxed_modulus"] >= found.parameters["relaxed_modulus"]

    def test_bounds_and_limits_together(self):
        found = fit_law("zener", FREQUENCIES, SKEWED(FREQUENCIES), bounds={"unrelaxed_modulus": (1e4, 2e5)})
        assert found.parameters["relaxed_modulus"] <= found.parameters["unrelaxed_modulus"] <= 2e5 * (1 + 1e-9)


class TestKnown:
    def test_fields_may_be_fixed_in_any_unit(self):
        found = fit_law("havriliak_negami", FREQUENCIES, SKEWED(FREQUENCIES), fixed={"relaxed_modulus": "100 kPa"})
        assert found.law.relaxed_modulus == 1e5
        assert set(found.parameters) == {"unrelaxed_modulus", "relaxation_time", "order", "asymmetry"}
        assert found.mean_relative_error < 1e-7

    def test_relaxation_times_may_be_fixed(self):
        law = Maxwell(relaxed_modulus=1e5, branch_modulus=(2e5, 1e6), relaxation_time=(3e-2, 1e-4))
        start = law.model_copy(update={"branch_modulus": (1.0, 1.0)})
        found = fit_law(start, FREQUENCIES, law(FREQUENCIES), fixed={"relaxation_time": (3e-2, 1e-4)})
        assert_allclose(found.law.branch_modulus, law.branch_modulus, rtol=1e-6)

    def test_a_law_to_start_from_gives_the_nodes(self):
        law = FreeForm(relaxed_modulus=1e5, frequency=(10.0, 1e3, 1e4), rise=(1e6, 2e5))
        found = fit_law(law.model_copy(update={"rise": (1e5, 1e5)}), FREQUENCIES, law(FREQUENCIES))
        assert found.law.frequency == law.frequency
        assert_allclose(found.law.rise, law.rise, rtol=1e-5)


class TestRefused:
    @pytest.mark.parametrize(
        ("law", "options", "message"),
        [
            ("maxwell", {}, "say how many `elements`"),
            ("zener", {"elements": 3}, "Zener has no elements to count"),
            ("maxwell", {"elements": 60}, "40 moduli, 121 parameters to find"),
            (Table, {}, "a table is data"),
            ("zener", {"fixed": {"unrelaxed": 1.0}}, "has no field 'unrelaxed'; did you mean 'unrelaxed_modulus'"),
            ("zener", {"bounds": {"tau": (1.0, 2.0)}}, "has no field 'tau'"),
            ("zener", {"bounds": {"relaxation_time": (1.0, 0.1)}}, "must be above 0 and in order"),
            ("zener", {"fixed": {"relaxation_time": -1.0}}, "relaxation_time: -1.0 is not allowed"),
            ("zener", {"fixed": {"relaxed_modulus": 2e6, "unrelaxed_modulus": 1e6}}, "creates energy"),
            ("zener", {"fixed": {"relaxed_modulus": 2e6}, "bounds": {"unrelaxed_modulus": (1e3, 1e6)}}, "no such law"),
        ],
    )
    def test_options(self, law, options, message):
        with pytest.raises(InputError, match=message):
            fit_law(law, FREQUENCIES, SKEWED(FREQUENCIES), **options)

    def test_a_name_nobody_knows(self):
        with pytest.raises(RegistryError, match="did you mean 'zener'"):
            fit_law("zenner", FREQUENCIES, SKEWED(FREQUENCIES))

    @pytest.mark.parametrize(
        ("frequency", "modulus", "message"),
        [([1.0, 2.0], [1e5], "lists of one length"), ([1.0, -2.0], [1e5, 1e5], "entry 2"), ([1.0], [0.0], "entry 1")],
    )
    def test_data(self, frequency, modulus, message):
        with pytest.raises(InputError, match=message):
            fit_law("constant", frequency, modulus)
