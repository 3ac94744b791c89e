"""Priors of parameters, and the standard normal coordinates in which parameters are sought.

Every parameter is a monotonic function of a coordinate z that is normal with mean 0 and variance 1 before the data are
seen. Least squares with z added to the residuals finds the most probable values, nested sampling draws z, and neither
needs to know the kind of prior. (Isoprobabilistic transformation: M. Rosenblatt, Ann. Math. Stat. 23 (1952) 470-472, of
independent parameters.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Self

import numpy as np
from pydantic import Field, model_validator
from scipy.special import ndtr, ndtri

from multilayer.arrays import ArrayLike, IndexArray, RealArray
from multilayer.inference.derivative import central
from multilayer.models import Model

_NARROWEST = 1e-12  # least width of a prior over its values
_EDGE = 8.0  # beyond this z a uniform prior is at its bound to 15 digits


class Prior(Model):
    """The prior of an unknown as a file states it; exactly one of the kinds.

    Attributes
    ----------
    normal : (mean, standard deviation)
    lognormal : (median, standard deviation of the natural logarithm)
    uniform : (low, high)
    loguniform : (low, high)
        Uniform in the logarithm.
    fixed : float
        A known value.
    bounds : (low, high), optional
        Hard limits at which a normal or lognormal prior is truncated.
    """

    normal: tuple[float, float] | None = None
    lognormal: tuple[float, float] | None = None
    uniform: tuple[float, float] | None = None
    loguniform: tuple[float, float] | None = None
    fixed: float | None = None
    bounds: tuple[float, float] | None = None

    @model_validator(mode="after")
    def _one_kind(self) -> Self:
        given = [kind for kind in _KINDS if getattr(self, kind) is not None]
        if len(given) != 1:
            raise ValueError(f"a prior is exactly one of {', '.join(_KINDS)}; given: {', '.join(given) or 'none'}")
        for mistake in _mistakes(self):
            raise ValueError(mistake)
        return self

    @property
    def kind(self) -> str:
        """Name of the kind."""
        return next(kind for kind in _KINDS if getattr(self, kind) is not None)

    @property
    def is_logarithmic(self) -> bool:
        """Whether the prior is one of the logarithm of the value."""
        return self.kind in _LOGARITHMIC

    def value(self, z: ArrayLike) -> RealArray:
        """Return the parameter at standard normal coordinates, any shape."""
        return np.asarray(Priors((self,)).values(np.asarray(z, dtype=float)[..., None])[..., 0])

    def slope(self, z: float) -> float:
        """Return the derivative by the coordinate of the value, or of its logarithm for logarithmic priors."""
        value, slope = central(lambda points: self.value(points[..., 0]), np.array([z]))
        return float(slope[0] / value) if self.is_logarithmic else float(slope[0])

    def coordinate(self, value: ArrayLike) -> RealArray:
        """Return the coordinate of a value; the inverse of `value`, within bounds."""
        v = np.asarray(value, dtype=float)
        if self.fixed is not None:
            return np.zeros(v.shape)
        x = np.log(np.maximum(v, np.finfo(float).tiny)) if self.is_logarithmic else v
        offset, slope = self.line
        inside = (x - offset) / slope
        if self.kind not in _FLAT:
            if self.bounds is None:
                return np.asarray(inside)
            low, high = self.shares
            inside = (ndtr(inside) - low) / (high - low)
        return np.asarray(np.clip(ndtri(np.clip(inside, 0, 1)), -_EDGE, _EDGE))

    @property
    def ends(self) -> tuple[float, float] | None:
        """The least and the largest value of a flat or truncated prior; None of others."""
        return self.uniform or self.loguniform or self.bounds

    @property
    def line(self) -> tuple[float, float]:
        """Offset and slope of the value, or of its logarithm, as a linear function.

        Of the standard normal variable, truncated or not; of the cumulative probability for a uniform prior.
        """
        if self.fixed is not None:
            return self.fixed, 0.0
        pair = getattr(self, self.kind)
        if self.kind in _FLAT:
            low, high = np.log(pair) if self.is_logarithmic else pair
            return float(low), float(high - low)
        return float(np.log(pair[0]) if self.is_logarithmic else pair[0]), pair[1]

    @property
    def shares(self) -> tuple[float, float]:
        """Cumulative probabilities of the two bounds before truncation."""
        assert self.bounds is not None
        centre, spread = self.line
        ends = np.log(np.maximum(self.bounds, 1e-300)) if self.is_logarithmic else np.array(self.bounds)
        low, high = ndtr((ends - centre) / spread)
        return float(low), float(high)


WIDEST = 100.0  # spread of a logarithm: beyond it numbers overflow
_KINDS = ("normal", "lognormal", "uniform", "loguniform", "fixed")
_FLAT, _LOGARITHMIC = ("uniform", "loguniform"), ("lognormal", "loguniform")


def _widths(prior: Prior) -> list[tuple[str, tuple[float, float], float]]:
    """Return kind, numbers and width of priors whose width may be lost beside their values."""
    widths = [("normal", (prior.normal[0], 0.0), prior.normal[1])] if prior.normal is not None else []
    if prior.lognormal is not None:
        widths.append(("lognormal", (1.0, 0.0), prior.lognormal[1]))  # relative
    ends = [(kind, pair) for kind in ("uniform", "loguniform", "bounds") if (pair := getattr(prior, kind)) is not None]
    return widths + [(kind, pair, pair[1] - pair[0]) for kind, pair in ends]


def _mistakes(prior: Prior) -> list[str]:
    mistakes = []
    for kind in ("normal", "lognormal"):
        if (pair := getattr(prior, kind)) is not None and not pair[1] > 0:
            mistakes.append(f"{kind}: the spread {pair[1]:g} must be above 0")
    for kind, pair, spread in _widths(prior):
        if 0 < spread < _NARROWEST * max(abs(end) for end in pair):
            mistakes.append(f"{kind}: {spread:g} is lost in rounding beside {pair[0]:g}; state the value as known")
    if prior.lognormal is not None and not prior.lognormal[0] > 0:
        mistakes.append(f"lognormal: the median {prior.lognormal[0]:g} must be above 0")
    for kind in ("uniform", "loguniform", "bounds"):
        if (pair := getattr(prior, kind)) is not None and not pair[0] < pair[1]:
            mistakes.append(f"{kind}: the lower end {pair[0]:g} must lie below the upper end {pair[1]:g}")
    if prior.loguniform is not None and not prior.loguniform[0] > 0:
        mistakes.append(f"loguniform: the lower end {prior.loguniform[0]:g} must be above 0")
    if prior.bounds is not None and prior.kind not in ("normal", "lognormal"):
        mistakes.append(f"bounds: a {prior.kind} prior needs none")
    if prior.lognormal is not None and prior.lognormal[1] > WIDEST:
        mistakes.append(f"lognormal: the spread {prior.lognormal[1]:g} of ln is above {WIDEST:g}; 1 is a factor of 2.7")
    if prior.bounds is not None and not mistakes:
        low, high = prior.shares
        if not low < high:
            mistakes.append(f"bounds: {prior.bounds[0]:g} to {prior.bounds[1]:g} hold nothing of the prior; widen them")
    return mistakes


class Parameter(Model):
    """An unknown: its name, prior and unit, and whether it is of interest or a nuisance."""

    name: str = Field(min_length=1)
    prior: Prior
    unit: str = ""
    nuisance: bool = False


@dataclass(frozen=True)
class Priors:
    """The priors of some parameters, for coordinates of all of them at once.

    Attributes
    ----------
    priors : tuple of Prior
    names : tuple of str
        Names of the parameters.
    """

    priors: tuple[Prior, ...]
    names: tuple[str, ...] = ()

    @classmethod
    def of(cls, parameters: Sequence[Parameter]) -> Priors:
        """Return the priors of parameters."""
        return cls(
            tuple(parameter.prior for parameter in parameters), tuple(parameter.name for parameter in parameters)
        )

    @cached_property
    def _line(self) -> tuple[RealArray, RealArray]:
        offsets, slopes = np.array([prior.line for prior in self.priors]).reshape(-1, 2).T
        return offsets, slopes

    @cached_property
    def _cut(self) -> tuple[IndexArray, RealArray, RealArray]:
        """Indices of truncated priors, and the cumulative probabilities of their bounds."""
        cut = np.flatnonzero([prior.bounds is not None for prior in self.priors])
        low, high = np.array([self.priors[i].shares for i in cut]).reshape(-1, 2).T
        return cut, low, high

    @cached_property
    def _flat(self) -> IndexArray:
        return np.flatnonzero([prior.kind in _FLAT for prior in self.priors])

    @cached_property
    def _logarithmic(self) -> IndexArray:
        return np.flatnonzero([prior.is_logarithmic for prior in self.priors])

    def values(self, z: ArrayLike) -> RealArray:
        """Return the parameters at standard normal coordinates, both of shape (..., n)."""
        x = np.array(z, dtype=float)
        if self._flat.size:
            x[..., self._flat] = ndtr(x[..., self._flat])
        cut, low, high = self._cut
        if cut.size:
            x[..., cut] = ndtri(low + (high - low) * ndtr(x[..., cut]))
        offsets, slopes = self._line
        values = offsets + slopes * x
        if self._logarithmic.size:
            with np.errstate(over="ignore"):  # a step of a search may lead anywhere: it is refused where it ends
                values[..., self._logarithmic] = np.exp(values[..., self._logarithmic])
        return np.asarray(values)

    def named(self, z: ArrayLike) -> dict[str, RealArray]:
        """Return the parameters by name, each of shape (...), at coordinates of shape (..., n)."""
        values = self.values(z)
        return {name: values[..., i] for i, name in enumerate(self.names)}
