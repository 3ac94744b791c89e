"""Predictions of held-out data, and their covariance."""

from types import SimpleNamespace

import numpy as np
import pytest

from multilayer.diagnosis.cross_validation import cross_validate, folds
from multilayer.inference.low_rank import prediction_root
from tests.diagnosis.rigs import rocking


class Bursts:
    def __init__(self, centres):
        self.centres = [*centres]

    def part(self, chosen):
        return Bursts(self.centres[i] for i in chosen)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_predictions_have_the_posterior_covariance(size):
    rng = np.random.default_rng(5)
    slopes, fitted = rng.standard_normal((7, 4)), size * rng.standard_normal((9, 4))
    columns = prediction_root(slopes, fitted)
    covariance = slopes @ np.linalg.inv(np.eye(4) + fitted.T @ fitted) @ slopes.T
    assert np.allclose(columns @ columns.T, covariance, rtol=1e-9, atol=1e-12 * np.abs(covariance).max())


def test_the_prior_is_kept_where_the_square_of_the_slopes_has_lost_it():
    """Two unknowns that the data know only together, to 1e-12: their difference is the prior's."""
    fitted = 1e12 * np.array([[1.0, 1.0], [1.0, 1.0]])
    columns = prediction_root(np.eye(2), fitted)
    apart = np.array([1.0, -1.0]) / np.sqrt(2)
    assert apart @ columns @ columns.T @ apart == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("n", "expected"), [(3, []), (4, [0, 3]), *((n, [*range(n)]) for n in (5, 6, 7, 15))]
)  # of four those in the middle would leave one
def test_of_a_single_configuration_bursts_are_left_out_once_without_their_neighbours(n, expected):
    left_out = []
    text, pairs = folds(SimpleNamespace(data=[Bursts(range(n))], blocks=5))
    for (kept,), (block,) in pairs:
        left_out += block.centres
        assert len(kept.centres) > 1
        assert min(abs(one - other) for one in block.centres for other in kept.centres) > 1
    assert left_out == expected
    assert ("nothing" in text) == (not expected)


@pytest.mark.parametrize("configurations", [1, 3])
def test_what_only_held_out_data_show_is_no_objection(configurations):
    """A sharp resonance, in frequencies that are left out at once where there is a single configuration."""
    nominal, known = rocking(configurations)
    (shrinkage,) = cross_validate(nominal, [known])
    assert known.minimum.cost_per_datum < 1.5
    assert shrinkage.before > 20
    assert shrinkage.share > 0.98
