"""Inverse problems as optimisers and samplers know them: unknowns with priors, and whitened residuals.

An `Experiment` holds measured values, predicts them with a model, and whitens the difference; `Experiments` are a
`Problem` of several experiments that share their unknowns. Other residuals, or fewer unknowns, are made by wrapping a
problem into another problem. Evidence after D. J. C. MacKay, Neural Comput. 4 (1992) 415-447.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, RealArray
from multilayer.inference.derivative import Stencil
from multilayer.inference.priors import Parameter, Priors
from multilayer.inference.reparameterisation import Reparameterisation

T = TypeVar("T")


class Problem(ABC):
    """Measurements, a model, and its unknowns."""

    @property
    @abstractmethod
    def parameters(self) -> tuple[Parameter, ...]:
        """The unknowns."""

    @abstractmethod
    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data), at coordinates of shape (..., n_parameters).

        Whitened: of unit variance and independent where model and coordinates are right.
        """

    def reparameterisation(self, z: RealArray, *, far: bool = False) -> Reparameterisation | None:
        """Return coordinates in which the residuals around z are straighter; None where there are none such.

        With `far`, those that hold far from z, too, and straighten less.
        """
        return None

    def stencil(self, z: RealArray, make: Callable[..., Stencil] = Stencil.forward) -> Stencil:
        """Return points from whose values derivatives by z follow, shape (n_parameters,); `make` is of `Stencil`."""
        other = self.reparameterisation(z)
        return make(z) if other is None else make(z, turn=other.turn(z))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return the residual at z and its derivative, shapes (n_data,) and (n_data, n_parameters)."""
        stencil = self.stencil(z)
        return stencil.linearised(self.residual(stencil.points))

    def as_minimum(self, z: RealArray) -> Minimum:
        """Return a point that is taken for a minimum, coordinates of shape (n_parameters,)."""
        return Minimum(z, *self.linearised(z))


@dataclass(frozen=True, eq=False)
class Points:
    """Coordinates of some points, and the values of the unknowns there.

    Attributes
    ----------
    z : array, shape (m, n_parameters)
    priors : Priors
    """

    z: RealArray
    priors: Priors
    _shared: dict[Hashable, Any] = field(default_factory=dict, init=False, repr=False)

    @cached_property
    def values(self) -> RealArray:
        """Values of all unknowns, shape (m, n_parameters)."""
        return self.priors.values(self.z)

    @cached_property
    def named(self) -> dict[str, RealArray]:
        """Values by the unknown's name, each of shape (m,)."""
        return {name: self.values[:, i] for i, name in enumerate(self.priors.names)}

    def shared(self, key: Hashable, compute: Callable[[], T]) -> T:
        """Return what several experiments need at these points; it is computed by the first of them."""
        if key not in self._shared:
            self._shared[key] = compute()
        result: T = self._shared[key]
        return result


class Experiment(ABC):
    """Measured values, a model's prediction of them, and the covariance of errors of both."""

    @property
    @abstractmethod
    def data(self) -> Any:
        """The measured values."""

    @abstractmethod
    def difference(self, points: Points) -> NDArray[Any]:
        """Return predicted minus measured values, shape (m, n), in the quantity in which they are compared."""

    @abstractmethod
    def whiten(self, difference: NDArray[Any]) -> RealArray:
        """Return differences, shape (..., n), as independent numbers of unit variance, shape (..., n_data)."""


