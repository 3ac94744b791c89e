"""Percentiles of values that arrive in pieces, beside those of all values at once."""

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from multilayer.simulation.percentiles import Percentiles, bytes_kept

PERCENTS = (0, 5, 50, 95, 100)


def in_pieces(values, sizes):
    percentiles, start = Percentiles(PERCENTS), 0
    for size in sizes:
        percentiles.add(values[start : start + size])
        start += size
    percentiles.add(values[start:])
    return percentiles


@pytest.mark.parametrize("n", [2, 3, 200, 2047, 2048, 60_000])
@pytest.mark.parametrize("kind", ["normal", "few", "constant", "skewed", "infinite"])
def test_they_are_those_of_all_values_at_once(kind, n):
    rng = np.random.default_rng(1)
    values = rng.normal(size=(n, 3))
    values = {
        "normal": values,
        "few": np.round(values),
        "constant": np.full((n, 3), 0.3),
        "skewed": np.exp(5 * values),
        "infinite": np.where(values > 1.0, np.inf, values),
    }[kind]
    with np.errstate(invalid="ignore"):
        expected = np.percentile(values, PERCENTS, axis=0)
    np.testing.assert_array_equal(in_pieces(values, [50] * (n // 50)).result(), expected)


@settings(max_examples=100, deadline=None)
@example([3410, 686], 2, 3)
@given(st.lists(st.integers(1, 9000), max_size=6), st.integers(0, 5), st.integers(0, 1000))
def test_pieces_of_any_size_of_values_with_ties(sizes, digits, seed):
    values = np.round(np.random.default_rng(seed).normal(size=(sum(sizes) + 30_000, 2)), digits)
    np.testing.assert_array_equal(in_pieces(values, sizes).result(), np.percentile(values, PERCENTS, axis=0))


def test_what_is_no_number_stays_so():
    values = np.random.default_rng(0).normal(size=(20_000, 2))
    values[17_000, 1] = np.nan
    result = in_pieces(values, [5000] * 3).result()
    np.testing.assert_array_equal(result[:, 0], np.percentile(values[:, 0], PERCENTS))
    assert np.all(np.isnan(result[:, 1]))


def test_few_values_are_kept():
    percentiles, rng = Percentiles((5, 50, 95)), np.random.default_rng(2)
    for _ in range(100):
        percentiles.add(rng.normal(size=(10_000, 2)))
    kept = sum(len(v) for part in percentiles._parts for v in part._values)
    assert kept * 16 < 2 * bytes_kept(1_000_000, 3) < 0.2 * 2 * 8 * 1_000_000
