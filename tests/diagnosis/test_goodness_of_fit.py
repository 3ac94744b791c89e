"""P-values of the errors of laws; fits that are given up."""

from types import SimpleNamespace

import numpy as np
from scipy.stats import kstest

from multilayer.diagnosis.fitting import Fitted, StartedFit, finish_all
from multilayer.diagnosis.goodness_of_fit import lack_of_fit, law_p_value, size_p_value
from multilayer.inference.low_rank import LowRank
from multilayer.inference.problem import Minimum
from tests.fits.gaussian import Plain, linear

N_DATA = 40


def fitted(residual, z=(), stated=(), errors=None):
    parameters = tuple(SimpleNamespace(nuisance=is_nuisance) for is_nuisance in stated)
    minimum = Minimum(np.array(z), residual, np.empty((len(residual), len(z))))
    return Fitted(SimpleNamespace(parameters=parameters, effects=()), minimum, errors)


def test_the_p_value_of_a_true_law_is_uniformly_distributed():
    rng = np.random.default_rng(0)
    errors = LowRank.of(rng.standard_normal((N_DATA, 6)) * np.geomspace(0.1, 30, 6))
    p_values = [law_p_value(fitted(rng.standard_normal(N_DATA), errors=errors)) for _ in range(2000)]
    # two moments of a weighted sum: all but the shape far out
    assert kstest(p_values, "uniform").statistic < 0.05


def test_a_wrong_law_has_a_small_p_value():
    rng = np.random.default_rng(1)
    basis = 5 * rng.standard_normal((N_DATA, 3))
    errors = LowRank.of(basis)
    for amount, allowed in ((1.0, True), (8.0, False)):
        residual = errors.whitened(basis @ np.full(3, amount) + rng.standard_normal(N_DATA))
        assert (law_p_value(fitted(residual, errors=errors)) > 1e-3) == allowed


def test_without_errors_of_laws_their_p_value_is_one():
    assert law_p_value(fitted(np.ones(N_DATA))) == 1.0


def of_effects(names, z):
    """Return a fit of effects of one size each, at these coordinates."""
    parameters = [SimpleNamespace(name=f"{name}.size", nuisance=False) for name in names]
    effects = [SimpleNamespace(name=name, error_of="") for name in names]
    hypothesis = SimpleNamespace(names=names, parameters=parameters, effects=effects)
    return Fitted(hypothesis, Minimum(np.array(z), np.zeros(4), np.zeros((4, len(z)))))


def test_two_effects_may_be_as_far_off_as_each_of_them_may():
    one, two, far = (
        of_effects(*case) for case in ((("a",), [4.0]), (("a", "b"), [4.0, 2.0]), (("a", "b"), [4.0, 4.0]))
    )
    assert 1e-6 < size_p_value(one) < 1e-3
    assert 1e-6 < size_p_value(two) < 1e-3
    assert size_p_value(far) < 1e-6
    assert [bool(lack_of_fit(fit, is_misfit_allowed=True)) for fit in (one, two, far)] == [True, False, True]


class Bare(Plain):
    """A hypothesis without effects."""

    effects = ()
    law_errors = ()


def test_fits_far_behind_are_given_up_and_others_finished():
    rng = np.random.default_rng(2)
    slopes = rng.standard_normal((N_DATA, 2))

    def started(off):
        same = linear(slopes, off + slopes @ np.ones(2))
        hypothesis = Bare(same.function, same.parameters)
        return StartedFit.at(hypothesis, np.zeros((1, 2)))

    near, far = started(0.1), started(30.0)
    fits = finish_all({"near": near, "far": far})
    assert list(fits) == ["near", "far"]
    assert np.array_equal(fits["far"].minimum.z, far.starts[0])
    assert fits["near"].minimum.cost < near.provisional.minimum.cost
    assert fits["near"].log_evidence > fits["far"].log_evidence
    # alone it is the best there is, and is finished
    alone = finish_all({"far": far})
    assert alone["far"].minimum.cost < far.provisional.minimum.cost
