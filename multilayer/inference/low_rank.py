"""Covariances that are the unit matrix and a few columns: noise, and errors of a model common to many data."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.derivative import FINE, central
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Problem

_LEAST = 0.003  # standard deviations of the data: smaller errors change nothing
_ROUNDING = 1e-12  # of the largest, squared: smaller ones are not resolved


@dataclass(frozen=True)
class LowRank:
    """The covariance ``1 + B B^T`` of whitened residuals, B = U diag(s) V^T.

    Attributes
    ----------
    directions : array, shape (n_data, k)
        U.
    sizes : array, shape (k,)
        s, standard deviations.
    """

    directions: RealArray
    sizes: RealArray

    @classmethod
    def of(cls, basis: RealArray) -> LowRank:
        """Return it from columns B, shape (n_data, m)."""
        # of B^T B: a tenth of the time of singular values, and as good for those that are kept
        squares, vectors = np.linalg.eigh(basis.T @ basis)
        kept = squares > max(_LEAST**2, _ROUNDING * squares.max(initial=0.0))
        sizes = np.sqrt(squares[kept])
        return cls(basis @ vectors[:, kept] / sizes, sizes)

    @property
    def log_determinant(self) -> float:
        """Of the covariance."""
        return float(np.sum(np.log1p(self.sizes**2)))

    def whitened(self, values: RealArray) -> RealArray:
        """Return ``(1 + B B^T)^(-1/2)`` times values, shape (..., n_data)."""
        shrink = 1 - 1 / np.sqrt(1 + self.sizes**2)
        return np.asarray(values - (values @ self.directions * shrink) @ self.directions.T)

    def log_density(self, residual: RealArray) -> float:
        """Return the logarithm of a residual's normal density, shape (n_data,), but for the constant of its length."""
        whitened = self.whitened(residual)
        return -0.5 * float(whitened @ whitened) - 0.5 * self.log_determinant


def left_open(slopes: RealArray, known: RealArray) -> RealArray:
    """Return columns B with ``B B^T = S (1 + K^T K)^-1 S^T``: what S changes, of unknowns known by slopes K.

    From K itself: its square may have lost the 1 to rounding.
    """
    factor: RealArray = np.asarray(np.linalg.qr(np.concatenate([np.eye(known.shape[1]), known]))[1])
    return np.asarray(np.linalg.solve(factor.T, slopes.T).T)


@dataclass(frozen=True)
class Softened(Problem):
    """A problem whose model may be wrong by errors of a known covariance, with residuals of unit variance again.

    Attributes
    ----------
    problem : Problem
    errors : LowRank
    """

    problem: Problem
    errors: LowRank

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the problem."""
        return self.problem.parameters

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data)."""
        return self.errors.whitened(self.problem.residual(z))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative."""
        residual, slopes = central(self.problem.residual, z, FINE)
        return self.errors.whitened(residual), self.errors.whitened(slopes.T).T
