"""Mean and standard deviation over regions whose moments are known in closed form."""

import numpy as np
import pytest

from multilayer.fits.burst.region import explore

LOW, HIGH = np.array([-10.0, -10.0]), np.array([10.0, 10.0])


def identity(x: np.ndarray) -> np.ndarray:
    return x


@pytest.mark.parametrize("guess", [0.3, 1.0, 3.0])
def test_ellipse(guess: float) -> None:
    # uniform over an ellipse of half axes a, b: standard deviations a/2, b/2
    axes = np.array([2.0, 0.5])
    region = explore(lambda x: np.linalg.norm(x / axes, axis=-1), np.zeros(2), guess * np.diag(axes), LOW, HIGH)
    mean, std = region.moments(identity)
    assert mean == pytest.approx(0, abs=0.02)
    assert std == pytest.approx(axes / 2, rel=0.02)


def test_tilted_ellipse_keeps_its_correlation() -> None:
    root = np.array([[2.0, 0.0], [1.5, 0.4]])
    inverse = np.linalg.inv(root)
    region = explore(lambda x: np.linalg.norm(x @ inverse.T, axis=-1), np.zeros(2), root, LOW, HIGH)
    _, std = region.moments(lambda x: np.stack([x[..., 0], x[..., 1], x[..., 1] - 0.75 * x[..., 0]], axis=-1))
    assert std == pytest.approx([1.0, np.hypot(1.5, 0.4) / 2, 0.2], rel=0.03)


def test_box_of_equation_10() -> None:
    # uniform over a box of half widths a, b: standard deviations a/sqrt(3), b/sqrt(3)
    half = np.array([1.0, 0.2])
    region = explore(lambda x: np.max(np.abs(x) / half, axis=-1), np.zeros(2), np.diag(half), LOW, HIGH)
    assert region.moments(identity)[1] == pytest.approx(half / np.sqrt(3), rel=0.03)


def test_bounds_cut_the_region() -> None:
    # the half disc x > 0 of radius 1: mean of x is 4/(3 pi)
    low = np.array([0.0, -10.0])
    region = explore(lambda x: np.linalg.norm(x, axis=-1), np.zeros(2), np.eye(2), low, HIGH)
    mean, _ = region.moments(identity)
    assert mean == pytest.approx([4 / (3 * np.pi), 0], abs=0.03)
    assert region.outline[:, 0].min() >= 0


def test_mean_follows_an_asymmetric_region() -> None:
    # a gauge that is twice as steep to the left: the mean lies to the right of the centre
    def gauge(x: np.ndarray) -> np.ndarray:
        return np.hypot(np.where(x[..., 0] < 0, 2 * x[..., 0], x[..., 0]), x[..., 1])

    mean, _ = explore(gauge, np.zeros(2), np.eye(2), LOW, HIGH).moments(identity)
    expected = (0.5 * 1 * 4 / (3 * np.pi) - 0.25 * 0.5 * 4 / (3 * np.pi)) / 0.75
    assert mean[0] == pytest.approx(expected, rel=0.05)


def test_a_point_has_no_spread() -> None:
    region = explore(lambda x: np.where(np.linalg.norm(x, axis=-1) > 0, np.inf, 0.0), np.zeros(2), np.eye(2), LOW, HIGH)
    mean, std = region.moments(identity)
    assert mean == pytest.approx([0, 0])
    assert std == pytest.approx([0, 0])
