"""The optimiser knows residuals and parameters only; so do its tests."""

import numpy as np
import pytest

from multilayer.inverse.search import distinct, refine, valleys

LOW, HIGH = np.array([-3.0, -3.0]), np.array([3.0, 3.0])
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
    starts = valleys(values, (axis, axis), 6)
    minima = distinct([refine(double_well, start, LOW, HIGH, ONES) for start in starts], 0.01 * ONES)
    assert [m.x[0] for m in minima] == pytest.approx([1, -1], abs=0.01)
    assert minima[0].misfit == pytest.approx(0, abs=1e-6)
    assert minima[1].misfit == pytest.approx(0.1, rel=0.01)


def test_a_minimum_on_a_bound_is_marked() -> None:
    def beyond(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x - np.array([5.0, 0.0]), np.eye(2)

    found = refine(beyond, np.zeros(2), LOW, HIGH, ONES)
    assert found.at_bound
    assert found.x == pytest.approx([3, 0], abs=1e-3)


def test_history_records_every_evaluation_and_continues() -> None:
    first = refine(double_well, np.array([2.0, 1.0]), LOW, HIGH, ONES, max_evaluations=2)
    second = refine(double_well, first.x, LOW, HIGH, ONES, before=first.history)
    assert second.history[: len(first.history)] == first.history
    assert second.history[-1][1] <= first.misfit


def test_equal_minima_are_one() -> None:
    twice = [refine(double_well, np.array([s, 0.3]), LOW, HIGH, ONES) for s in (0.8, 1.3)]
    assert len(distinct(twice, 0.01 * ONES)) == 1
