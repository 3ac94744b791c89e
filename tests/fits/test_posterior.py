"""Posteriors: Laplace, profile and nested sampling against closed forms and quadrature."""

import json
import sys

import numpy as np
import pytest
from scipy.stats import norm, truncnorm

from multilayer.errors import InputError
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.experiments.two_plate.ratios import configuration_data
from multilayer.fits.burst.fit import burst_problems
from multilayer.fits.settings import FitSettings
from multilayer.inference.least_squares import search
from multilayer.inference.nested_sampling import nested
from multilayer.inference.posterior import Posterior, laplace
from multilayer.inference.priors import Prior
from multilayer.inference.profile import profile_likelihood
from multilayer.inference.summary import summarise
from multilayer.measurements.description import Uncertainty
from multilayer.media.laws.parameters import LawSpace
from tests.fits.gaussian import Plain, linear, linear_evidence, parameters, quadrature, quantiles, standard
from validation.laboratories import laboratories, simulate

SEEN = np.array([[4.0, 1.0, 0.0], [0.0, 3.0, -2.0], [1.0, 0.0, 0.2], [2.0, 2.0, 0.0]])
MEASURED = np.array([3.0, -4.0, 0.5, 1.0])


def banana() -> Plain:
    """A narrow curved valley; across it, given the first coordinate, all is Gaussian."""
    return Plain(lambda z: np.stack([z[..., 0] - 0.5, (z[..., 1] - 0.6 * z[..., 0] ** 2) / 0.1], axis=-1), standard(2))


def two_humps() -> Plain:
    return Plain(lambda z: np.stack([(z[..., 0] ** 2 - 1) / 0.15, z[..., 1]], axis=-1), standard(2))


def pushed_out() -> Plain:
    """A share that is measured as 1.1 with a standard deviation of 0.1, and cannot exceed 1."""
    known = parameters(Prior(uniform=(0.0, 1.0)))
    return Plain(lambda z: (known[0].prior.value(z) - 1.1) / 0.1, known)


def _check_linear(posterior: Posterior, rel: float) -> None:
    covariance = np.linalg.inv(SEEN.T @ SEEN + np.eye(3))
    mean, spread = covariance @ SEEN.T @ MEASURED, np.sqrt(np.diag(covariance))
    assert posterior.covariance == pytest.approx(covariance, rel=rel, abs=rel * covariance.max())
    for i, name in enumerate("abc"):
        for p in (0.68, 0.9):
            ends = norm.ppf([0.5 - p / 2, 0.5 + p / 2], mean[i], spread[i])
            assert posterior.interval(name, p) == pytest.approx(ends, abs=rel * spread[i])
        assert posterior.median(name) == pytest.approx(mean[i], abs=rel * spread[i])


def test_laplace_of_a_linear_problem_is_exact() -> None:
    problem = linear(SEEN, MEASURED)
    posterior = laplace(problem, search(problem, n_candidates=8, n_best=1))
    _check_linear(posterior, 1e-5)
    assert posterior.log_evidence == pytest.approx(linear_evidence(SEEN, MEASURED), abs=1e-8)
    assert posterior.log_evidence_error < 1e-6
    assert posterior.effective_share == pytest.approx(1.0)


def test_the_profile_of_a_linear_problem_is_exact() -> None:
    problem = linear(SEEN, MEASURED)
    (minimum,) = search(problem, n_candidates=8, n_best=1)
    profile = profile_likelihood(problem, minimum, "b", draws=20000)
    _check_linear(profile, 0.05)
    exact = laplace(problem, minimum)
    assert profile.log_evidence == pytest.approx(exact.log_evidence, abs=2e-3)
    assert profile.interval("b", 0.9) == pytest.approx(exact.interval("b", 0.9), abs=2e-3)
    assert profile.confidence(0.9) == pytest.approx(exact.interval("b", 0.9), abs=2e-3)
    assert profile.open_ends == (False, False)
    assert profile.best == pytest.approx(exact.median("b"), abs=1e-3)


def test_nested_sampling_of_a_linear_problem() -> None:
    pytest.importorskip("dynesty")
    told: list[str] = []
    problem = linear(SEEN, MEASURED)
    posterior = nested(problem, n_live=200, at_once=1, tell=told.append)
    assert posterior.log_evidence == pytest.approx(linear_evidence(SEEN, MEASURED), abs=0.3)
    assert 0 < posterior.log_evidence_error < 0.2
    _check_linear(posterior, 0.15)
    assert told
    assert "ln(evidence)" in told[-1]


def test_intervals_are_in_the_parameters_units() -> None:
    problem = linear([[3.0]], np.array([1.0]), Prior(lognormal=(2e4, 0.5)))
    posterior = laplace(problem, search(problem, n_candidates=8, n_best=1))
    ends = 2e4 * np.exp(0.5 * norm.ppf([0.05, 0.95], 0.3, np.sqrt(0.1)))
    assert posterior.interval("a", 0.9) == pytest.approx(ends)


