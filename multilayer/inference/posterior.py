"""The posterior: samples, intervals in the parameters' units, bands of curves, evidence.

Three methods give a `Posterior`: Gaussians about the minima (`laplace`, here), the profile along one parameter
(`profile.profile_likelihood`) and nested sampling (`nested_sampling.nested`). Laplace's approximation: L. Tierney &
J. B. Kadane, J. Am. Stat. Assoc. 81 (1986) 82-86; R. E. Kass & A. E. Raftery, J. Am. Stat. Assoc. 90 (1995) 773-795.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import brentq
from scipy.special import logsumexp, ndtr, ndtri

from multilayer.arrays import RealArray
from multilayer.errors import InputError, suggest
from multilayer.inference.derivative import WIDE, forward
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Problem

Curve = Callable[[RealArray], RealArray]
_DRAWS = 2000
_CHECKED = 256
_CHUNK = 64  # points of a batched call: as fast as more of them, in little memory
_SAME_MODE = 2.0  # equal Gaussians whose centres are nearer than two standard deviations have a single maximum
_NEGLIGIBLE = 30.0  # below the best in ln(evidence)
_LEVELS = (0.68, 0.90)
_BEYOND = 1e-6
_TAIL = 0.05  # probability beyond either end of an interval of 90 %
_OFF, _OFF_BY = 3.3, 0.4  # standard errors, and share of itself, by which that probability must be another by points
_MORE = 8  # times as many points are drawn for those
_FEW = 5  # points beyond an end, fewer than which tell too little
_LEAST_SHARE = 0.6  # effective share below which points are too few to know better


class Band(NamedTuple):
    """Pointwise quantiles of a curve, each of the curve's shape; none of them need be a possible curve."""

    low: RealArray
    median: RealArray
    high: RealArray


