"""Bending of the top plate where a rim of the sample does not hold it."""

import numpy as np
import pytest
from scipy.special import roots_jacobi

from multilayer.diagnosis.effects.plate_flexure import share_of_open_rim

FIRST = 9.08**2  # of the share: the deflection is in units of m w^2 R^4 / D


@pytest.mark.parametrize("poisson_ratio", [0.0, 0.3, 0.45])
@pytest.mark.parametrize("rim", [0.02, 0.15, 0.5, 0.9])
def test_deflection_of_a_free_disc_by_rayleigh_and_ritz(rim, poisson_ratio):
    """Least energy over polynomials in r^2 with a mean of 0; the pressure on the inner part balances the inertia."""
    powers = np.arange(1, 16)
    x, weights = roots_jacobi(60, 0, 0)
    t = 0.5 * (x + 1)[:, None]  # r^2, and 2 r dr = dt
    weights = 0.5 * weights
    radial = 2 * powers * (2 * powers - 1) * t ** (powers - 1)  # W''
    round_ = 2 * powers * t ** (powers - 1)  # W'/r
    mixed = radial.T @ (weights[:, None] * round_)
    energy = radial.T @ (weights[:, None] * radial) + round_.T @ (weights[:, None] * round_)
    energy += poisson_ratio * (mixed + mixed.T)
    inner = (1 - rim) ** 2  # in r^2
    work = 1 / (powers + 1) - inner**powers / (powers + 1)  # of 1 - (r < b)/b^2
    amounts = np.linalg.solve(energy, work)
    centre_over_mean = -np.sum(amounts / (powers + 1))
    assert float(share_of_open_rim(np.array(rim), poisson_ratio)) / FIRST == pytest.approx(centre_over_mean, rel=2e-3)
