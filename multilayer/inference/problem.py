"""What optimisers and samplers know of an inverse problem: residuals and parameters, nothing of the physics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.priors import Parameter

_STEP = 1e-4  # of a standard normal coordinate
_BALANCED = 1e-5  # the same where the place of a minimum hangs on the derivative: neither bent nor lost in rounding
_SHORT = 1e-6  # the same where residuals are smooth to rounding


class Problem(Protocol):
    """Measurements, a model, and what is unknown of it."""

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The unknowns."""

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data), at coordinates of shape (..., n_parameters).

        Whitened: of unit variance and independent where model and coordinates are right.
        """

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual at z and its derivative, shapes (n_data,) and (n_data, n_parameters).

        Most problems leave that to `by_differences`.
        """


def by_differences(
    residual: Callable[[RealArray], RealArray], z: RealArray, columns: int | None = None
) -> tuple[RealArray, RealArray]:
    """Return a residual and its derivative by central differences, all columns in one call: one batched solve.

    Parameters
    ----------
    residual : callable
        Takes coordinates of shape (..., n).
    z : array, shape (n,)
    columns : int, optional
        How many of the first coordinates; all when left out.
    """
    n = z.size if columns is None else columns
    steps = _STEP * np.eye(z.size)[:n]
    values = residual(np.concatenate([z[None], z + steps, z - steps]))
    return values[0], (values[1 : 1 + n] - values[1 + n :]).T / (2 * _STEP)


def by_forward_differences(residual: Callable[[RealArray], RealArray], z: RealArray) -> tuple[RealArray, RealArray]:
    """Return the same from half as many points: for residuals in closed form, whose rounding a short step may divide.

    Right to about a millionth, which is no less than a search or a posterior's width needs.
    """
    values = residual(np.concatenate([z[None], z + _SHORT * np.eye(z.size)]))
    return values[0], (values[1:] - values[0]).T / _SHORT


def astride(z: RealArray) -> RealArray:
    """Return coordinates (n,), those a step ahead and those a step behind along each axis, shape (2 n + 1, n)."""
    step = _BALANCED * np.eye(z.size)
    return np.concatenate([z[None], z + step, z - step])


def central_differences(values: RealArray) -> tuple[RealArray, RealArray]:
    """Return a function's value, shape (k,), and derivative, shape (k, n), of its values `astride` a point."""
    n = len(values) // 2
    return values[0], (values[1 : n + 1] - values[n + 1 :]).T / (2 * _BALANCED)


@dataclass(frozen=True)
class Minimum:
    """A point where the posterior density is highest nearby.

    Attributes
    ----------
    z : array, shape (n,)
        Standard normal coordinates.
    misfit : float
        Sum of the squared residuals: chi-square of the data.
    residual : array, shape (n_data,)
    jacobian : array, shape (n_data, n)
    converged : bool
    """

    z: RealArray
    misfit: float
    residual: RealArray = field(repr=False)
    jacobian: RealArray = field(repr=False)
    converged: bool = True

    @property
    def cost(self) -> float:
        """Misfit plus the prior's z^2: minus twice the logarithm of the posterior density."""
        return float(self.misfit + self.z @ self.z)

    @property
    def cost_per_datum(self) -> float:
        """Cost over the number of data: about 1 by chance alone."""
        return self.cost / len(self.residual)

    @property
    def precision(self) -> RealArray:
        """Inverse covariance of z by Laplace's approximation, with Gauss-Newton's Hessian."""
        return np.asarray(self.jacobian.T @ self.jacobian + np.eye(self.z.size))

    @property
    def covariance(self) -> RealArray:
        """Covariance of z."""
        return np.asarray(np.linalg.inv(self.precision))

    @property
    def log_evidence(self) -> float:
        """Logarithm of the evidence by Laplace's approximation, but for the constant of the whitened data.

        ``ln p(y|z) + ln p(z) + (d/2) ln 2 pi - 1/2 ln |H|``; the prior's normalisation cancels the second constant.
        """
        return float(-0.5 * self.cost - 0.5 * np.linalg.slogdet(self.precision)[1])