@dataclass(frozen=True, eq=False)
class Posterior:
    """What is known of the parameters after the measurement.

    Attributes
    ----------
    method : str
        Name of the method that gave it.
    parameters : tuple of Parameter
    samples : array, shape (n_samples, n)
        Standard normal coordinates, of equal weight.
    log_evidence : float
        Logarithm of the probability of the data, without the constant of the whitened data; as
        `Minimum.log_evidence`.
    log_evidence_error : float
        Standard deviation of the log evidence; NaN where it is not known.
    """

    method: str
    parameters: tuple[Parameter, ...]
    samples: RealArray = field(repr=False)
    log_evidence: float
    log_evidence_error: float

    def index(self, name: str) -> int:
        """Return the index of a parameter.

        Raises
        ------
        InputError
            When there is none of that name.
        """
        return index_of(self.parameters, name)

    def coordinate_quantile(self, index: int, probability: float) -> float:
        """Return a quantile of one standard normal coordinate."""
        return float(np.quantile(self.samples[:, index], probability))

    def interval(self, name: str, probability: float = 0.9) -> tuple[float, float]:
        """Return the ends of a central interval, in the parameter's unit.

        Parameters
        ----------
        name : str
        probability : float
            Of the parameter to lie within; below and above the interval are equally probable.
        """
        index, p = self.index(name), _checked(probability)
        ends = (self.coordinate_quantile(index, q) for q in (0.5 - p / 2, 0.5 + p / 2))
        # monotonic: the quantile of the value is the value of the quantile
        low, high = (float(self.parameters[index].prior.value(z)) for z in ends)
        return low, high

    def median(self, name: str) -> float:
        """Return the median, in the parameter's unit."""
        index = self.index(name)
        return float(self.parameters[index].prior.value(self.coordinate_quantile(index, 0.5)))

    def band(self, function: Curve, probability: float = 0.9) -> Band:
        """Return the pointwise interval of a curve.

        Parameters
        ----------
        function : callable
            Maps coordinates of shape (m, n) to real values of shape (m, ...).
        probability : float
            Of each point of the curve to lie within.
        """
        return _quantiles(_values(function, self.samples), _checked(probability))

    def curves(self, function: Curve, count: int, rng: np.random.Generator) -> RealArray:
        """Return `count` equally probable curves, shape (count, ...)."""
        return _values(function, self.samples[rng.integers(len(self.samples), size=count)])

    @property
    def covariance(self) -> RealArray:
        """Covariance of the coordinates, shape (n, n)."""
        return np.atleast_2d(np.cov(self.samples, rowvar=False))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON: medians and intervals, and not the samples."""
        return {
            "method": self.method,
            "log_evidence": self.log_evidence,
            "log_evidence_error": None if np.isnan(self.log_evidence_error) else self.log_evidence_error,
            "n_samples": len(self.samples),
            "parameters": [self._entry(parameter) for parameter in self.parameters],
        }

    def _entry(self, parameter: Parameter) -> dict[str, Any]:
        name = parameter.name
        intervals = {f"interval_{100 * p:.0f}": list(self.interval(name, p)) for p in _LEVELS}
        described = {"name": name, "unit": parameter.unit, "nuisance": parameter.nuisance}
        return {**described, "median": self.median(name), **intervals}


@dataclass(frozen=True, eq=False)
class GaussianMixture(Posterior):
    """Laplace's approximation: one Gaussian per minimum, weighted by its evidence.

    Attributes
    ----------
    weights : array, shape (n_minima,)
        Probability of each minimum.
    means : array, shape (n_minima, n)
        Of the coordinates.
    roots : array, shape (n_minima, n, n)
        Their covariances are ``root root^T``.
    effective_share : float
        Effective sample size of importance sampling over the number of draws: 1 where the posterior is Gaussian, near 0
        where the approximation is not to be trusted; NaN where it is not known.
    marginals : mapping of array, shape (2, n_points)
        By index, of coordinates whose intervals the Gaussians misplace: points by importance sampling, rising, and the
        cumulative probability there.
    """

    weights: RealArray
    means: RealArray = field(repr=False)
    roots: RealArray = field(repr=False)
    effective_share: float = float("nan")
    marginals: Mapping[int, RealArray] = field(repr=False, default_factory=dict)

    def coordinate_quantile(self, index: int, probability: float) -> float:
        """Return a quantile of one coordinate, from the mixture itself rather than from samples of it.

        From `marginals` where these know better.
        """
        if index in self.marginals:
            points, below = self.marginals[index]
            return float(np.interp(probability, below, points))
        centres, spreads = self.means[:, index], np.linalg.norm(self.roots[:, index], axis=-1)
        ends = centres + spreads * ndtri(probability)
        if len(ends) == 1:
            return float(ends[0])
        # the quantile lies between those of the components, within rounding
        low, high = float(ends.min() - _BEYOND), float(ends.max() + _BEYOND)
        share = self.weights / self.weights.sum()
        return float(brentq(lambda z: share @ ndtr((z - centres) / spreads) - probability, low, high))

    def band(self, function: Curve, probability: float = 0.9) -> Band:
        """Return the pointwise interval of a curve, which is taken as linear about each minimum.

        Laplace's Gaussian is tangential to a posterior that may be curved. A curve that the data determine well,
        although its parameters are correlated, follows the tangent, whereas draws from the Gaussian would leave the
        valley.
        """
        p = _checked(probability)
        if len(self.means) == 1:
            value, slopes = self._tangent(function, self.means[0], self.roots[0])
            reach = ndtri(0.5 + p / 2) * np.linalg.norm(slopes, axis=0)
            return Band(value - reach, value, value + reach)
        return _quantiles(self.curves(function, _DRAWS, np.random.default_rng(0)), p)

    def curves(self, function: Curve, count: int, rng: np.random.Generator) -> RealArray:
        """Return about `count` equally probable curves, the curve taken as linear about each minimum."""
        counts, n = np.round(count * self.weights / self.weights.sum()).astype(int), self.means.shape[1]
        if not counts.any():  # one curve of several minima
            counts[np.argmax(self.weights)] = count
        drawn = []
        for share, mean, root in zip(counts, self.means, self.roots, strict=True):
            if share:
                value, slopes = self._tangent(function, mean, root)
                drawn.append(value + np.tensordot(rng.standard_normal((share, n)), slopes, 1))
        return np.concatenate(drawn)

    def _tangent(self, function: Curve, mean: RealArray, root: RealArray) -> tuple[RealArray, RealArray]:
        """Return a curve at a minimum, and its change along the columns of `root`, shape (n, ...)."""
        # one-sided as the Jacobian behind `root`: where a parameter is on its bound the two sides differ
        value, slopes = forward(partial(_values, function), mean, WIDE, root.T)
        return value, np.moveaxis(slopes, -1, 0)

    @property
    def covariance(self) -> RealArray:
        """Covariance of the coordinates: within the components, and between them."""
        apart = self.means - self.weights @ self.means
        within = np.einsum("k,kil,kjl->ij", self.weights, self.roots, self.roots)
        return np.asarray(within + np.einsum("k,ki,kj->ij", self.weights, apart, apart))

    def log_density(self, z: RealArray) -> RealArray:
        """Return the logarithm of the density at coordinates of shape (m, n)."""
        parts = []
        for mean, root in zip(self.means, self.roots, strict=True):
            white = np.linalg.solve(root, (z - mean).T)
            parts.append(-0.5 * np.sum(white**2, axis=0) - np.linalg.slogdet(root)[1])
        normal = np.stack(parts, axis=-1) - 0.5 * z.shape[-1] * np.log(2 * np.pi)
        return np.asarray(logsumexp(normal, b=self.weights, axis=-1))

    def draw(self, count: int, rng: np.random.Generator) -> RealArray:
        """Return points drawn from the mixture, shape (count, n)."""
        chosen = rng.choice(len(self.weights), size=count, p=self.weights / self.weights.sum())
        normal = rng.standard_normal((count, self.means.shape[1]))
        return np.asarray(self.means[chosen] + np.einsum("kij,kj->ki", self.roots[chosen], normal))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON, with the probability of each minimum."""
        share = None if np.isnan(self.effective_share) else self.effective_share
        return super().to_dict() | {"minima": self.weights.tolist(), "effective_share": share}