class Experiments(Problem):
    """Experiments that share their unknowns."""

    @property
    @abstractmethod
    def experiments(self) -> Sequence[Experiment]:
        """The experiments."""

    @cached_property
    def priors(self) -> Priors:
        """Priors of all unknowns."""
        return Priors.of(self.parameters)

    def points(self, z: RealArray) -> Points:
        """Return coordinates of shape (..., n_parameters) as points, flattened to (m, n_parameters)."""
        return Points(z.reshape(math.prod(z.shape[:-1]), z.shape[-1]), self.priors)

    def differences(self, z: RealArray) -> list[NDArray[Any]]:
        """Return predicted minus measured values, shape (..., n), of every experiment; NaN without a response."""
        points = self.points(z)
        return [experiment.difference(points).reshape(*z.shape[:-1], -1) for experiment in self.experiments]

    def whitened(self, differences: Sequence[NDArray[Any]]) -> RealArray:
        """Return differences of all experiments as independent numbers of unit variance, shape (..., n_data)."""
        pairs = zip(self.experiments, differences, strict=True)
        return np.concatenate([experiment.whiten(difference) for experiment, difference in pairs], axis=-1)

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals of all experiments, one after the other; see `Problem`."""
        return self.whitened(self.differences(z))


@dataclass(frozen=True)
class Minimum:
    """A point where the posterior density is highest nearby.

    Attributes
    ----------
    z : array, shape (n,)
        Standard normal coordinates; of unknowns without priors any coordinates.
    residual : array, shape (n_data,)
    jacobian : array, shape (n_data, n)
    converged : bool
    at_bound : bool
        Whether a coordinate lies on its bound.
    history : tuple of (array, float)
        Coordinates and norm of the residual at every evaluation, where these were recorded.
    """

    z: RealArray
    residual: RealArray = field(repr=False)
    jacobian: RealArray = field(repr=False)
    converged: bool = True
    at_bound: bool = False
    history: tuple[tuple[RealArray, float], ...] = field(repr=False, default=())

    @property
    def misfit(self) -> float:
        """Sum of the squared residuals: chi-square of the data; infinite where there is no response."""
        return _or_infinite(float(self.residual @ self.residual))

    @property
    def is_finite(self) -> bool:
        """Whether the model has a response and a derivative there."""
        return bool(np.isfinite(self.cost) and np.all(np.isfinite(self.jacobian)))

    @property
    def norm(self) -> float:
        """Norm of the residual."""
        return float(np.sqrt(self.misfit))

    @property
    def cost(self) -> float:
        """Misfit plus the prior's z^2: minus twice the logarithm of the posterior density."""
        return _or_infinite(float(self.misfit + self.z @ self.z))

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
        """Logarithm of the evidence by Laplace's approximation, without the constant of the whitened data.

        ``ln p(y|z) + ln p(z) + (d/2) ln 2 pi - 1/2 ln |H|``; the prior's normalisation cancels the second constant.
        Minus infinity where there is no response, or no derivative.
        """
        if not self.is_finite:
            return -np.inf
        return float(-0.5 * self.cost - 0.5 * np.linalg.slogdet(self.precision)[1])


def _or_infinite(value: float) -> float:
    return np.inf if np.isnan(value) else value


@dataclass(frozen=True)
class GaussianPrior:
    """A Gaussian prior in place of the unknowns' own, as the posterior of an earlier measurement gives it.

    Coordinates of the unknowns' own priors are ``mean + root u``, u standard normal.

    Attributes
    ----------
    mean : array, shape (d,)
    root : array, shape (d, d)
        Root times its transpose is the covariance.
    """

    mean: RealArray
    root: RealArray

    @classmethod
    def of(cls, minimum: Minimum, *, correlated: bool = False) -> GaussianPrior:
        """Return Laplace's approximation of a posterior, each unknown by itself unless `correlated`.

        Correlations are only as good as the model: an error of the model moves the unknowns in another direction as
        soon as the setup changes. With correlations, intervals come out too narrow on measured plants, see
        ``docs/validation/diagnosis_tubes.md``.
        """
        if correlated:
            return cls(minimum.z, np.asarray(np.linalg.cholesky(minimum.covariance), dtype=float))
        return cls(minimum.z, np.diag(np.sqrt(np.diag(minimum.covariance))))

    def coordinates(self, u: RealArray) -> RealArray:
        """Return coordinates of the unknowns' own priors, shape (..., d), of u of the same shape."""
        return np.asarray(self.mean + u @ self.root.T)


@dataclass(frozen=True)
class Scaled(Problem):
    """A problem whose residuals are divided by a scale, where the model misses the data by more than noise."""

    problem: Problem
    scale: float

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The problem's parameters."""
        return self.problem.parameters

    def reparameterisation(self, z: RealArray, *, far: bool = False) -> Reparameterisation | None:
        """Return that of the problem."""
        return self.problem.reparameterisation(z, far=far)

    def residual(self, z: RealArray) -> RealArray:
        """Return the residuals divided by the scale."""
        return self.problem.residual(z) / self.scale

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative, divided by the scale."""
        residual, jacobian = self.problem.linearised(z)
        return residual / self.scale, jacobian / self.scale


@dataclass(frozen=True)
class Held(Problem):
    """A problem of which some unknowns are held where they are.

    Attributes
    ----------
    problem : Problem
    z : array, shape (n,)
        Coordinates of all unknowns; those of the free ones are not looked at.
    free : array of bool, shape (n,)
    """

    problem: Problem
    z: RealArray
    free: BoolArray

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The free parameters."""
        return tuple(one for one, is_free in zip(self.problem.parameters, self.free, strict=True) if is_free)

    def residual(self, z: RealArray) -> RealArray:
        """Return the problem's residuals at coordinates of the free unknowns."""
        return self.problem.residual(self.all_coordinates(z))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return the problem's residual, and its derivative by the free unknowns."""
        residual, slopes = self.problem.linearised(self.all_coordinates(z))
        return residual, slopes[:, self.free]

    def all_coordinates(self, z: RealArray) -> RealArray:
        """Return coordinates of all unknowns, shape (..., n), of those of the free ones."""
        every = np.broadcast_to(self.z, (*z.shape[:-1], self.z.size)).copy()
        every[..., self.free] = z
        return np.asarray(every)
