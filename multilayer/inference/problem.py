"""What optimisers and samplers know of an inverse problem: residuals and parameters, nothing of the physics."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from multilayer.arrays import RealArray
from multilayer.inference.priors import Parameter


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

        Most problems leave that to `multilayer.inference.derivative`.
        """


@dataclass(frozen=True)
class Minimum:
    """A point where the posterior density is highest nearby.

    Attributes
    ----------
    z : array, shape (n,)
        Standard normal coordinates, or whatever unknowns without priors are sought in.
    misfit : float
        Sum of the squared residuals: chi-square of the data.
    residual : array, shape (n_data,)
    jacobian : array, shape (n_data, n)
    converged : bool
    at_bound : bool
        Whether a coordinate lies on its bound.
    history : tuple of (array, float)
        Coordinates and norm of the residual at every evaluation on the way, where these were asked for.
    """

    z: RealArray
    misfit: float
    residual: RealArray = field(repr=False)
    jacobian: RealArray = field(repr=False)
    converged: bool = True
    at_bound: bool = False
    history: tuple[tuple[RealArray, float], ...] = field(repr=False, default=())

    @property
    def norm(self) -> float:
        """Norm of the residual."""
        return float(np.sqrt(self.misfit))

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