def laplace(
    problem: Problem,
    minima: Minimum | Sequence[Minimum],
    *,
    draws: int = _DRAWS,
    checked: int = _CHECKED,
    seed: int = 0,
) -> GaussianMixture:
    """Return Laplace's approximation, a Gaussian about each minimum in proportion to its evidence.

    Parameters
    ----------
    problem : Problem
    minima : Minimum or sequence of Minimum
        As `least_squares.search` returns them. Of several minima of one mode only the best counts.
    draws : int
        Number of samples.
    checked : int
        For how many points drawn from the mixture the exact density is computed, which gives the error of the
        evidence, and shows where intervals are misplaced; 0 for none.
    seed : int

    Notes
    -----
    The evidence's error is the root of the sum of squares of its difference from importance sampling (J. Geweke,
    Econometrica 57 (1989) 1317-1339) and of the standard error of the latter. A coordinate of which these points have
    less or more than 5 % beyond an end of its interval of 90 %, beyond chance, takes its quantiles from them.

    Raises
    ------
    InputError
        Without a minimum.
    """
    chosen = distinct_modes([minima] if isinstance(minima, Minimum) else minima)
    if not chosen:
        raise InputError("there is no minimum to approximate; search again, from more starts")
    evidence = np.array([minimum.log_evidence for minimum in chosen])
    total = float(logsumexp(evidence))
    means, roots = np.array([m.z for m in chosen]), np.array([covariance_root(m) for m in chosen])
    nothing, unknown = np.empty((0, means.shape[1])), float("nan")
    mixture = GaussianMixture(
        "laplace", problem.parameters, nothing, total, unknown, np.exp(evidence - total), means, roots
    )  # fmt: skip
    rng = np.random.default_rng(seed)
    mixture = replace(mixture, samples=mixture.draw(draws, rng))
    if not checked:
        return mixture
    points = mixture.draw(checked, rng)
    ratios = log_posterior(problem, points) - mixture.log_density(points)
    error, share = _check(mixture, ratios)
    mixture = replace(mixture, log_evidence_error=error, effective_share=share)
    if share < _LEAST_SHARE or not (found := _misplaced(mixture, points, ratios)):
        return mixture
    # others than those that told it, which would exaggerate, and more
    points = mixture.draw(_MORE * checked, rng)
    ratios = log_posterior(problem, points) - mixture.log_density(points)
    return replace(mixture, marginals={index: _marginal(points[:, index], ratios) for index in found})


def mixed_band(parts: Sequence[tuple[float, Posterior, Curve]], probability: float) -> Band:
    """Return the pointwise interval of a curve, averaged over models.

    Parameters
    ----------
    parts : sequence of (weight, posterior, curve)
        Probability of each model, the posterior of its coordinates, and the curve as a function of these.
    probability : float
        Of each point of the curve to lie within.

    Notes
    -----
    J. A. Hoeting, D. Madigan, A. E. Raftery & C. T. Volinsky, Stat. Sci. 14 (1999) 382-417.
    """
    if len(parts) == 1:
        _, posterior, function = parts[0]
        return posterior.band(function, probability)
    p, rng = _checked(probability), np.random.default_rng(0)
    total = sum(weight for weight, _, _ in parts)
    counts = [round(_DRAWS * weight / total) for weight, _, _ in parts]
    drawn = [
        posterior.curves(function, count, rng)
        for count, (_, posterior, function) in zip(counts, parts, strict=True)
        if count
    ]
    return _quantiles(np.concatenate(drawn), p)