def test_a_band_is_an_interval_at_every_point() -> None:
    problem = linear(SEEN, MEASURED)
    posterior = laplace(problem, search(problem, n_candidates=8, n_best=1), draws=20000)
    at = np.linspace(0, 1, 5)
    band = posterior.band(lambda z: z[:, :1] + z[:, 1:2] * at, 0.9)
    covariance = np.linalg.inv(SEEN.T @ SEEN + np.eye(3))
    mean = covariance @ SEEN.T @ MEASURED
    along = np.stack([np.ones(5), at, np.zeros(5)], axis=-1)
    spread = np.sqrt(np.einsum("ki,ij,kj->k", along, covariance, along))
    assert band.median == pytest.approx(along @ mean, abs=0.03 * spread.max())
    assert band.high - band.low == pytest.approx(2 * norm.ppf(0.95) * spread, rel=0.03)
    with pytest.raises(InputError, match="real part"):
        posterior.band(lambda z: z + 1j)


def test_laplace_knows_when_a_valley_is_curved() -> None:
    problem = banana()
    truth, grid, density = quadrature(problem)
    minima = search(problem, n_candidates=16, n_best=2)
    posterior = laplace(problem, minima, checked=4000)
    assert posterior.effective_share < 0.5
    assert abs(posterior.log_evidence - truth) < 2 * posterior.log_evidence_error
    profile = profile_likelihood(problem, minima[0], "a", draws=20000)
    assert profile.log_evidence == pytest.approx(truth, abs=0.01)
    assert profile.interval("a", 0.9) == pytest.approx(quantiles(grid, density[0], 0.05, 0.95), abs=0.02)
    # what is curved shows in the samples across the profile, too
    assert profile.interval("b", 0.9) == pytest.approx(quantiles(grid, density[1], 0.05, 0.95), abs=0.05)


def test_laplaces_band_follows_the_tangent() -> None:
    """Across the valley all is known to 0.1, however far it bends along it."""
    problem = banana()
    (minimum,) = search(problem, n_candidates=16, n_best=1)
    band = laplace(problem, minimum, checked=0).band(lambda z: z[:, 1:] - 0.6 * z[:, :1] ** 2, 0.9)
    assert band.high - band.low == pytest.approx(2 * norm.ppf(0.95) * 0.1, rel=0.05)


def test_nested_sampling_of_a_curved_valley() -> None:
    pytest.importorskip("dynesty")
    problem = banana()
    truth, grid, density = quadrature(problem)
    posterior = nested(problem, n_live=200, at_once=1)
    assert posterior.log_evidence == pytest.approx(truth, abs=0.3)
    assert posterior.interval("b", 0.9) == pytest.approx(quantiles(grid, density[1], 0.05, 0.95), abs=0.12)


def test_several_minima_are_weighted_by_evidence() -> None:
    problem = two_humps()
    minima = search(problem, n_candidates=32, n_best=6)
    truth, grid, density = quadrature(problem)
    posterior = laplace(problem, minima)
    assert posterior.weights == pytest.approx([0.5, 0.5], abs=1e-3)
    assert posterior.log_evidence == pytest.approx(truth, abs=0.05)
    assert posterior.interval("a", 0.9) == pytest.approx(quantiles(grid, density[0], 0.05, 0.95), abs=0.02)
    assert posterior.covariance[0, 0] == pytest.approx(1.0, abs=0.05)
    band = posterior.band(lambda z: z[:, :1], 0.9)
    assert [band.low[0], band.high[0]] == pytest.approx(posterior.interval("a", 0.9), abs=0.02)
    # the same hump found twice does not count twice
    again = laplace(problem, [*minima, minima[0]])
    assert again.log_evidence == posterior.log_evidence


def test_profiles_hold_every_mode() -> None:
    """Of unequal humps, far apart along one parameter and hardly so along the other."""
    problem = Plain(
        lambda z: np.stack([(z[..., 0] ** 2 - 1) / 0.15, z[..., 0] / 2 + 0.5, 2 * (z[..., 1] - z[..., 0])], axis=-1),
        standard(2),
    )
    truth, grid, density = quadrature(problem)
    minima = search(problem, n_candidates=32, n_best=6)
    summary = summarise(problem, minima, "profile")
    assert summary.posterior.log_evidence == pytest.approx(truth, abs=0.02)
    for number, finding in enumerate(summary.identifiability.findings):
        assert finding.posterior_90 == pytest.approx(quantiles(grid, density[number], 0.05, 0.95), abs=0.05)
        assert finding.median == pytest.approx(quantiles(grid, density[number], 0.5)[0], abs=0.05)
    # the same hump found twice does not count twice
    again = summarise(problem, [*minima, minima[0]], "profile")
    assert again.posterior.log_evidence == summary.posterior.log_evidence


