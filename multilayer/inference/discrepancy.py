"""A model discrepancy of known shapes and unknown size: the part of it that the unknowns cannot absorb.

Model discrepancy as a Gaussian process: M. C. Kennedy & A. O'Hagan, J. R. Stat. Soc. B 63 (2001) 425-464. Orthogonal
to the model's derivatives, so that it is not confounded with the unknowns: M. Plumlee, J. Am. Stat. Assoc. 112 (2017)
1274-1285.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.problem import Minimum


@dataclass(frozen=True)
class OrthogonalDiscrepancy:
    """The part of a discrepancy of known shapes that the unknowns cannot absorb.

    Whitened residuals r of a model with Jacobian J and standard normal unknowns, and a discrepancy of size s with
    covariance ``s^2 K``, are distributed as ``r ~ N(0, 1 + J J^T + s^2 P K P^T)`` with ``P = (1 + J J^T)^-1``. Where
    the data determine all unknowns, P is the projector off the columns of J (Plumlee). Here the priors are kept in it:
    unknowns that the data hardly determine absorb nothing, and the direction of their derivatives, which is one of
    rounding, does not count.

    Attributes
    ----------
    gram : array, shape (k, k)
        Inner products of the discrepancy's columns, less what the unknowns absorb.
    projection : array, shape (k,)
        Inner products of these columns with the residual.
    """

    gram: RealArray
    projection: RealArray

    @classmethod
    def of(cls, minimum: Minimum, basis: RealArray) -> OrthogonalDiscrepancy:
        """Return it at a minimum, of columns B of unit size, shape (n_data, k), whitened as the minimum's residuals."""
        u, s, _ = np.linalg.svd(minimum.jacobian, full_matrices=False)
        factors = 1 / (1 + s**2)  # P along the columns of u; of a linear model a minimum's residual is P r(0)
        along = u.T @ basis
        projected = basis - u @ ((1 - factors)[:, None] * along)
        whitened = basis - u @ ((1 - factors**1.5)[:, None] * along)
        return cls(whitened.T @ whitened, projected.T @ minimum.residual)

    def log_bayes_factors(self, sizes: Sequence[float]) -> list[float]:
        """Return by how much the log evidence rises with discrepancies of some sizes, relative to the columns'."""
        logarithms = []
        for size in sizes:
            factor = self._factor(size)
            logarithms.append(0.5 * self.misfit_reduction(size) - float(np.sum(np.log(np.diag(factor)))))
        return logarithms

    def misfit_reduction(self, size: float) -> float:
        """Return by how much the misfit falls, a discrepancy of this size being marginalised."""
        solved = np.linalg.solve(self._factor(size), self.projection)
        return float(size**2 * solved @ solved)

    def _factor(self, size: float) -> RealArray:
        return np.asarray(np.linalg.cholesky(np.eye(len(self.gram)) + size**2 * self.gram))
