"""The ratio of modified Bessel functions beside mpmath, from short to long arguments."""

import mpmath
import numpy as np
import pytest

from multilayer.media.bessel_ratio import bessel_ratio


@pytest.mark.parametrize("size", [1e-6, 1e-3, 0.1, 1, 5, 10, 20, 40, 49.9, 50.1, 100, 1e4])
def test_it_is_that_of_mpmath(size):
    x = size * np.exp(1j * np.radians([-80, -70, -45, -10, 0, 30, 45, 60, 80]))
    with mpmath.workdps(40):
        exact = [complex(mpmath.besseli(1, mpmath.mpc(z)) / mpmath.besseli(0, mpmath.mpc(z))) for z in x]
    np.testing.assert_allclose(bessel_ratio(x), exact, rtol=1e-14)


def test_small_and_large_arguments_may_stand_together():
    x = np.array([[0.1 + 1j, 49.9], [50.1 + 3j, 1e3 * (1 + 1j)]])
    alone = [[bessel_ratio(np.array([z]))[0] for z in row] for row in x]
    np.testing.assert_allclose(bessel_ratio(x), alone, rtol=1e-15)
