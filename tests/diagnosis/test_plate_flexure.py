"""Bending of the top plate where a rim of the sample does not hold it."""

import numpy as np
import pytest
from scipy.special import roots_jacobi

from multilayer.diagnosis.effects.delamination import share_in_centre
from multilayer.diagnosis.effects.plate_flexure import share_of_open_rim
from multilayer.rig import TwoPlateRig

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


@pytest.mark.parametrize("rim", [0.1, 0.2, 0.35])
@pytest.mark.parametrize("thickness", [0.0125, 0.025])
def test_a_sample_with_an_open_rim_bends_the_plate_of_finite_elements(thickness, rim):
    """A plate of steel beside a rigid one; within a quarter of the bending by even pressure."""
    f, radius, plate = np.array([300.0, 600.0]), 0.0225, 1e-3
    elastic, rigid = (
        TwoPlateRig(
            radius, thickness, 60.0, 0.0, plate, plate_modulus=modulus, bonded_fraction=(1 - rim) ** 2, open_faces="top"
        ).transmissibility(f, 2e5 * (1 + 0.2j))
        for modulus in (2.1e11, 2.1e14)
    )
    stiffness = 2.1e11 * plate**3 / (12 * (1 - 0.3**2))
    ratio = (2 * np.pi * f) ** 2 * radius**4 * 7850 * plate / stiffness / FIRST
    share = (elastic / rigid - 1) * (1 - ratio) / ratio
    even = share_of_open_rim(np.array(rim), 0.3)
    assert np.abs(share - share_in_centre(np.array(rim), 0.3)).max() < 0.25 * abs(even)
