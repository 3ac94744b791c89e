"""Errors of the effects' laws in evidence and intervals, against closed forms."""

import numpy as np
import pytest

from multilayer.diagnosis.diagnose import fit_nominal
from multilayer.diagnosis.effects import EFFECTS
from multilayer.diagnosis.fitting import Fitted, fit
from multilayer.diagnosis.model_discrepancy import WithLawErrors, law_basis
from multilayer.inference.least_squares import minimise, minimise_bfgs
from multilayer.inference.low_rank import LowRank, WithModelErrors
from multilayer.inference.problem import Minimum
from multilayer.testing.benches import joint_bench
from tests.fits.gaussian import linear
from tests.fits.test_joint import campaign_and_signals


def basis():
    return np.random.default_rng(1).standard_normal((30, 7)) * np.geomspace(0.1, 50, 7)


def test_whitening_is_the_inverse_root_of_the_covariance():
    errors = LowRank.of(basis())
    covariance = np.eye(30) + basis() @ basis().T
    root = errors.whitened(np.eye(30))
    np.testing.assert_allclose(root @ covariance @ root, np.eye(30), atol=1e-9)
    assert errors.log_determinant == pytest.approx(np.linalg.slogdet(covariance)[1])


def test_errors_that_say_the_same_count_once():
    """Columns may be as large as they like, more than there are data, and depend on each other."""
    rng = np.random.default_rng(3)
    columns = rng.standard_normal((12, 4)) * [1e4, 300.0, 2.0, 0.2] @ rng.standard_normal((4, 20))
    errors, sizes = LowRank.of(columns), np.linalg.svd(columns, compute_uv=False)[:4]
    assert errors.log_determinant == pytest.approx(np.log1p(sizes**2).sum(), abs=1e-3)
    assert len(errors.sizes) == 4
    assert LowRank.of(np.empty((12, 0))).log_determinant == 0.0


def test_evidence_is_that_of_the_marginal_distribution():
    rng = np.random.default_rng(2)
    slopes, measured = rng.standard_normal((30, 3)), 3 * rng.standard_normal(30)
    errors = LowRank.of(basis())
    soft = WithModelErrors(linear(slopes, measured), errors)
    fitted = Fitted(soft.problem, minimise(soft, np.zeros(3)), errors)
    covariance = np.eye(30) + basis() @ basis().T + slopes @ slopes.T
    truth = -0.5 * (measured @ np.linalg.solve(covariance, measured) + np.linalg.slogdet(covariance)[1])
    assert fitted.log_evidence == pytest.approx(truth, rel=1e-6)


def test_errors_are_as_large_as_the_effect_and_its_law_is_uncertain():
    joint = joint_bench()
    effect = EFFECTS["channel_gain"]()
    hypothesis = joint.with_effects(effect)
    gain = float(effect.parameters[0].prior.coordinate(0.04))
    z = np.concatenate([np.zeros(len(joint.parameters)), [gain]])
    columns = law_basis(hypothesis, z)
    spread = np.sqrt(np.sum(columns**2, axis=1))
    alone = hypothesis.residual(z) - joint.residual(z[:-1])
    # a gain changes ln(ratio) by ln(1.04) everywhere: a share of that, in either part
    assert np.sqrt(np.mean(spread**2)) == pytest.approx(effect.law_error * np.sqrt(2 * np.mean(alone**2)), rel=0.3)
    assert np.max(np.abs(law_basis(hypothesis, np.zeros(z.size)))) < 1e-9


def test_what_acts_on_the_sample_is_wrong_as_a_modulus_is():
    joint = joint_bench()
    effect = EFFECTS["preload"]()
    hypothesis = joint.with_effects(effect)
    z = np.concatenate([np.zeros(len(joint.parameters)), [float(effect.parameters[0].prior.coordinate(1e-5))]])
    stiffening = [1e-5 * setting.static_stress for setting in hypothesis.settings]
    slopes = joint.modulus_slopes(z[:-1])
    for change, slope, relative in zip(hypothesis.law_change(0, z), slopes, stiffening, strict=True):
        np.testing.assert_allclose(change, relative * slope, rtol=0.02)


def test_a_size_beyond_the_bounds_of_its_prior_has_an_interval():
    joint = joint_bench()
    hypothesis = joint.with_effects(EFFECTS["skin"]())
    for far in (-60.0, 60.0):
        z = np.concatenate([np.zeros(len(joint.parameters)), [0.0, far]])
        found = Fitted(hypothesis, Minimum(z, np.zeros(3), np.zeros((3, len(z)))))
        value, low, high = found.interval("skin.ratio")
        assert 1 <= low <= value <= high < 100.001


@pytest.mark.parametrize(("exact", "error"), [(True, 2e-4), (False, 2e-3)])
@pytest.mark.parametrize("names", [("channel_gain",), ("rocking",), ("skin", "channel_delay"), ("preload", "adhesive")])
def test_the_slope_of_what_is_minimised_is_that_of_the_evidence(names, exact, error):
    """Minus twice the log density, errors of laws integrated out, by its own differences; nearly so in coarse fits."""
    joint = joint_bench()
    hypothesis = joint.with_effects(*(EFFECTS[name]() for name in names))
    embedded = WithLawErrors(hypothesis, exact=exact)
    z = 0.3 * np.random.default_rng(4).standard_normal(len(hypothesis.parameters))

    def density(at):
        basis, residual = law_basis(hypothesis, at), hypothesis.residual(at)
        covariance = np.eye(len(residual)) + basis @ basis.T
        return residual @ np.linalg.solve(covariance, residual) + np.linalg.slogdet(covariance)[1]

    values, slopes = embedded.linearised(z)
    assert values @ values == pytest.approx(density(z), rel=1e-8)
    steps = 3e-5 * np.eye(len(z))
    expected = np.array([(density(z + step) - density(z - step)) / 6e-5 for step in steps])
    np.testing.assert_allclose(2 * slopes.T @ values, expected, atol=error * np.abs(expected).max())


def test_where_errors_of_a_law_are_taken_does_not_matter():
    """From points about it a fit ends at one minimum, and there nothing moves any more."""
    nominal, _ = fit_nominal(*campaign_and_signals(gain=1.05))
    hypothesis = nominal.hypothesis.with_effects(EFFECTS["channel_gain"]())
    embedded, near = WithLawErrors(hypothesis), fit(hypothesis, nominal.minimum.z).minimum
    rng = np.random.default_rng(5)
    spread = np.linalg.cholesky(near.covariance)
    ends = [minimise_bfgs(embedded, near.z + spread @ rng.standard_normal(len(near.z))) for _ in range(3)]
    for end in ends:
        assert end.converged
        assert end.cost == pytest.approx(ends[0].cost, abs=1e-3)
        np.testing.assert_allclose(end.z[-1], ends[0].z[-1], atol=2e-2 * np.sqrt(ends[0].covariance[-1, -1]))
