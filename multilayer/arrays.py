"""Names of array types for signatures, and small functions of arrays that several packages use."""

from __future__ import annotations

from itertools import accumulate
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from multilayer.errors import InputError

RealArray: TypeAlias = NDArray[np.float64]
ComplexArray: TypeAlias = NDArray[np.complex128]
BoolArray: TypeAlias = NDArray[np.bool_]
IndexArray: TypeAlias = NDArray[np.intp]
Numeric: TypeAlias = float | complex | NDArray[Any]


def distinct_rows(*columns: RealArray) -> tuple[IndexArray, IndexArray]:
    """Return the indices of the distinct rows, shape (k,), and for every row the position of its like, shape (m,).

    So ``kept, place = distinct_rows(a)`` gives ``a[kept][place] == a``, and costly functions run on `kept` only.

    Parameters
    ----------
    columns : array, shape (m,), (m, n) or ()
        Parts of the rows, which are compared bit by bit; a scalar is the same in all rows.
    """
    count = max(len(column) for column in columns if column.ndim)
    widths = [column.shape[1] if column.ndim > 1 else 1 for column in columns]
    rows = np.empty((count, sum(widths)))
    for column, width, end in zip(columns, widths, accumulate(widths), strict=True):
        rows[:, end - width : end] = column if column.ndim != 1 else column[:, None]
    raw, size = rows.tobytes(), rows.itemsize * rows.shape[1]
    first: dict[bytes, int] = {}  # for some dozens of rows half the time of sorting them
    alike = [first.setdefault(raw[i * size : (i + 1) * size], i) for i in range(count)]
    kept = np.array([*first.values()])
    return kept, np.searchsorted(kept, alike)


def frequencies(values: ArrayLike) -> RealArray:
    """Return frequencies, Hz, as an array of the same shape.

    Raises
    ------
    InputError
        For none at all, and for one that is no number, not above 0 or not finite.
    """
    try:
        f = np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        raise InputError("a frequency is no number; frequencies are numbers in Hz, or an array of them") from None
    if not f.size:
        raise InputError("there is no frequency; give at least one, in Hz")
    if not 0 < f.min() <= f.max() < np.inf:  # of NaN neither holds; it is asked of every response
        raise InputError("a frequency is zero, negative or not finite; frequencies must be above 0 Hz")
    return f


def half_turn(phase: RealArray) -> RealArray:
    """Return phases, rad, as the same angles from -pi to pi."""
    return np.asarray(phase - 2 * np.pi * np.rint(phase / (2 * np.pi)))


def logarithm(values: ComplexArray) -> ComplexArray:
    """Return the principal logarithm, in a third of the time of `numpy.log`.

    The magnitude of what is infinite or 0 is infinite, without a warning of its own.
    """
    found = np.empty(np.shape(values), dtype=complex)
    with np.errstate(divide="ignore"):
        np.log(np.abs(values), out=found.real)
    np.arctan2(np.imag(values), np.real(values), out=found.imag)
    return found


__all__ = [
    "ArrayLike",
    "BoolArray",
    "ComplexArray",
    "IndexArray",
    "Numeric",
    "RealArray",
    "distinct_rows",
    "frequencies",
    "half_turn",
    "logarithm",
]
