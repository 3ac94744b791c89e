"""Coordinates in which the valley of laws that fit alike is straight: what they are, and what descents gain by them."""

import numpy as np
import pytest

from multilayer.diagnosis.fitting import minimise_scaled
from multilayer.diagnosis.places import PLACES
from multilayer.experiments.places import DrawnLaw
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.modulus_at import AmountAt, ModulusAt
from multilayer.fits.joint.search import law_space
from multilayer.inference.priors import Parameter, Prior, Priors
from multilayer.testing.benches import soft_sample
from tests.diagnosis.rigs import F, measured_with

LAWS = ["zener", "fractional_zener", "havriliak_negami", "loss_factor"]
KINDS = [AmountAt, ModulusAt]
E = np.full(F.size, 3e5 * (1 + 0.3j))


def coordinates(kind, law, seed=0):
    """Return coordinates around a point of a law's space, and the point."""
    space = law_space(law, F, E)
    boxes = zip(space.coordinates, space.low, space.high, strict=True)
    uniform = [Parameter(name=name, prior=Prior(uniform=(float(low), float(high)))) for name, low, high in boxes]
    # what only just rises has a hard end: away from there
    inside = space.first(F, E) - 0.5 * np.array(["/" in name or "*" in name for name in space.coordinates])
    near = np.array([p.prior.coordinate(x) for p, x in zip(uniform, inside, strict=True)])
    near = near + 0.1 * np.random.default_rng(seed).standard_normal(near.size)
    return kind(space, Priors.of(uniform), 700.0, near), near


@pytest.mark.parametrize("law", LAWS)
def test_one_entry_scales_the_modulus(law):
    other, near = coordinates(AmountAt, law)
    point = other.priors.values(near)
    more = point + 0.1 * np.eye(len(point))[other.space.scale]
    np.testing.assert_allclose(other.space.modulus(more, F), np.exp(0.1) * other.space.modulus(point, F), rtol=1e-12)


@pytest.mark.parametrize(("law", "elements"), [("kelvin_voigt", None), ("complex", None), ("maxwell", 3)])
def test_of_some_laws_none_does(law, elements):
    assert law_space(law, F, E, elements).scale is None


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("seed", range(4))
def test_points_around_are_found_again(kind, law, seed):
    other, near = coordinates(kind, law, seed)
    points = near + 0.005 * np.random.default_rng(1).standard_normal((50, near.size))
    w, scale = other.of(points), other.space.scale
    np.testing.assert_allclose(other.back(w), points, atol=1e-7)
    amount = np.log(np.abs(other.space.modulus(other.priors.values(points), np.array([700.0]))[:, 0]))
    np.testing.assert_allclose(w[:, scale] - w[0, scale], amount - amount[0], atol=1e-12)
    step = 1e-5 * np.eye(near.size)
    slopes = ((other.of(near + step) - other.of(near - step)) / 2e-5).T
    np.testing.assert_allclose(other.slopes(near), slopes, rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("kind", KINDS)
def test_a_modulus_out_of_reach_has_no_coordinates(kind):
    other, near = coordinates(kind, "fractional_zener")
    w = other.of(near)
    w[other.space.scale] += 50.0
    assert np.isnan(other.back(w)[other.space.scale])


def placed(name):
    """Return a problem with a law that is drawn at a place, of data without one, and the soft sample's coordinates."""
    whole = measured_with((), ()).hypothesis
    one, place = whole.with_data(whole.data[:1]), PLACES[name]()
    law = DrawnLaw.at(place, F, 0.05 * place.scale(one.settings, 3e5))
    return one.with_effects(law), np.concatenate([soft_sample(one), np.zeros(len(law.parameters))])


def along(problem, z, shift):
    """Return coordinates with another relaxation time and the same modulus in the middle of the band."""
    n = len(problem.law_parameters)
    other = problem.reparameterisation(z)
    return np.concatenate([other.back(other.of(z[:n]) + shift * np.eye(n)[2]), z[n:]])


class AlongAxes(CampaignProblem):
    """A campaign's problem without other coordinates."""

    def reparameterisation(self, z, *, far=False):
        return None


def along_axes(problem):
    return AlongAxes(**{name: getattr(problem, name) for name in problem.__dataclass_fields__})


def test_derivatives_along_the_valley_are_right():
    """Across it residuals change 1e5 times as much: differences along the axes lose what is along it."""
    problem, z = placed("reading")
    h, (_, slopes) = 1e-4, problem.linearised(z)
    ahead, behind = along(problem, z, h), along(problem, z, -h)
    expected = (problem.residual(ahead) - problem.residual(behind)) / (2 * h)
    found = slopes @ (ahead - behind) / (2 * h)
    assert np.linalg.norm(slopes, axis=0).max() > 30 * np.linalg.norm(expected)
    assert np.linalg.norm(found - expected) < 1e-3 * np.linalg.norm(expected)


@pytest.mark.parametrize("name", ["reading", "top_plate", "faces"])
def test_descents_from_all_along_the_valley_end_in_the_same_minimum(name):
    problem, z = placed(name)
    starts = [along(problem, z, shift) for shift in (-0.1, 0.0, 0.1)]
    ends = [minimise_scaled(problem, start, 100) for start in starts]
    assert all(end.converged for end in ends)
    costs = [end.cost for end in ends]
    assert max(costs) - min(costs) < 2e-3
    others = [minimise_scaled(along_axes(problem), start, 100) for start in starts]
    assert not any(other.converged for other in others)
    assert all(0.05 < other.cost - min(costs) < 1.0 for other in others)


@pytest.mark.parametrize("seed", range(6))
def test_no_descent_ends_higher_than_along_the_axes(seed):
    problem = measured_with((), ()).hypothesis
    start = np.zeros(len(problem.parameters))
    start[:4] = soft_sample(problem)[:4] + 0.2 * np.random.default_rng(seed).standard_normal(4)
    end, other = (minimise_scaled(one, start) for one in (problem, along_axes(problem)))
    assert end.cost < other.cost + 1e-2


def test_coordinates_that_hold_far_are_of_the_amount_alone():
    problem, z = placed("reading")
    assert type(problem.reparameterisation(z)) is ModulusAt
    assert type(problem.reparameterisation(z, far=True)) is AmountAt
