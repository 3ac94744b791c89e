"""The optimiser knows residuals and parameters only; so do its tests."""

import numpy as np
import pytest

from multilayer.inference.least_squares import distinct, trust_region
from multilayer.inference.multistart import lowest_on_grid

BOUNDS = np.array([-3.0, -3.0]), np.array([3.0, 3.0])
ONES = np.ones(2)


def double_well(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Minima at (1, 0) and (-1, 0), the second higher by 0.1."""
    u, v = x
    residual = np.array([u**2 - 1, v, 0.05 * (u - 1)])
    return residual, np.array([[2 * u, 0], [0, 1], [0.05, 0]])


def test_every_valley_is_found_and_the_lowest_comes_first() -> None:
    axis = np.linspace(-2, 2, 21)
    grid = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)
    values = np.linalg.norm(
        np.stack([grid[..., 0] ** 2 - 1, grid[..., 1], 0.05 * (grid[..., 0] - 1)], axis=-1), axis=-1
    )
    starts = lowest_on_grid(values, (axis, axis), 6)
    minima = distinct([trust_region(double_well, start, bounds=BOUNDS) for start in starts], 0.01 * ONES)
    assert [m.z[0] for m in minima] == pytest.approx([1, -1], abs=0.01)
    assert minima[0].norm == pytest.approx(0, abs=1e-6)
    assert minima[1].norm == pytest.approx(0.1, rel=0.01)


def test_a_minimum_on_a_bound_is_marked() -> None:
    def beyond(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x - np.array([5.0, 0.0]), np.eye(2)

    found = trust_region(beyond, np.zeros(2), bounds=BOUNDS)
    assert found.at_bound
    assert found.z == pytest.approx([3, 0], abs=1e-3)


def test_history_records_every_evaluation_and_continues() -> None:
    first = trust_region(double_well, np.array([2.0, 1.0]), bounds=BOUNDS, most=2)
    second = trust_region(double_well, first.z, bounds=BOUNDS, before=first.history)
    assert second.history[: len(first.history)] == first.history
    assert second.history[-1][1] <= first.norm


def test_equal_minima_are_one() -> None:
    twice = [trust_region(double_well, np.array([s, 0.3]), bounds=BOUNDS) for s in (0.8, 1.3)]
    assert len(distinct(twice, 0.01 * ONES)) == 1
