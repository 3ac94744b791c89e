"""Predictions of held-out data, and their covariance."""

from dataclasses import replace

import numpy as np
import pytest

from multilayer.diagnosis.cross_validation import cross_validate
from multilayer.diagnosis.effects.rocking import Rocking
from multilayer.diagnosis.fitting import Fitted, fit, minimise_scaled
from multilayer.inference.low_rank import prediction_root
from tests.diagnosis.test_places import measured


def rocking(configurations):
    """Return the nominal fit and one with the rocking mode at 700 Hz that acts in the data."""
    without = measured()
    nominal, z = without.hypothesis, without.minimum.z
    effect = [p.prior.coordinate(v) for p, v in zip(Rocking.parameters, (0.03, 700.0, 0.1), strict=True)]
    known = nominal.with_effects(Rocking())
    moved = zip(known.differences(np.concatenate([z, effect])), nominal.differences(z), strict=True)
    data = [replace(d, ratio=d.ratio * np.exp(a - b)) for d, (a, b) in zip(nominal.data, moved, strict=True)]
    nominal, known = (each.with_data(data[:configurations]) for each in (nominal, known))
    z = z[: len(nominal.nominal_parameters)]
    return fit(nominal, z), Fitted(known, minimise_scaled(known, np.concatenate([z, effect])))


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
