"""The power series of thin layers against many digits, entry by entry."""

import mpmath
import numpy as np
import pytest

from multilayer.matrix.faces import THIN, propagator_series
from multilayer.matrix.families import FLUID, POROELASTIC, SOLID

mpmath.mp.dps = 40


def exact(family, x, y, thickness):
    """Return exp(M h) by mpmath."""
    whole = mpmath.zeros(family.size)
    for rows, columns, block in ((family.even, family.odd, x), (family.odd, family.even, y)):
        for i, row in enumerate(rows):
            for j, column in enumerate(columns):
                whole[row, column] = mpmath.mpc(block[i][j]) * thickness
    found = mpmath.expm(whole, method="taylor")
    return np.array([[complex(found[i, j]) for j in range(family.size)] for i in range(family.size)])


@pytest.mark.parametrize("family", [FLUID, SOLID, POROELASTIC], ids=lambda family: family.name)
@pytest.mark.parametrize("seed", range(4))
def test_every_entry_has_its_digits(family, seed):
    """Also the small ones beside large ones, as those of bending in a thin stiff layer."""
    rng, n = np.random.default_rng(seed), family.half
    sizes = 10.0 ** rng.uniform(-4, 4, (n, n))
    x = (rng.standard_normal((n, n)) + 1j * rng.standard_normal((n, n))) * sizes
    y = (rng.standard_normal((n, n)) + 1j * rng.standard_normal((n, n))) / sizes.T
    thickness = THIN * rng.uniform(0.1, 1) / np.sqrt(np.abs(np.linalg.eigvals(x @ y)).max())
    found = propagator_series(family, x.tolist(), y.tolist(), thickness)
    np.testing.assert_allclose(found, exact(family, x, y, thickness), rtol=1e-12)


def test_axes_of_thickness_and_medium_broadcast():
    rng = np.random.default_rng(5)
    x, y = (rng.standard_normal((3, 3, 7)) + 1j * rng.standard_normal((3, 3, 7)) for _ in range(2))
    thickness = rng.uniform(0.01, 0.1, (2, 5, 1))
    found = propagator_series(POROELASTIC, x, y, thickness)
    assert found.shape == (6, 6, 2, 5, 7)
    for i, j, k in ((0, 0, 0), (1, 4, 6)):
        alone = propagator_series(POROELASTIC, x[..., k], y[..., k], float(thickness[i, j, 0]))
        np.testing.assert_array_equal(found[..., i, j, k], alone)
