"""The full finite-element solution, one sparse factorisation per point."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.assembly import Assembly
from multilayer.rig.operators import Sparse


def full_solution(assembly: Assembly, values: ComplexArray) -> ComplexArray:
    """Return the transmissibility at points whose coefficients are `values`, shape (n_terms, n_points)."""
    combine = Combination(assembly)
    return np.array([1 + assembly.reading @ combine.solve(column) for column in values.T])


class Combination:
    """Sums of the matrices of an assembly, on one pattern of entries."""

    def __init__(self, assembly: Assembly) -> None:
        self.assembly = assembly
        pattern = sum((abs(matrix) for matrix in assembly.matrices), start=0 * assembly.matrices[0]).tocsc()
        pattern.sort_indices()
        self._pattern = pattern
        self._entries = np.stack([_on_pattern(matrix, pattern) for matrix in assembly.matrices])

    def factor(self, values: ComplexArray) -> SuperLU:
        """Return the factorisation of sum(values_k A_k)."""
        data = values @ self._entries
        matrix = csc_matrix((data, self._pattern.indices, self._pattern.indptr), shape=self._pattern.shape)
        # the matrices are symmetric: an ordering for those, and the diagonal as pivot where it is not tiny
        return splu(matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.01, options={"SymmetricMode": True})

    def solve(self, values: ComplexArray) -> ComplexArray:
        """Return the relative motion v."""
        return np.asarray(self.factor(values).solve(np.asarray(values @ self.assembly.loads, dtype=complex)))

    def primal_and_dual(self, values: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
        """Return the relative motion, and the motion under a unit load where the plate is read."""
        solver = self.factor(values)
        loads = (values @ self.assembly.loads, self.assembly.reading)
        primal, dual = (np.asarray(solver.solve(np.asarray(load, dtype=complex))) for load in loads)
        return primal, dual


def _on_pattern(matrix: Sparse, pattern: Sparse) -> RealArray:
    """Return the entries of a matrix in the order of a pattern that holds all of them."""
    rows = matrix.shape[0]
    columns = np.repeat(np.arange(rows), np.diff(pattern.indptr))
    places = columns * rows + pattern.indices  # rises: the pattern is sorted
    stored = matrix.tocoo()
    entries = np.zeros(pattern.nnz)
    np.add.at(entries, np.searchsorted(places, stored.col.astype(np.int64) * rows + stored.row), stored.data)
    return entries