def test_a_profile_that_leads_into_another_mode_counts_none_twice() -> None:
    problem = Plain(lambda z: np.stack([(z[..., 0] ** 2 - 1) / 0.4, 2 * z[..., 1]], axis=-1), standard(2))
    truth, grid, density = quadrature(problem)
    minima = search(problem, n_candidates=32, n_best=6)
    assert len(laplace(problem, minima, checked=0).weights) == 2
    summary = summarise(problem, minima, "profile")
    assert summary.posterior.log_evidence == pytest.approx(truth, abs=0.02)
    for number, finding in enumerate(summary.identifiability.findings):
        assert finding.posterior_90 == pytest.approx(quantiles(grid, density[number], 0.05, 0.95), abs=0.05)


def test_a_direction_the_data_do_not_see_keeps_its_prior() -> None:
    problem = linear([[5.0, 0.0]], np.array([2.0]), Prior(normal=(0, 1)), Prior(uniform=(10.0, 20.0)))
    (minimum,) = search(problem, n_candidates=8, n_best=1)
    for posterior in (laplace(problem, minimum), profile_likelihood(problem, minimum, "b")):
        assert posterior.interval("b", 0.9) == pytest.approx((10.5, 19.5), abs=0.02)
    assert profile_likelihood(problem, minimum, "b").open_ends == (True, True)


def test_a_bound_cuts_the_posterior() -> None:
    problem = pushed_out()
    (minimum,) = search(problem, n_candidates=8, n_best=2)
    profile = profile_likelihood(problem, minimum, 0)
    exact = truncnorm((0 - 1.1) / 0.1, (1 - 1.1) / 0.1, 1.1, 0.1)
    assert profile.interval("a", 0.9) == pytest.approx(exact.ppf([0.05, 0.95]), abs=2e-3)
    assert profile.log_evidence == pytest.approx(
        np.log(0.1 * np.sqrt(2 * np.pi)) + np.log(norm.cdf(-1.0) - norm.cdf(-11.0)), abs=0.01
    )  # fmt: skip
    assert profile.open_ends == (False, True)
    assert laplace(problem, minimum).interval("a", 0.9)[1] < 1


def test_an_end_that_the_gaussian_misplaces_is_taken_from_weighted_points() -> None:
    """A cliff on one side that the curvature at the minimum does not show: few draws are wasted on it."""
    problem = Plain(lambda z: 5 * np.logaddexp(0.0, -20 * (z + 1)), parameters(Prior(normal=(0.0, 1.0))))
    (minimum,) = search(problem, n_candidates=8, n_best=1)
    posterior = laplace(problem, minimum)
    assert posterior.effective_share > 0.8
    grid = np.linspace(-6.0, 6.0, 4001)
    density = np.exp(-0.5 * problem.residual(grid[:, None])[:, 0] ** 2 - 0.5 * grid**2)
    exact = quantiles(grid, density, 0.05, 0.95)
    assert exact[0] > -1.2  # that of the Gaussian is -1.64
    assert posterior.interval("a", 0.9) == pytest.approx(exact, abs=0.25)
    assert posterior.interval("a", 0.9)[0] == pytest.approx(exact[0], abs=0.1)
    assert laplace(problem, minimum, checked=0).interval("a", 0.9)[0] < -1.5


def test_gaussian_posteriors_keep_their_exact_ends() -> None:
    for seed in range(20):
        problem = linear(SEEN, MEASURED)
        (minimum,) = search(problem, n_candidates=8, n_best=1)
        assert not laplace(problem, minimum, seed=seed).marginals


def test_what_is_said_of_mistakes() -> None:
    problem = linear(SEEN, MEASURED)
    (minimum,) = search(problem, n_candidates=8, n_best=1)
    posterior = laplace(problem, minimum, checked=0)
    with pytest.raises(InputError, match="there is no parameter 'd'"):
        posterior.interval("d")
    with pytest.raises(InputError, match="between 0 and 1"):
        posterior.interval("a", 90)
    with pytest.raises(InputError, match="no minimum"):
        laplace(problem, [])
    with pytest.raises(InputError, match="there is no parameter 3"):
        profile_likelihood(problem, minimum, 3)


def test_json() -> None:
    problem = linear(SEEN, MEASURED)
    (minimum,) = search(problem, n_candidates=8, n_best=1)
    plain = json.loads(json.dumps(laplace(problem, minimum, checked=0).to_dict()))
    assert plain["log_evidence_error"] is None
    assert [p["name"] for p in plain["parameters"]] == ["a", "b", "c"]
    low, high = plain["parameters"][0]["interval_90"]
    assert low < plain["parameters"][0]["median"] < high
    profile = json.loads(json.dumps(profile_likelihood(problem, minimum, 0).to_dict()))["profile"]
    assert profile["name"] == "a"
    assert min(profile["cost"]) == pytest.approx(minimum.cost)


