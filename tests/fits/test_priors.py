"""Priors against the quantile functions of their distributions."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from multilayer.inference.priors import Parameter, Prior, Priors

KINDS = {
    "normal": (Prior(normal=(-3.0, 2.0)), stats.norm(-3.0, 2.0)),
    "lognormal": (Prior(lognormal=(2e4, 0.5)), stats.lognorm(0.5, scale=2e4)),
    "uniform": (Prior(uniform=(0.2, 1.4)), stats.uniform(0.2, 1.2)),
    "loguniform": (Prior(loguniform=(1e3, 1e6)), stats.loguniform(1e3, 1e6)),
    "cut": (Prior(normal=(0.5, 0.3), bounds=(0.0, 1.0)), stats.truncnorm(-0.5 / 0.3, 0.5 / 0.3, 0.5, 0.3)),
}


@pytest.mark.parametrize("kind", KINDS)
def test_a_value_is_the_quantile_of_its_coordinate(kind):
    prior, distribution = KINDS[kind]
    z = np.linspace(-3, 3, 13).reshape(1, 13)
    np.testing.assert_allclose(prior.value(z), distribution.ppf(stats.norm.cdf(z)), rtol=1e-9, atol=1e-12)


def test_one_cut_on_a_logarithmic_scale_keeps_its_bounds_and_median():
    prior = Prior(lognormal=(1.0, 1.0), bounds=(0.5, 2.0))
    assert prior.value(0.0) == pytest.approx(1.0)  # bounds at the same distance of its logarithm
    np.testing.assert_allclose(prior.value(np.array([-9.0, 9.0])), [0.5, 2.0], rtol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
@given(z=st.floats(-3, 3))
def test_the_coordinate_of_a_value_is_the_one_it_came_from(kind, z):
    prior, _ = KINDS[kind]
    assert prior.coordinate(prior.value(z)) == pytest.approx(z, abs=1e-9)


def test_a_fixed_value_stays():
    prior = Prior(fixed=1.2)
    np.testing.assert_array_equal(prior.value(np.array([-2.0, 0.0, 5.0])), 1.2)
    assert prior.coordinate(1.2) == 0.0


def test_many_at_once_are_as_each_by_itself():
    parameters = [Parameter(name=kind, prior=prior) for kind, (prior, _) in KINDS.items()]
    parameters.append(Parameter(name="known", prior=Prior(fixed=7.0)))
    z = np.random.default_rng(0).normal(size=(4, 3, len(parameters)))
    together = Priors.of(parameters).named(z)
    for i, parameter in enumerate(parameters):
        np.testing.assert_array_equal(together[parameter.name], parameter.prior.value(z[..., i]))


def test_none_have_no_values():
    assert Priors(()).values(np.empty((5, 0))).shape == (5, 0)
    assert Priors(()).named(np.empty((5, 0))) == {}


def test_coordinates_far_off_overflow_without_a_warning(recwarn):
    priors = Priors.of([Parameter(name="size", prior=Prior(lognormal=(1.0, 0.5)))])
    assert priors.values(np.array([[1e4], [0.0]])).ravel() == pytest.approx([np.inf, 1.0])
    assert not recwarn.list
