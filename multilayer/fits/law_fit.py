"""Fit of any registered modulus law to complex moduli: relative errors, from many starts, within the passive range."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.inference.derivative import FINE, central
from multilayer.inference.least_squares import trust_region
from multilayer.media.laws import ModulusLaw
from multilayer.media.laws.parameters import Bounds, LawSpace
from multilayer.media.laws.template import law_template

Residual = Callable[[RealArray], RealArray]
_CANDIDATES = 256
_MOST = 400  # evaluations from one start


@dataclass(frozen=True)
class LawFit:
    """A law fitted to moduli.

    Attributes
    ----------
    law : ModulusLaw
    parameters : dict
        Value by name, in SI; entries of lists as ``relaxation_time.0``.
    covariance : array, shape (n, n)
        Of the natural logarithms of `parameters`; zero for those on a bound, NaN where it is not known.
    on_bound : tuple of str
        Parameters that end on a bound of the search or of the passive range.
    frequency, modulus, modelled : array
        Hz; data and law, Pa.
    misfits : array
        Root mean square of the residual that each start ended with, lowest first.
    """

    law: ModulusLaw
    parameters: dict[str, float]
    covariance: RealArray
    on_bound: tuple[str, ...]
    frequency: RealArray
    modulus: ComplexArray
    modelled: ComplexArray
    misfits: RealArray

    @property
    def std(self) -> dict[str, float]:
        """Standard deviations of the parameters, in their units; NaN where there are as many unknowns as data."""
        relative = np.sqrt(np.diag(self.covariance))
        return {name: value * float(s) for (name, value), s in zip(self.parameters.items(), relative, strict=True)}

    @property
    def mean_relative_error(self) -> float:
        """Mean of ``|E_law - E|/|E|``, amount and phase."""
        return float(np.mean(np.abs(self.modelled / self.modulus - 1)))

    @property
    def mean_magnitude_error(self) -> float:
        """Mean of ``||E_law| - |E||/|E|``."""
        return float(np.mean(np.abs(np.abs(self.modelled) / np.abs(self.modulus) - 1)))


def fit_law(
    law: str | type[ModulusLaw] | ModulusLaw,
    frequency: ArrayLike,
    modulus: ArrayLike,
    *,
    relative_std: ArrayLike | None = None,
    elements: int | None = None,
    fixed: Mapping[str, Any] | None = None,
    bounds: Bounds | None = None,
    starts: int = 8,
    seed: int = 0,
) -> LawFit:
    """Fit a modulus law to measured moduli by least squares of ln(E_law/E).

    The real part of that residual is the relative error of abs(E), the imaginary part the error of phase; every decade
    of modulus counts alike. Unknowns are the logarithms of the parameters. A bound that ties two of them (`Limit`) is
    kept by seeking the distance from it instead of the second, so that solutions on the bound are found and no law
    that creates energy is ever tried.

    Parameters
    ----------
    law : str, type or ModulusLaw
        A registered name, a law's class, or a law to start from (its lists say how many elements).
    frequency : array, shape (n,)
        Hz.
    modulus : array, shape (n,)
        E1 + i E2, Pa.
    relative_std : float or array, optional
        Standard deviation of either part over abs(E); without it, estimated from the residual, which tells none where
        there are as many unknowns as data.
    elements : int, optional
        Number of branches or steps of laws that have them.
    fixed : mapping, optional
        Values of fields that are known.
    bounds : mapping, optional
        Least and greatest value by field; by default three decades beyond the data.
    starts : int
        How many of 256 points spread over the bounds are followed, the best ones, besides the law to start from.
    seed : int
        Of the points.

    Returns
    -------
    LawFit

    Raises
    ------
    InputError
        For unknown laws and fields, and data that are no moduli or too few.
    """
    f, e = _checked(frequency, modulus)
    space = LawSpace.of(law_template(law, elements, f), fixed or {}, bounds or {}, f, e)
    weight = 1 / np.broadcast_to(np.asarray(1.0 if relative_std is None else relative_std, dtype=float), f.shape)

    def residual(z: RealArray) -> RealArray:
        ratio = np.log(space.modulus(z, f) / e) * weight
        return np.concatenate([ratio.real, ratio.imag], axis=-1)

    points = space.points(_CANDIDATES, np.random.default_rng(seed))
    best = np.argsort(np.sum(residual(points) ** 2, axis=-1), kind="stable")[:starts]
    found = sorted((_refine(residual, space, z) for z in (space.first(f, e), *points[best])), key=lambda pair: pair[1])
    per_datum = 1.0 if relative_std is not None else _variance(found[0][1], 2 * f.size - space.low.size)
    misfits = np.array([misfit for _, misfit in found]) / np.sqrt(2 * f.size)
    return _result(found[0][0], space, residual, per_datum, misfits, f, e)


def _checked(frequency: ArrayLike, modulus: ArrayLike) -> tuple[RealArray, ComplexArray]:
    f, e = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
    if f.ndim != 1 or f.shape != e.shape or not f.size:
        raise InputError(f"frequency {f.shape} and modulus {e.shape} must be lists of one length")
    good = np.isfinite(f) & np.isfinite(e) & (f > 0) & (e.real > 0)
    if not np.all(good):
        raise InputError(f"entry {int(np.argmin(good)) + 1}: frequency and E1 must be finite and above 0; leave it out")
    return f, e


def _variance(misfit: float, freedom: int) -> float:
    """Return the variance of the residual, of norm `misfit`; NaN where no degree of freedom tells it."""
    return misfit**2 / freedom if freedom > 0 else float("nan")


def _refine(residual: Residual, space: LawSpace, start: RealArray) -> tuple[RealArray, float]:
    """Return the minimum reached from a start, and its misfit (norm of the residual)."""
    margin = 1e-3 * (space.high - space.low)  # a start on a bound would hardly leave it
    inside = np.clip(start, space.low + margin, space.high - margin)
    found = trust_region(lambda z: central(residual, z, FINE), inside, bounds=(space.low, space.high), most=_MOST)
    return found.z, found.norm


def _result(
    z: RealArray,
    space: LawSpace,
    residual: Residual,
    per_datum: float,
    misfits: RealArray,
    f: RealArray,
    e: ComplexArray,
) -> LawFit:
    law, held = space.law(z), space.on_bound(z)
    by_logs, by_residual = (central(function, z, FINE)[1][:, ~held] for function in (space.logs, residual))
    response = by_logs @ np.linalg.pinv(by_residual)
    values = dict(zip(space.names, np.exp(space.logs(z)).tolist(), strict=True))
    on_bound = tuple(name for name, on in zip(space.names, held, strict=True) if on)
    covariance = response @ response.T
    covariance[covariance != 0] *= per_datum
    return LawFit(law, values, covariance, on_bound, f, e, law(f), misfits)
