"""Algebra of small entry-first matrices: ``M[i, j]`` is an array over frequency, angle and samples."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import ComplexArray, Numeric

# The C library of Linux gives every freed block above 128 KiB back to the system, and each new one then costs page
# faults: half of the time of a solution. Freeing one large block, which nothing ever touches, raises that threshold.
np.empty(31 * 2**20, dtype=np.uint8)

Entries = Sequence[Sequence[Numeric]]
_GOOD_PIVOT = 0.1  # of the largest in its column: growth of errors stays below 11 per step, and mostly far below


def stack_entries(entries: Entries) -> ComplexArray:
    """Return nested entries, broadcast against each other, as one array of shape (rows, columns, ...)."""
    shape = np.broadcast_shapes(*(np.shape(entry) for row in entries for entry in row))
    matrix = np.empty((len(entries), len(entries[0]), *shape), dtype=complex)
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            matrix[i, j] = entry
    return matrix


def aligned(*matrices: ComplexArray, ndim: int = 0) -> list[ComplexArray]:
    """Return entry-first matrices with equally many axes, so that their trailing ones broadcast."""
    ndim = max(ndim, *(matrix.ndim for matrix in matrices))
    return [
        matrix.reshape(matrix.shape[:2] + (1,) * (ndim - matrix.ndim) + matrix.shape[2:])
        if matrix.ndim < ndim
        else matrix
        for matrix in matrices
    ]


def multiply(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the matrix product of entry-first matrices, broadcasting their trailing axes."""
    result: ComplexArray = np.einsum("ij...,jk...->ik...", *aligned(a, b))
    return result


def beside(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return [a b], the columns of two entry-first matrices with equally many rows."""
    a, b = aligned(a, b)
    shape = np.broadcast_shapes(a.shape[2:], b.shape[2:])
    columns = a.shape[1]
    joined = np.empty((a.shape[0], columns + b.shape[1], *shape), dtype=complex)
    joined[:, :columns], joined[:, columns:] = a, b
    return joined


def solve_small(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Solve many small systems at once by Gaussian elimination.

    Equations are first scaled to a largest coefficient of 1: velocities and stresses differ by orders of magnitude.
    Rows are exchanged for all systems alike while one row has a good pivot in all of them, and system by system only
    where none has.

    Parameters
    ----------
    matrix : complex array, shape (n, n, ...)
    right : complex array, shape (n, m, ...)

    Returns
    -------
    complex array, shape (n, m, ...)
        Not finite where a system is singular.

    Notes
    -----
    Every step is a pass over contiguous memory, about twice as fast as LAPACK called matrix by matrix at these sizes.
    """
    work = beside(matrix, right)
    n, batch = len(work), work.shape[2:]
    work = work.reshape(n, work.shape[1], -1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # the caller looks for what is not finite
        work *= 1 / _size(work[:, :n]).max(axis=1)[:, None]
        for k in range(n):
            if k + 1 < n:
                _bring_up_pivot(work, k)
            work[k, k + 1 :] /= work[k, k]
            work[k + 1 :, k + 1 :] -= work[k + 1 :, k, None] * work[None, k, k + 1 :]
        for k in range(n - 1, 0, -1):
            work[:k, n:] -= work[:k, k, None] * work[None, k, n:]
    return work[:, n:].reshape(n, -1, *batch)


def _size(values: ComplexArray) -> np.ndarray:
    """Return a modulus that is cheap and right to a factor of 1.5."""
    size = np.abs(values.real)
    size += np.abs(values.imag)
    return size


def _bring_up_pivot(work: ComplexArray, k: int) -> None:
    size = _size(work[k:, k])
    worst = (size / size.max(axis=0)).min(axis=1)
    row = int(np.argmax(worst))
    if worst[row] >= _GOOD_PIVOT:
        if row:
            work[[k, k + row]] = work[[k + row, k]]
        return
    rows = np.argmax(size, axis=0)
    moved = np.flatnonzero(rows)
    chosen = k + rows[moved]
    held = work[k][:, moved]
    work[k][:, moved] = work[chosen, :, moved].T
    work[chosen, :, moved] = held.T
