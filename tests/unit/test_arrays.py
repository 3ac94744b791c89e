"""Rows that differ."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from multilayer.arrays import distinct_rows


@given(arrays(float, st.tuples(st.integers(1, 30), st.integers(1, 3)), elements=st.sampled_from([0.0, 1.0, 1.5, -2.0])))
def test_rows_are_given_back(rows):
    kept, place = distinct_rows(rows, np.float64(3.0) + np.zeros(()))
    np.testing.assert_array_equal(rows[kept][place], rows)
    assert len(kept) == len(np.unique(rows, axis=0))


def test_columns_count_together():
    kept, place = distinct_rows(np.array([[1.0], [1.0], [1.0]]), np.array([0.0, 2.0, 0.0]), np.zeros(()))
    assert len(kept) == 2
    assert place[0] == place[2] != place[1]