def test_without_dynesty_the_message_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dynesty", None)
    with pytest.raises(InputError, match=r"multilayer\[bayes\]"):
        nested(linear(SEEN, MEASURED))


def test_nested_sampling_repeats_with_its_seed() -> None:
    pytest.importorskip("dynesty")
    problem = linear(SEEN, MEASURED)
    first, again, other = (nested(problem, n_live=60, at_once=8, remaining=1.0, seed=s) for s in (1, 1, 2))
    assert first.log_evidence == again.log_evidence
    assert np.array_equal(first.samples, again.samples)
    assert first.log_evidence != other.log_evidence


def test_nested_sampling_asks_for_many_points_at_once() -> None:
    pytest.importorskip("dynesty")
    sizes: list[int] = []

    def residual(z: np.ndarray) -> np.ndarray:
        sizes.append(len(z))
        return z @ SEEN.T - MEASURED

    nested(Plain(residual, standard(3)), n_live=60, at_once=8, remaining=1.0)
    assert np.mean(sizes) > 3
    assert max(sizes) == 8


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_a_model_that_fails_ends_nested_sampling(capsys: pytest.CaptureFixture[str]) -> None:
    pytest.importorskip("dynesty")

    def residual(z: np.ndarray) -> np.ndarray:
        raise ZeroDivisionError("the model")

    with pytest.raises(ZeroDivisionError, match="the model"):
        nested(Plain(residual, standard(3)), n_live=60, at_once=8)
    capsys.readouterr()


def joint_subset() -> CampaignProblem:
    """Two bursts of each of two mountings of a simulated campaign, few nuisances, a narrow prior of the law."""
    made = simulate(0, 0.002, laboratories(4)[0])
    bursts = [problem.data for problem in burst_problems(made.campaign, made.recordings, FitSettings(), None)]
    campaign = made.campaign.model_copy(update={"configurations": made.campaign.configurations[:2]})
    data = configuration_data(campaign, [b for b in bursts if b.frequency < 600])
    rigs = {c.name: PlaneWaveRig.of(campaign, c) for c in campaign.configurations}
    names = ("relaxed_modulus", "unrelaxed_modulus", "relaxation_time", "order")
    bounds = {name: (getattr(made.law, name) / 1.5, getattr(made.law, name) * 1.5) for name in names}
    f = np.array([150.0, 500.0])
    space = LawSpace.of(made.law, {}, bounds, f, made.law(f))
    return CampaignProblem(campaign, data, rigs, space, Uncertainty(channel_gain=0.003, thickness=5e-5), 0.002)


@pytest.mark.slow
def test_evidence_of_a_joint_problem_by_three_ways() -> None:
    pytest.importorskip("dynesty")
    problem = joint_subset()
    minima = search(problem, n_candidates=32, n_best=3)
    posterior = laplace(problem, minima)
    sampled = nested(problem, n_live=300)  # of 100 points the ends of intervals scatter by a third of what is allowed
    apart = sampled.log_evidence - posterior.log_evidence
    assert abs(apart) < 3 * sampled.log_evidence_error + posterior.log_evidence_error
    profile = profile_likelihood(problem, minima[0], "ln order")
    assert profile.log_evidence == pytest.approx(posterior.log_evidence, abs=0.1 + posterior.log_evidence_error)
    for name in ("ln relaxed_modulus", "ln order"):
        low, high = posterior.interval(name, 0.9)
        assert sampled.interval(name, 0.9) == pytest.approx((low, high), abs=0.25 * (high - low))


@pytest.mark.parametrize("at", [1.0, 2.0])
def test_the_profile_of_what_rises_at_once_stays_before_it(at: float) -> None:
    """A standard normal value but for a wall: the cost is some 1 at one point of a walk, and hundreds at the next."""

    def wall(z: np.ndarray) -> np.ndarray:
        return 2.0 * np.logaddexp(0, (z - at) / 0.02)

    problem = Plain(lambda z: wall(z[..., :1]), standard(1))
    minima = search(problem, n_candidates=8, n_best=1)
    profile = profile_likelihood(problem, minima[0], 0, draws=20000)
    grid = np.linspace(-6.0, 6.0, 20001)
    density = np.exp(-0.5 * (wall(grid) ** 2 + grid**2))
    name = problem.parameters[0].name
    assert profile.interval(name, 0.9) == pytest.approx(quantiles(grid, density, 0.05, 0.95), abs=0.03)
    assert profile.log_evidence == pytest.approx(np.log(np.sum(density) * 6e-4 / np.sqrt(2 * np.pi)), abs=0.02)
