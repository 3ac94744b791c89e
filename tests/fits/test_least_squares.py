"""Derivatives and descents of least squares, on problems whose answer is known."""

from typing import Literal

import numpy as np
import pytest

from multilayer.inference.derivative import USUAL, central, forward
from multilayer.inference.least_squares import minimise
from tests.fits.gaussian import Plain, standard


def bent(scale: float) -> Plain:
    """Return a narrow valley along y = x^2 whose two coordinates matter differently; its minimum is found by hand."""

    def residual(z: np.ndarray) -> np.ndarray:
        x, y = z[..., 0], z[..., 1]
        return np.stack([scale * (y - x**2), x - 1], axis=-1)

    return Plain(residual, standard(2))


def test_forward_differences_are_central_ones():
    problem, z = bent(30.0), np.array([0.7, -0.2])
    value, slopes = forward(problem.residual, z)
    there, exact = central(problem.residual, z)
    np.testing.assert_array_equal(value, there)
    np.testing.assert_allclose(slopes, exact, atol=1e-4)
    np.testing.assert_allclose(exact, [[-30 * 1.4, 30.0], [1.0, 0.0]], atol=1e-6)


@pytest.mark.parametrize("method", ["trf", "dogbox"])
@pytest.mark.parametrize("scaled", [False, True])
def test_a_bent_valley_is_followed_to_its_end(method: Literal["trf", "dogbox"], scaled: bool):
    found = minimise(bent(100.0), np.array([-1.0, 1.0]), method=method, scaled=scaled)
    # on y = x^2: the minimum of (x - 1)^2 + x^2 + x^4, where 2 x^3 + 2 x = 1
    x = float(next(root.real for root in np.roots([2, 0, 2, -1]) if abs(root.imag) < 1e-12))
    np.testing.assert_allclose(found.z, [x, x**2], atol=1e-3)
    assert found.converged


@pytest.mark.parametrize("scaled", [False, True])
def test_where_nothing_responds_a_descent_stays(scaled: bool):
    """The minimum is on the edge of where there is a response: differences end a step of theirs before it."""
    silent = Plain(lambda z: np.where(z[..., :1] < 0, np.nan, z), standard(1))
    found = minimise(silent, np.array([-1.0]), scaled=scaled)
    assert (found.z.tolist(), found.converged, found.cost, found.log_evidence) == ([-1.0], False, np.inf, -np.inf)
    (end,) = minimise(silent, np.array([1.0]), scaled=scaled).z
    assert 0 <= end <= 1.01 * USUAL
