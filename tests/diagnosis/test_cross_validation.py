"""What held-out data are foretold with."""

import numpy as np
import pytest

from multilayer.diagnosis.cross_validation import _spread


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_spread_is_what_the_known_data_leave_open(size):
    rng = np.random.default_rng(5)
    slopes, known = rng.standard_normal((7, 4)), size * rng.standard_normal((9, 4))
    columns = _spread(slopes, known)
    covariance = slopes @ np.linalg.inv(np.eye(4) + known.T @ known) @ slopes.T
    assert np.allclose(columns @ columns.T, covariance, rtol=1e-9, atol=1e-12 * np.abs(covariance).max())


def test_spread_holds_where_the_square_of_the_slopes_has_lost_the_prior():
    """Two unknowns that the data know only together, to 1e-12: the rest is the prior's."""
    known = 1e12 * np.array([[1.0, 1.0], [1.0, 1.0]])
    columns = _spread(np.eye(2), known)
    apart = np.array([1.0, -1.0]) / np.sqrt(2)
    assert apart @ columns @ columns.T @ apart == pytest.approx(1.0, rel=1e-3)
