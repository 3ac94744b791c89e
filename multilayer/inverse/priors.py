"""What is known of a parameter before the measurement, and the standard normal coordinate it is sought in.

Every parameter is a monotonic function of a coordinate z that is normal with mean 0 and variance 1 before the data are
seen. Least squares with the row ``z`` added finds the most probable values, nested sampling draws z, and neither
knows what kind of prior there is.
"""

from __future__ import annotations

from typing import Any, Self

import numpy as np
from pydantic import Field, model_validator
from scipy.special import ndtr, ndtri

from multilayer.arrays import ArrayLike, RealArray
from multilayer.models import Model

_EDGE = 8.0  # beyond this z a uniform prior is at its bound to 15 digits


class Prior(Model):
    """What a file says of an unknown; exactly one of the kinds.

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
        Hard limits of a normal or lognormal prior, which is cut there.
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
        for problem in _problems(self):
            raise ValueError(problem)
        return self

    @property
    def kind(self) -> str:
        """Name of the kind."""
        return next(kind for kind in _KINDS if getattr(self, kind) is not None)

    def value(self, z: ArrayLike) -> RealArray:
        """Return the parameter at standard normal coordinates, any shape."""
        x = np.asarray(z, dtype=float)
        if self.fixed is not None:
            return np.full(x.shape, self.fixed)
        if self.uniform is not None or self.loguniform is not None:
            low, high = self._ends()
            share = low + (high - low) * ndtr(x)
            return np.asarray(np.exp(share) if self.loguniform is not None else share)
        centre, spread = self._centre()
        inside = centre + spread * (x if self.bounds is None else self._cut(x))
        return np.asarray(np.exp(inside) if self.lognormal is not None else inside)

    def coordinate(self, value: ArrayLike) -> RealArray:
        """Return the coordinate of a value; the inverse of `value`, within bounds."""
        v = np.asarray(value, dtype=float)
        if self.fixed is not None:
            return np.zeros(v.shape)
        logarithmic = self.lognormal is not None or self.loguniform is not None
        x = np.log(np.maximum(v, np.finfo(float).tiny)) if logarithmic else v
        if self.uniform is not None or self.loguniform is not None:
            low, high = self._ends()
            return np.asarray(np.clip(ndtri(np.clip((x - low) / (high - low), 0, 1)), -_EDGE, _EDGE))
        centre, spread = self._centre()
        inside = (x - centre) / spread
        if self.bounds is None:
            return np.asarray(inside)
        low, high = self._shares()
        return np.asarray(np.clip(ndtri(np.clip((ndtr(inside) - low) / (high - low), 0, 1)), -_EDGE, _EDGE))

    def _centre(self) -> tuple[float, float]:
        if self.lognormal is not None:
            return float(np.log(self.lognormal[0])), self.lognormal[1]
        assert self.normal is not None
        return self.normal

    def _ends(self) -> tuple[float, float]:
        if self.loguniform is not None:
            return float(np.log(self.loguniform[0])), float(np.log(self.loguniform[1]))
        assert self.uniform is not None
        return self.uniform

    def _shares(self) -> tuple[float, float]:
        """Return the probabilities below the two bounds, uncut."""
        assert self.bounds is not None
        centre, spread = self._centre()
        ends = np.log(np.maximum(self.bounds, 1e-300)) if self.lognormal is not None else np.array(self.bounds)
        low, high = ndtr((ends - centre) / spread)
        return float(low), float(high)

    def _cut(self, x: RealArray) -> RealArray:
        low, high = self._shares()
        return np.asarray(ndtri(low + (high - low) * ndtr(x)))


_KINDS = ("normal", "lognormal", "uniform", "loguniform", "fixed")


def _problems(prior: Prior) -> list[str]:
    said = []
    for kind in ("normal", "lognormal"):
        if (pair := getattr(prior, kind)) is not None and not pair[1] > 0:
            said.append(f"{kind}: the spread {pair[1]:g} must be above 0")
    if prior.lognormal is not None and not prior.lognormal[0] > 0:
        said.append(f"lognormal: the median {prior.lognormal[0]:g} must be above 0")
    for kind in ("uniform", "loguniform", "bounds"):
        if (pair := getattr(prior, kind)) is not None and not pair[0] < pair[1]:
            said.append(f"{kind}: the lower end {pair[0]:g} must lie below the upper end {pair[1]:g}")
    if prior.loguniform is not None and not prior.loguniform[0] > 0:
        said.append(f"loguniform: the lower end {prior.loguniform[0]:g} must be above 0")
    if prior.bounds is not None and prior.kind not in ("normal", "lognormal"):
        said.append(f"bounds: a {prior.kind} prior needs none")
    return said


class Parameter(Model):
    """An unknown: its name, what is known of it, its unit, and whether it is of interest or a nuisance."""

    name: str = Field(min_length=1)
    prior: Prior
    unit: str = ""
    nuisance: bool = False


def values_of(parameters: tuple[Parameter, ...], z: ArrayLike) -> dict[str, Any]:
    """Return parameters by name, each of shape (...), at coordinates of shape (..., n)."""
    x = np.asarray(z, dtype=float)
    return {parameter.name: parameter.prior.value(x[..., i]) for i, parameter in enumerate(parameters)}
