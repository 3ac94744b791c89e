"""Profile likelihood: the least cost along one parameter, all others being fitted at each of its values.

No Gaussian is supposed along that parameter, only across it: curved and one-sided posteriors come out right as long as
the other parameters are nearly Gaussian. Identifiability by profiles: A. Raue et al., Bioinformatics 25 (2009)
1923-1929.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.interpolate import Akima1DInterpolator, CubicSpline

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeded
from multilayer.errors import InputError
from multilayer.inference.least_squares import minimise
from multilayer.inference.posterior import Posterior, covariance_root, index_of
from multilayer.inference.problem import Held, Minimum, Problem

_HIGHEST = 12.0  # rise of the cost where a walk ends: 3.5 standard deviations
_RISE = 0.5  # of the root of the cost, from point to point
_STEEPEST = 1.5 * _RISE
_SHORTEST = 1e-2  # step beside a standard deviation by the curvature
_MOST = 60  # points to either side
_FINE = 2001
_DRAWS = 2000
_SIGNIFICANT = 1.0  # rise of the cost, without the parameter's own prior, above which an end of the profile is not open


@dataclass(frozen=True, eq=False)
class Profile(Posterior):
    """A posterior from the profile along one parameter.

    Attributes
    ----------
    name : str
        Of that parameter.
    z : array, shape (n_points,)
        The parameter's coordinates, rising.
    cost : array, shape (n_points,)
        Least misfit plus priors, all other parameters being free.
    misfit : array, shape (n_points,)
        The misfit in `cost`.
    marginal : array, shape (2, n_fine)
        Coordinates along the profile, and the cumulative probability there.
    """

    name: str
    z: RealArray = field(repr=False)
    cost: RealArray = field(repr=False)
    misfit: RealArray = field(repr=False)
    marginal: RealArray = field(repr=False)

    def coordinate_quantile(self, index: int, probability: float) -> float:
        """Return a quantile of one coordinate; that of the profiled parameter without sampling."""
        if index != self.index(self.name):
            return super().coordinate_quantile(index, probability)
        return float(np.interp(probability, self.marginal[1], self.marginal[0]))

    @property
    def best(self) -> float:
        """The parameter's value where the profile is lowest, in its unit; it may be lower than the minimum."""
        return float(self.values[np.argmin(self.cost)])

    @property
    def values(self) -> RealArray:
        """The parameter's values at the points of the profile, in its unit."""
        return self.parameters[self.index(self.name)].prior.value(self.z)

    @property
    def open_ends(self) -> tuple[bool, bool]:
        """Whether only the parameter's own prior limits it downwards, and upwards.

        Neither the data nor the priors of the other parameters then exclude values further out.
        """
        others = self.cost - self.z**2
        rise = others[[0, -1]] - others[np.argmin(self.cost)]
        return bool(rise[0] < _SIGNIFICANT), bool(rise[1] < _SIGNIFICANT)

    def confidence(self, probability: float = 0.9) -> tuple[float, float]:
        """Return the ends of the likelihood-ratio interval, in the parameter's unit, prior included.

        All values whose cost is within the quantile of chi-square with one degree of freedom; of several ranges the
        outermost ends. S. S. Wilks, Ann. Math. Stat. 9 (1938) 60-62.
        """
        if not 0 < probability < 1:
            raise InputError(f"a probability of {probability:g} is not allowed; it must lie between 0 and 1")
        fine = np.linspace(self.z[0], self.z[-1], _FINE)
        rise = _between(self.z, self.cost)(fine)
        inside = fine[rise - rise.min() <= exceeded(1 - probability, 1)]
        ends = self.parameters[self.index(self.name)].prior.value(inside[[0, -1]])
        return float(ends[0]), float(ends[1])

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, with the profile itself."""
        points = {"name": self.name, "value": self.values, "cost": self.cost, "misfit": self.misfit}
        plain = {key: v.tolist() if isinstance(v, np.ndarray) else v for key, v in points.items()}
        return super().to_dict() | {"profile": plain | {"open_ends": list(self.open_ends)}}


def profile_likelihood(
    problem: Problem, minimum: Minimum, parameter: int | str, *, draws: int = _DRAWS, seed: int = 0
) -> Profile:
    """Return the profile along one parameter, from a minimum outwards until the cost has risen by 12 at both ends.

    Parameters
    ----------
    problem : Problem
    minimum : Minimum
    parameter : int or str
        Index or name.
    draws : int
        Number of samples.
    seed : int

    Notes
    -----
    Samples are drawn along the profile with the density ``exp(-cost/2) |H|^(-1/2)``, H being the Hessian of all others,
    and across it from their Gaussian: L. Tierney & J. B. Kadane, J. Am. Stat. Assoc. 81 (1986) 82-86. The evidence is
    the integral of that density; its error is not known.

    Raises
    ------
    InputError
        For a parameter that does not exist.
    """
    index = index_of(problem.parameters, parameter) if isinstance(parameter, str) else parameter
    if not 0 <= index < len(problem.parameters):
        raise InputError(f"there is no parameter {index}; there are {len(problem.parameters)}, from 0")
    down, up = (_walk(problem, minimum, index, side) for side in (-1, 1))
    points = [*reversed(down), (float(minimum.z[index]), _others(minimum, index)), *up]
    marginal, evidence = _marginal(points)
    rng = np.random.default_rng(seed)
    along = np.interp(rng.random(draws), marginal[1], marginal[0])
    samples = np.insert(_across(points, along, rng), index, along, axis=1)
    z = np.array([at for at, _ in points])
    misfit = np.array([others.misfit for _, others in points])
    cost = np.array([others.cost for _, others in points]) + z**2
    name, error = problem.parameters[index].name, float("nan")
    return Profile("profile", problem.parameters, samples, evidence, error, name, z, cost, misfit, marginal)


def _others(minimum: Minimum, index: int) -> Minimum:
    """Return a minimum as that of the other parameters alone."""
    z, slopes = np.delete(minimum.z, index), np.delete(minimum.jacobian, index, axis=1)
    return Minimum(z, minimum.residual, slopes, minimum.converged)


def _walk(problem: Problem, minimum: Minimum, index: int, side: int) -> list[tuple[float, Minimum]]:
    """Return coordinates and minima of the other parameters, from the minimum to one side."""
    covariance = minimum.covariance
    spread = float(np.sqrt(covariance[index, index]))
    at, others, lowest = float(minimum.z[index]), _others(minimum, index), minimum.cost
    # how the others move per unit of this coordinate: first by Laplace's covariance, then as in the last step
    slope = np.delete(covariance[:, index], index) / covariance[index, index]
    step, root, points = _RISE * spread, 0.0, []
    free = np.arange(minimum.z.size) != index
    for _ in range(_MOST):
        there = at + side * step
        held = Held(problem, np.insert(others.z, index, there), free)
        moved = _least(held, others.z + side * step * slope)
        climbed = np.sqrt(max(moved.cost + there**2 - lowest, 0.0)) - root
        if moved.is_finite and climbed > _STEEPEST and step > _SHORTEST * spread:
            step = max(step * _RISE / climbed, _SHORTEST * spread)  # what lies between may rise at once
            continue
        slope = (moved.z - others.z) / (there - at)
        at, others = there, moved
        cost = others.cost + at**2
        if not others.is_finite:  # the model ends here, and the profile with it
            break
        points.append((at, others))
        lowest = min(lowest, cost)
        if cost - lowest >= _HIGHEST:
            break
        climbed, root = abs(np.sqrt(cost - lowest) - root), np.sqrt(cost - lowest)
        step *= float(np.clip(_RISE / max(climbed, 1e-3), 0.5, 2.0))
    return points


def _least(problem: Held, start: RealArray) -> Minimum:
    """Return the minimum of the other parameters, if there are any."""
    if start.size:
        return minimise(problem, start)
    values = problem.residual(start)
    return Minimum(start, values, np.empty((values.size, 0)))


def _marginal(points: list[tuple[float, Minimum]]) -> tuple[RealArray, float]:
    """Return coordinates with their cumulative probabilities, and the logarithm of the evidence."""
    z = np.array([at for at, _ in points])
    fine = np.linspace(z[0], z[-1], _FINE)
    logs = [-0.5 * (m.cost + at**2 + np.linalg.slogdet(m.precision)[1] + np.log(2 * np.pi)) for at, m in points]
    density = _between(z, np.array(logs))(fine)
    height = np.exp(density - density.max())
    below = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(fine) * (height[1:] + height[:-1]))])
    return np.stack([fine, below / below[-1]]), float(density.max() + np.log(below[-1]))


def _between(z: RealArray, values: RealArray) -> Akima1DInterpolator:
    """Return the interpolation of values along a profile, which steep ones do not make swing far away."""
    return Akima1DInterpolator(z, values, method="makima")


def _across(points: list[tuple[float, Minimum]], along: RealArray, rng: np.random.Generator) -> RealArray:
    """Return samples of the other coordinates at points of the profile, by their Gaussian there."""
    z = np.array([at for at, _ in points])
    path = CubicSpline(z, np.array([others.z for _, others in points]))(along)
    roots = np.array([covariance_root(others) for _, others in points])
    # the nearest point's covariance: it changes little from point to point
    nearest = np.argmin(np.abs(along[:, None] - z), axis=1)
    return np.asarray(path + np.einsum("kij,kj->ki", roots[nearest], rng.standard_normal(path.shape)))
