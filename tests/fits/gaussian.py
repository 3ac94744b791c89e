"""Small inverse problems whose posterior is known in closed form, or by quadrature."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from multilayer.inference.derivative import central
from multilayer.inference.priors import Parameter, Prior
from multilayer.inference.problem import Problem


@dataclass(frozen=True)
class Plain(Problem):
    """A problem made of a function of the coordinates."""

    function: Callable[[np.ndarray], np.ndarray]
    parameters: tuple[Parameter, ...] = ()

    def residual(self, z: np.ndarray) -> np.ndarray:
        return self.function(z)

    def linearised(self, z: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return central(self.residual, z)


def parameters(*priors: Prior, nuisance: bool = False) -> tuple[Parameter, ...]:
    """Return parameters a, b, c..., by default standard normal."""
    return tuple(Parameter(name="abcdefgh"[i], prior=p, nuisance=nuisance) for i, p in enumerate(priors))


def standard(count: int) -> tuple[Parameter, ...]:
    return parameters(*[Prior(normal=(0.0, 1.0))] * count)


def linear(matrix: np.ndarray, measured: np.ndarray, *priors: Prior) -> Plain:
    """Return residuals that are linear in the coordinates: everything of it is Gaussian."""
    a = np.asarray(matrix, dtype=float)
    return Plain(lambda z: z @ a.T - measured, parameters(*priors) if priors else standard(a.shape[1]))


def linear_evidence(matrix: np.ndarray, measured: np.ndarray) -> float:
    """Return ln of the normal density of the data but for the constant of the whitened ones."""
    covariance = matrix @ matrix.T + np.eye(len(measured))
    return float(-0.5 * measured @ np.linalg.solve(covariance, measured) - 0.5 * np.linalg.slogdet(covariance)[1])


def quadrature(problem: Plain, reach: float = 6.0, count: int = 1201) -> tuple[float, np.ndarray, np.ndarray]:
    """Return ln(evidence), the grid, and the marginal densities of a problem with two parameters, shape (2, count)."""
    grid = np.linspace(-reach, reach, count)
    z = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1)
    density = np.exp(-0.5 * np.sum(problem.residual(z) ** 2, axis=-1) - 0.5 * np.sum(z**2, axis=-1)) / (2 * np.pi)
    step = grid[1] - grid[0]
    total = density.sum() * step**2
    return float(np.log(total)), grid, np.stack([density.sum(axis=1), density.sum(axis=0)]) * step / total


def quantiles(grid: np.ndarray, density: np.ndarray, *levels: float) -> np.ndarray:
    below = np.cumsum(density) / density.sum()
    return np.interp(levels, below, grid)
