"""Descents begin in every valley that screening shows, also in small ones beside a broad one that is nearly as good."""

import numpy as np
import pytest

from multilayer.optimisation.search import Candidate, Scalar, apart, valleys

SCALAR = Scalar(np.ones(1), np.zeros(1), np.ones(1))


def candidates(cost, x, key=()):
    return [Candidate(key, row, np.array([cost(row)]), 0.0) for row in x]


def screened(n, seed=0):
    return np.random.default_rng(seed).random((64, n))


@pytest.mark.parametrize("seed", range(20))
def test_a_small_valley_in_a_corner_is_begun_in(seed):
    def cost(x):
        broad = np.sum((x - 0.6) ** 2)
        return min(broad, 8 * np.sum((x - [0.05, 0.95]) ** 2) + 0.05)

    x = np.concatenate([screened(2, seed), [[0.1, 0.9]]])
    archive = candidates(cost, x)
    best = next(iter(apart(archive, SCALAR)))
    assert np.all(np.abs(best.x - 0.6) < 0.2)
    found = [one.x for one in valleys(archive, SCALAR)]
    assert any(np.all(np.abs(one - [0.05, 0.95]) < 0.11) for one in found)
    assert len(found) < 12


def test_of_one_valley_there_is_one():
    archive = candidates(lambda x: float(np.sum((x - 0.4) ** 2)), np.linspace(0, 1, 64)[:, None])
    (one,) = valleys(archive, SCALAR)
    assert one.x[0] == pytest.approx(0.4, abs=0.01)


def test_each_variant_has_its_valleys():
    x = screened(1)
    archive = [c for key in ((0,), (1,)) for c in candidates(lambda x: float((x[0] - 0.4) ** 2), x, key)]
    assert {one.key for one in valleys(archive, SCALAR)} == {(0,), (1,)}
    alone = [Candidate((i,), np.zeros(0), np.array([i]), 0.0) for i in range(3)]  # nothing between bounds
    assert valleys(alone, SCALAR) == alone
    assert valleys([], SCALAR) == []
