"""What a hypothesis asks of stated uncertainties and of its law, against what chance asks."""

from types import SimpleNamespace

import numpy as np
from scipy.stats import kstest

from multilayer.diagnosis.fitting import Begun, Fitted, finish_all
from multilayer.diagnosis.unknown_cause import law_p_value
from multilayer.inference.low_rank import LowRank
from multilayer.inference.problem import Minimum
from tests.fits.gaussian import Plain, linear

N_DATA = 40


def fitted(residual, z=(), stated=(), errors=None):
    parameters = tuple(SimpleNamespace(nuisance=one) for one in stated)
    minimum = Minimum(np.array(z), 0.0, residual, np.empty((len(residual), len(z))))
    return Fitted(SimpleNamespace(parameters=parameters, effects=()), minimum, errors)


def test_of_the_law_chance_asks_what_it_asks_of_a_uniform_number():
    rng = np.random.default_rng(0)
    errors = LowRank.of(rng.standard_normal((N_DATA, 6)) * np.geomspace(0.1, 30, 6))
    found = [law_p_value(fitted(rng.standard_normal(N_DATA), errors=errors)) for _ in range(2000)]
    # two moments of a weighted sum: all but the shape far out
    assert kstest(found, "uniform").statistic < 0.05


def test_of_the_law_a_bent_one_asks_too_much():
    rng = np.random.default_rng(1)
    basis = 5 * rng.standard_normal((N_DATA, 3))
    errors = LowRank.of(basis)
    for amount, allowed in ((1.0, True), (8.0, False)):
        seen = errors.whitened(basis @ np.full(3, amount) + rng.standard_normal(N_DATA))
        assert (law_p_value(fitted(seen, errors=errors)) > 1e-3) == allowed


def test_without_errors_of_a_law_nothing_is_asked_of_it():
    assert law_p_value(fitted(np.ones(N_DATA))) == 1.0


class Bare(Plain):
    """A hypothesis without effects."""

    effects = ()


def test_fits_far_behind_are_given_up_and_others_finished():
    rng = np.random.default_rng(2)
    slopes = rng.standard_normal((N_DATA, 2))

    def begun(off):
        same = linear(slopes, off + slopes @ np.ones(2))
        hypothesis = Bare(same.function, same.parameters)
        return Begun.at(hypothesis, np.zeros((1, 2)))

    near, far = begun(0.1), begun(30.0)
    found = finish_all({"near": near, "far": far})
    assert list(found) == ["near", "far"]
    assert np.array_equal(found["far"].minimum.z, far.starts[0])
    assert found["near"].minimum.cost < near.given_up.minimum.cost
    assert found["near"].log_evidence > found["far"].log_evidence
    # alone it is the best there is, and is finished
    alone = finish_all({"far": far})
    assert alone["far"].minimum.cost < far.given_up.minimum.cost