def covariance_root(minimum: Minimum) -> RealArray:
    """Return R of covariance = R R^T, from the precision: its inverse may be indefinite by rounding."""
    return np.asarray(np.linalg.inv(np.linalg.cholesky(minimum.precision)).T)


def distinct_modes(minima: Sequence[Minimum]) -> list[Minimum]:
    """Return the best minimum of every mode of the density that is not negligible, the most probable mode first."""
    modes: list[Minimum] = []
    best = max((minimum.log_evidence for minimum in minima), default=0.0)
    for minimum in sorted((m for m in minima if m.log_evidence > best - _NEGLIGIBLE), key=lambda m: m.cost):
        apart = (minimum.z - other.z for other in modes)
        if all(d @ other.precision @ d > _SAME_MODE**2 for d, other in zip(apart, modes, strict=True)):
            modes.append(minimum)
    return sorted(modes, key=lambda m: -m.log_evidence)


def log_posterior(problem: Problem, z: RealArray) -> RealArray:
    """Return the logarithm of likelihood times prior, shape (m,), of coordinates of shape (m, n).

    Its integral is the evidence; -infinity where the model has no response.
    """
    parts = [np.sum(problem.residual(z[i : i + _CHUNK]) ** 2, axis=-1) for i in range(0, len(z), _CHUNK)]
    value = -0.5 * (np.concatenate(parts) + np.sum(z**2, axis=-1) + z.shape[-1] * np.log(2 * np.pi))
    return np.where(np.isnan(value), -np.inf, value)


def index_of(parameters: Sequence[Parameter], name: str) -> int:
    """Return the index of a parameter; an `InputError` with the nearest name when there is none."""
    names = [parameter.name for parameter in parameters]
    if name not in names:
        raise InputError(f"there is no parameter '{name}'; {suggest(name, names)}")
    return names.index(name)


def _check(mixture: GaussianMixture, ratios: RealArray) -> tuple[float, float]:
    """Return the error of the evidence and the effective share of points, by their densities over the mixture's."""
    exact, count = float(logsumexp(ratios)) - np.log(len(ratios)), len(ratios)
    share = float(np.exp(2 * logsumexp(ratios) - logsumexp(2 * ratios))) / count
    scatter = (1 / share - 1) / count
    return float(np.hypot(exact - mixture.log_evidence, np.sqrt(max(scatter, 0.0)))), share


def _misplaced(mixture: GaussianMixture, points: RealArray, ratios: RealArray) -> list[int]:
    """Return the coordinates whose intervals a mixture misplaces, by points drawn from it, shape (m, n)."""
    weights, found = np.exp(ratios - logsumexp(ratios)), []
    for index, column in enumerate(points.T):
        low, high = (mixture.coordinate_quantile(index, q) for q in (_TAIL, 1 - _TAIL))
        if any(_is_off(len(weights) * weights[inside]) for inside in (column < low, column > high)):
            found.append(index)
    return found


def _marginal(column: RealArray, ratios: RealArray) -> RealArray:
    """Return a coordinate of points, rising, and the cumulative probability there, shape (2, m)."""
    order, weights = np.argsort(column), np.exp(ratios - logsumexp(ratios))
    return np.stack([column[order], np.cumsum(weights[order]) - weights[order] / 2])


def _is_off(ratios: RealArray) -> bool:
    """Tell whether a posterior over its approximation, at points beyond an end of an interval, is not 1 in the mean."""
    if len(ratios) < _FEW:
        return False
    error = float(np.std(ratios, ddof=1)) / np.sqrt(len(ratios))
    return bool(abs(np.mean(ratios) - 1) > max(_OFF * error, _OFF_BY))


def _values(function: Curve, z: RealArray) -> RealArray:
    values = np.concatenate([np.asarray(function(z[i : i + _CHUNK])) for i in range(0, len(z), _CHUNK)])
    if np.iscomplexobj(values):
        raise InputError("a complex curve has no quantiles; take its real part, imaginary part, amount or phase")
    return values


def _quantiles(values: RealArray, p: float) -> Band:
    return Band(*np.quantile(values, [0.5 - p / 2, 0.5, 0.5 + p / 2], axis=0))


def _checked(probability: float) -> float:
    if not 0 < probability < 1:
        raise InputError(f"a probability of {probability:g} is not allowed; it must lie between 0 and 1")
    return probability
