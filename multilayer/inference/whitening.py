"""Whitening: differences from measured values as independent numbers of unit variance, by noise and model error.

Kernels of model errors: C. E. Rasmussen & C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006,
sec. 4.2 (exponential, squared exponential).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import ComplexArray, RealArray

_ROUGH = 0.01  # share of the variance of a smooth error that has no correlation


@dataclass(frozen=True)
class ValueNoise:
    """Standard deviations of the real and of the imaginary part of measured values, shape (n,).

    Of real values the second part is not used.
    """

    real: RealArray
    imaginary: RealArray


@dataclass(frozen=True)
class CorrelatedError:
    """Error of a model, relative to the values, correlated along frequency.

    By default the kernel is exponential, ``exp(-|d|)`` with d = ln(f1/f2)/length, whose errors are continuous but not
    differentiable. A smoother kernel takes kinks and steps, such as a resonance that the model lacks, for next to
    impossible, and biases all parameters to avoid them. Where the model is right but for the error of its solver, which
    has no kinks, the kernel is squared exponential, ``exp(-d^2/2)``; a hundredth of the variance is then uncorrelated.

    Attributes
    ----------
    relative : float
        Standard deviation of each part.
    length : float
        Correlation length in ln f.
    smooth : bool
        Whether the kernel is squared exponential.
    """

    relative: float
    length: float = 0.3
    smooth: bool = False

    def covariance(self, frequency: RealArray) -> RealArray:
        """Return the covariance of the relative error, shape (n, n)."""
        distance = np.subtract.outer(np.log(frequency), np.log(frequency)) / self.length
        if not self.smooth:
            return np.asarray(self.relative**2 * np.exp(-np.abs(distance)))
        return np.asarray(self.relative**2 * (np.exp(-0.5 * distance**2) + _ROUGH * np.eye(len(frequency))))


@dataclass(frozen=True)
class Whitening:
    """A linear map of differences of fitted quantities to independent numbers of unit variance.

    Attributes
    ----------
    pointwise : array, shape (n, k, k), or None
        A matrix for every value, where values are not correlated; k = 2 parts of complex values, 1 of real ones.
    dense : array, shape (k n, k n) or (n, n), or None
        A matrix for all values, real parts first, where these are correlated; shape (n, n) where real and imaginary
        parts are independent of each other and equally distributed.
    """

    pointwise: RealArray | None
    dense: RealArray | None = None

    @classmethod
    def of_parts(cls, covariance: RealArray) -> Whitening:
        """Return the whitening of values whose parts are independent, each with the same covariance, shape (n, n)."""
        return cls(None, np.asarray(np.linalg.inv(np.linalg.cholesky(covariance))))

    def __call__(self, difference: NDArray[Any]) -> RealArray:
        """Return whitened differences, shape (..., k n), real parts first, of shape (..., n)."""
        parts = _parts(difference)
        if self.dense is not None:
            if len(self.dense) == difference.shape[-1]:
                return np.concatenate([part @ self.dense.T for part in parts], axis=-1)
            return np.asarray(np.concatenate(parts, axis=-1) @ self.dense.T)
        assert self.pointwise is not None
        white = np.einsum("nij,j...n->i...n", self.pointwise, np.stack(parts))
        return np.concatenate(list(white), axis=-1)


def _parts(values: NDArray[Any]) -> list[RealArray]:
    return [values.real, values.imag] if np.iscomplexobj(values) else [np.asarray(values, dtype=float)]


def whitening(
    frequency: RealArray,
    slope: ComplexArray | RealArray,
    values: NDArray[Any],
    noise: ValueNoise,
    error: CorrelatedError | None,
) -> Whitening:
    """Return the whitening of a fitted quantity y(v) of measured values v, to first order in their errors.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz.
    slope : array, shape (n,)
        dy/dv; of complex values y must be analytic.
    values : array, shape (n,)
        v, to which the model's error is relative.
    noise : ValueNoise
        Of the measured values.
    error : CorrelatedError, optional
        Of the model.
    """
    n = len(frequency)
    pointwise = _noise_covariance(slope, noise, np.iscomplexobj(values))
    k = pointwise.shape[-1]
    if error is None:
        return Whitening(np.linalg.inv(np.linalg.cholesky(pointwise)))
    total = np.zeros((k, n, k, n))
    total[:, np.arange(n), :, np.arange(n)] = pointwise
    rows = _as_matrices(slope * values, k)
    total += np.einsum("nij,mkj,nm->inkm", rows, rows, error.covariance(frequency))
    return Whitening(None, np.linalg.inv(np.linalg.cholesky(total.reshape(k * n, k * n))))


def _as_matrices(factor: NDArray[Any], k: int) -> RealArray:
    """Return multiplication by complex numbers as real matrices, shape (n, k, k)."""
    if k == 1:
        return np.asarray(factor.real[:, None, None])
    return np.moveaxis(np.array([[factor.real, -factor.imag], [factor.imag, factor.real]]), -1, 0)


def _noise_covariance(slope: NDArray[Any], noise: ValueNoise, is_complex: bool) -> RealArray:
    rows = _as_matrices(np.asarray(slope), 2 if is_complex else 1)
    spread = np.stack([noise.real, noise.imaginary][: rows.shape[-1]], axis=-1)
    scaled = rows * spread[:, None, :]
    return np.asarray(scaled @ np.swapaxes(scaled, -1, -2))
