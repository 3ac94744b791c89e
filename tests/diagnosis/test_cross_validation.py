"""Predictions of held-out data, and their covariance."""

import numpy as np
import pytest

from multilayer.diagnosis.cross_validation import cross_validate
from multilayer.inference.low_rank import prediction_root
from tests.diagnosis.rigs import rocking


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


@pytest.mark.parametrize("configurations", [1, 3])
def test_what_only_held_out_data_show_is_no_objection(configurations):
    """A sharp resonance, in frequencies that are left out at once where there is a single configuration."""
    nominal, known = rocking(configurations)
    (shrinkage,) = cross_validate(nominal, [known])
    assert known.minimum.cost_per_datum < 1.5
    assert shrinkage.before > 20
    assert shrinkage.share > 0.98
