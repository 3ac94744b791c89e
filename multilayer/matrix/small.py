"""Algebra of small entry-first matrices: ``M[i, j]`` is an array over frequency, angle and samples."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from multilayer.arrays import ComplexArray, Numeric, RealArray

# The C library of Linux gives every freed block above 128 KiB back to the system, and each new one then costs page
# faults: half of the time of a solution. Freeing one large block, which nothing ever touches, raises that threshold.
np.empty(31 * 2**20, dtype=np.uint8)

Entries = Sequence[Sequence[Numeric]]
_GOOD_PIVOT = 0.1  # of the largest in its column: growth of errors stays below 11 per step, and mostly far below


def stack_entries(entries: Entries) -> ComplexArray:
    """Return nested entries, broadcast against each other, as one array of shape (rows, columns, ...)."""
    shape = common_shape(entry for row in entries for entry in row)
    matrix = np.empty((len(entries), len(entries[0]), *shape), dtype=complex)
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            matrix[i, j] = entry
    return matrix


def common_shape(values: Iterable[Numeric]) -> tuple[int, ...]:
    """Return the shape that numbers and arrays broadcast to."""
    return _joint_shape({getattr(value, "shape", ()) for value in values})


def _joint_shape(shapes: set[tuple[int, ...]]) -> tuple[int, ...]:
    """Return the shape that arrays of these shapes broadcast to; mostly it is one, which NumPy takes long to see."""
    shapes = shapes - {()}
    return np.broadcast_shapes(*shapes) if len(shapes) > 1 else next(iter(shapes), ())


def aligned(*matrices: ComplexArray, ndim: int = 0) -> Sequence[ComplexArray]:
    """Return entry-first matrices with equally many axes, so that their trailing ones broadcast."""
    axes = [matrix.ndim for matrix in matrices]
    most = max(ndim, *axes)
    if min(axes) == most:
        return matrices
    return [matrix.reshape(matrix.shape[:2] + (1,) * (most - matrix.ndim) + matrix.shape[2:]) for matrix in matrices]


def multiply(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the matrix product of entry-first matrices, broadcasting their trailing axes.

    A few long passes, which einsum would make slowly.
    """
    a, b = aligned(a, b)
    product: ComplexArray = a[:, 0, None] * b[None, 0]
    for k in range(1, len(b)):
        product += a[:, k, None] * b[None, k]
    return product


def beside(*matrices: ComplexArray) -> ComplexArray:
    """Return [a b ...], the columns of entry-first matrices with equally many rows."""
    blocks = aligned(*matrices)
    shape = _joint_shape({block.shape[2:] for block in blocks})
    joined = np.empty((len(blocks[0]), sum(block.shape[1] for block in blocks), *shape), dtype=complex)
    start = 0
    for block in blocks:
        end = start + block.shape[1]
        joined[:, start:end] = block
        start = end
    return joined


def solve_small(work: ComplexArray) -> ComplexArray:
    """Solve many small systems at once by Gaussian elimination.

    Equations are weighed by their largest coefficients: velocities and stresses differ by orders of magnitude. Rows are
    exchanged for all systems alike while one row has a good pivot in all of them, and system by system only where none
    has.

    Parameters
    ----------
    work : complex array, shape (n, m + n, ...)
        [L M] of ``L + M X = 0``; overwritten. The last unknowns are eliminated first, the first have the fewest
        rounding errors.

    Returns
    -------
    complex array, shape (n, m, ...)
        X, not finite where a system is singular.

    Notes
    -----
    Every step is a pass over contiguous memory, faster than LAPACK called matrix by matrix at these sizes.
    """
    n, batch = len(work), work.shape[2:]
    m = work.shape[1] - n
    work = work.reshape(n, m + n, -1)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # the caller looks for what is not finite
        weight = 1 / np.abs(work[:, m:]).max(axis=1)
        for k, unknown in enumerate(range(m + n - 1, m - 1, -1)):
            if unknown > m:
                _bring_up_pivot(work[k:, : unknown + 1], weight[k:])
            # the unknown by those before it, in the place of its equation
            work[k, :unknown] *= -1 / work[k, unknown]
            work[k + 1 :, :unknown] += work[k + 1 :, unknown, None] * work[None, k, :unknown]
        for k, unknown in zip(range(n - 1, 0, -1), range(m, m + n), strict=False):
            work[:k, :m] += work[:k, unknown, None] * work[None, k, :m]
    return work[::-1, :m].reshape(n, m, *batch)


def _bring_up_pivot(work: ComplexArray, weight: RealArray) -> None:
    """Exchange rows, and their weights, so that the first has a good pivot in the last column."""
    size = np.abs(work[:, -1]) * weight
    worst = (size / size.max(axis=0)).min(axis=1)
    row = int(worst.argmax())
    if worst[row] >= _GOOD_PIVOT:
        if row:
            work[[0, row]], weight[[0, row]] = work[[row, 0]], weight[[row, 0]]
        return
    rows = size.argmax(axis=0)
    moved = np.flatnonzero(rows)
    chosen = rows[moved]
    for values in (work, weight[:, None]):
        held = values[0][:, moved]
        values[0][:, moved] = values[chosen, :, moved].T
        values[chosen, :, moved] = held.T
