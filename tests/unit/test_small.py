"""Algebra of small entry-first matrices against NumPy's, matrix by matrix."""

import numpy as np
import pytest

from multilayer.matrix.small import beside, multiply, solve_small
from multilayer.media.elastic import decaying_root

RNG = np.random.default_rng(20)


def random(*shape: int) -> np.ndarray:
    return RNG.standard_normal(shape) + 1j * RNG.standard_normal(shape)


def matrices_last(entries: np.ndarray) -> np.ndarray:
    return np.moveaxis(entries, (0, 1), (-2, -1))


def test_products_broadcast() -> None:
    a, b = random(4, 3, 5), random(3, 2, 7, 1)
    expected = matrices_last(a.reshape(4, 3, 1, 5)) @ matrices_last(b)
    np.testing.assert_allclose(matrices_last(multiply(a, b)), expected, rtol=1e-13)


@pytest.mark.parametrize("n", [1, 2, 4, 6])
@pytest.mark.parametrize("batch", [(), (50,), (8, 3)])
def test_solutions(n: int, batch: tuple[int, ...]) -> None:
    left, matrix = random(n, 3, *batch), random(n, n, *batch)
    # rows of velocities beside rows of stresses
    scale = (10.0 ** RNG.uniform(-9, 9, (n, 1, *batch))).astype(complex)
    found = solve_small(beside(scale * left, scale * matrix))
    expected = -np.linalg.solve(matrices_last(matrix), matrices_last(left))
    np.testing.assert_allclose(matrices_last(found), expected, rtol=1e-9)


def test_rows_are_exchanged_system_by_system_where_no_order_serves_all() -> None:
    n = 5
    orders = np.array([RNG.permutation(n) for _ in range(200)])
    matrix = np.zeros((n, n, 200), dtype=complex)
    for k, order in enumerate(orders):
        matrix[order, np.arange(n), k] = 1 + np.arange(n)
    matrix += 1e-12 * random(n, n, 200)
    left = random(n, 2, 200)
    found = solve_small(beside(left, matrix))
    expected = -np.linalg.solve(matrices_last(matrix), matrices_last(left))
    np.testing.assert_allclose(matrices_last(found), expected, rtol=1e-12)


def test_singular_systems_alone_are_not_finite() -> None:
    matrix = random(3, 3, 4)
    matrix[2, :, 1] = 0
    matrix[:, 0, 2] = 0
    found = solve_small(beside(random(3, 1, 4), matrix))
    assert np.isfinite(found).all(axis=(0, 1)).tolist() == [True, False, False, True]


@pytest.mark.parametrize("squares", [[4.0, 9.0], [4.0, -9.0], [4 - 1e-3j, 4 + 1e-3j, -4 + 1e-3j, -4 - 1e-3j, 0j]])
def test_waves_decay_or_travel_forwards(squares: list[complex]) -> None:
    k = decaying_root(np.array(squares))
    np.testing.assert_allclose(k**2, squares, rtol=1e-14)
    assert np.all(k.imag <= 0)
    assert np.all(k.real[k.imag == 0] >= 0)
    for square, expected in zip(squares, k, strict=True):
        assert decaying_root(square) == expected
