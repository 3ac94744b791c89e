"""Many descents at once, and the last steps of one."""

import numpy as np
import pytest

from multilayer.inference.least_squares import descend, minimise, minimise_bfgs
from tests.fits.gaussian import Plain, linear, standard


def test_of_a_linear_problem_every_start_ends_at_its_solution():
    rng = np.random.default_rng(0)
    slopes, measured = rng.standard_normal((20, 3)), rng.standard_normal(20)
    problem = linear(slopes, measured)
    solution = np.linalg.solve(slopes.T @ slopes + np.eye(3), slopes.T @ measured)
    points, costs = descend(problem.residual, 3 * rng.standard_normal((7, 3)), 30, 1e-12)
    np.testing.assert_allclose(points, np.broadcast_to(solution, (7, 3)), atol=1e-5)
    expected = np.sum((slopes @ solution - measured) ** 2) + solution @ solution
    np.testing.assert_allclose(costs, expected, rtol=1e-8)


def wells(z):
    """Two valleys, the one at z = -2 deeper than that at 2; no response beyond 5."""
    with np.errstate(invalid="ignore"):
        edge = np.sqrt(5 - np.abs(z[..., 0])) - np.sqrt(5 - np.abs(z[..., 0]))
    return np.stack([z[..., 0] ** 2 - 4 + edge, 0.1 * (z[..., 0] + 2), 3 * z[..., 1] - z[..., 0]], axis=-1)


def test_starts_stay_in_their_valleys_and_the_cost_never_rises():
    starts = np.array([[3.0, 0.0], [-1.0, 2.0], [0.5, 0.0], [6.0, 0.0]])
    before = np.sum(wells(starts) ** 2, axis=-1) + np.sum(starts**2, axis=-1)
    points, costs = descend(wells, starts, 40)
    assert np.all(costs[:3] <= before[:3])
    assert np.isinf(costs[3])  # no response, and none is made up
    np.testing.assert_array_equal(points[3], starts[3])
    assert points[0, 0] > 1.5
    assert points[1, 0] < -1.5
    problem = Plain(wells, standard(2))
    for start, cost in zip(starts[:2], costs[:2], strict=True):
        assert cost == pytest.approx(minimise(problem, start).cost, rel=2e-3)


def test_a_bent_valley_is_followed_to_its_lowest_point():
    """Rosenbrock's, with a misfit that stays: Gauss and Newton's curvature is not that of the cost."""

    def bent(z):
        x, y = z[..., 0], z[..., 1]
        return np.stack([30 * (y - x**2), 2 - x, 5 + x * y], axis=-1)

    problem = Plain(bent, standard(2))
    found = minimise_bfgs(problem, np.array([0.3, 0.2]))
    assert found.converged
    near = found.z + np.stack(np.meshgrid(*[np.linspace(-0.2, 0.2, 401)] * 2), axis=-1)
    costs = np.sum(bent(near) ** 2, axis=-1) + np.sum(near**2, axis=-1)
    assert found.cost <= costs.min() + 1e-6
