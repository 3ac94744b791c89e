"""A discrepancy between model and data of known shapes and unknown size: what of it the unknowns cannot absorb."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.problem import Minimum


@dataclass(frozen=True)
class Leftover:
    """The part of a discrepancy of known shapes that the unknowns cannot absorb.

    ``r ~ N(0, 1 + J J^T + P K_s P^T)``, ``P = (1 + J J^T)^-1``: what the unknowns leave of a discrepancy of size s,
    their priors being what they are. Where the data say all, P projects off the columns of the Jacobian J (M. Plumlee,
    J. Am. Stat. Assoc. 112 (2017) 1274-1285); what the data hardly tell absorbs nothing, and the direction of its
    slopes, which is one of rounding, does not count.

    Attributes
    ----------
    gram : array, shape (k, k)
        Of the columns that are left.
    along : array, shape (k,)
        Their products with the residual.
    """

    gram: RealArray
    along: RealArray

    @classmethod
    def of(cls, minimum: Minimum, basis: RealArray) -> Leftover:
        """Return it at a minimum, of columns B of unit size, shape (n_data, k), whitened as the minimum's residuals."""
        u, s, _ = np.linalg.svd(minimum.jacobian, full_matrices=False)
        left = 1 / (1 + s**2)  # P along the columns of u; of a linear model a minimum's residual is P r(0)
        along = u.T @ basis
        free = basis - u @ ((1 - left)[:, None] * along)
        whitened = basis - u @ ((1 - left**1.5)[:, None] * along)
        return cls(whitened.T @ whitened, free.T @ minimum.residual)

    def gains(self, sizes: Sequence[float]) -> list[float]:
        """Return the gains of log evidence for discrepancies of some sizes, relative to the columns'."""
        found = []
        for size in sizes:
            factor = self._factor(size)
            found.append(0.5 * self.explained(size) - float(np.sum(np.log(np.diag(factor)))))
        return found

    def explained(self, size: float) -> float:
        """Return by how much the misfit falls, a discrepancy of this size being marginalised."""
        solved = np.linalg.solve(self._factor(size), self.along)
        return float(size**2 * solved @ solved)

    def _factor(self, size: float) -> RealArray:
        return np.asarray(np.linalg.cholesky(np.eye(len(self.gram)) + size**2 * self.gram))
