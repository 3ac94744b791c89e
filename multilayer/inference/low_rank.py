"""Covariances ``1 + B B^T`` of low rank beyond the unit matrix: noise, and model errors common to many data.

Inverse root and determinant follow from the eigenvectors of ``B^T B`` (the matrix inversion and determinant lemmas:
G. H. Golub & C. F. Van Loan, Matrix Computations, 4th ed., Johns Hopkins 2013, sec. 2.1.4).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Problem
from multilayer.inference.reparameterisation import Reparameterisation

_LEAST = 0.003  # standard deviations of the data: smaller model errors change nothing
_ROUNDING = 1e-12  # of the largest eigenvalue: smaller ones are not resolved


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
        """Return the covariance with columns B, shape (n_data, m)."""
        # eigenvectors of B^T B take a tenth of the time of singular values, and are as exact for those that are kept
        squares, vectors = np.linalg.eigh(basis.T @ basis)
        kept = squares > max(_LEAST**2, _ROUNDING * squares.max(initial=0.0))
        sizes = np.sqrt(squares[kept])
        return cls(basis @ vectors[:, kept] / sizes, sizes)

    @property
    def log_determinant(self) -> float:
        """Logarithm of the covariance's determinant."""
        return float(np.sum(np.log1p(self.sizes**2)))

    def whitened(self, values: RealArray) -> RealArray:
        """Return ``(1 + B B^T)^(-1/2)`` times values, shape (..., n_data)."""
        return self._reduced(values, 1 - 1 / np.sqrt(1 + self.sizes**2))

    def inverse(self, values: RealArray) -> RealArray:
        """Return ``(1 + B B^T)^-1`` times values, shape (..., n_data)."""
        return self._reduced(values, self.sizes**2 / (1 + self.sizes**2))

    def _reduced(self, values: RealArray, shares: RealArray) -> RealArray:
        """Return values less a share of each of their components along the directions."""
        return np.asarray(values - (values @ self.directions * shares) @ self.directions.T)

    def log_density(self, residual: RealArray) -> float:
        """Return the log density of a normal residual, shape (n_data,), without the constant ``-n/2 ln 2 pi``."""
        whitened = self.whitened(residual)
        return -0.5 * float(whitened @ whitened) - 0.5 * self.log_determinant


def prediction_root(slopes: RealArray, fitted: RealArray) -> RealArray:
    """Return B with ``B B^T = S (1 + K^T K)^-1 S^T``: a root of the covariance of predictions.

    By a QR decomposition of K: ``K^T K`` may have lost the 1 to rounding.

    Parameters
    ----------
    slopes : array S, shape (n, d)
        Derivatives of the predictions by the unknowns, standard normal before the fit.
    fitted : array K, shape (m, d)
        Derivatives of the whitened data that were fitted.
    """
    factor: RealArray = np.asarray(np.linalg.qr(np.concatenate([np.eye(fitted.shape[1]), fitted]))[1])
    return np.asarray(np.linalg.solve(factor.T, slopes.T).T)


@dataclass(frozen=True)
class WithModelErrors(Problem):
    """A problem whose model has errors of a known covariance beside noise; residuals are whitened by both.

    Attributes
    ----------
    problem : Problem
    errors : LowRank
        Covariance of noise and model errors, in the problem's whitened residuals.
    """

    problem: Problem
    errors: LowRank

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The problem's parameters."""
        return self.problem.parameters

    def reparameterisation(self, z: RealArray, *, far: bool = False) -> Reparameterisation | None:
        """Return that of the problem."""
        return self.problem.reparameterisation(z, far=far)

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data)."""
        return self.errors.whitened(self.problem.residual(z))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative."""
        residual, slopes = self.problem.linearised(z)
        return self.errors.whitened(residual), self.errors.whitened(slopes.T).T
