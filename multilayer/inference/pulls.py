"""Pulls of nuisance parameters: by how many stated standard deviations a solution moves what a laboratory states.

L. Demortier & L. Lyons, Everything you always wanted to know about pulls, CDF note 5776, Fermilab 2002.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from multilayer.arrays import BoolArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.inference.priors import Parameter
from multilayer.number_text import with_unit

SIGNIFICANT = 0.01  # probability below which what is stated is taken for wrong
_FAR = 3.0  # standard deviations
_TOLD = 0.05  # of the stated variance: what the data take of it at least, for the pull to be tested


class Pull(NamedTuple):
    """A stated quantity, by how many of its stated standard deviations a solution moves it, and chance would."""

    parameter: Parameter
    deviations: float
    by_chance: float = 1.0

    @property
    def in_words(self) -> str:
        """By how much the quantity is off, with its unit."""
        prior, unit = self.parameter.prior, self.parameter.unit
        if prior.lognormal is not None:
            ratio, size = np.exp(self.deviations * prior.lognormal[1]), np.exp(prior.lognormal[1])
            how_far = f"a factor of {ratio:.3g}, stated {size:.3g}"
        else:
            spread = prior.normal[1] if prior.normal else 1.0
            value, size = (_amount(deviations * spread, unit) for deviations in (self.deviations, 1.0))
            how_far = f"{value}, stated {size}"
        name = self.parameter.name.removeprefix("layers.")
        return f"{name} by {abs(self.deviations):.3g} standard deviations ({how_far})"

    @property
    def beside_chance(self) -> str:
        """By how much the quantity is off, and what chance makes of that."""
        return f"{self.in_words}, {abs(self.deviations) / self.by_chance:.3g} times what chance makes of it"


def _amount(value: float, unit: str) -> str:
    shown, factor = {"s": ("us", 1e6), "m": ("mm", 1e3), "": ("%", 100.0)}.get(unit, ("", 1.0))
    return f"{factor * value:.3g} {shown}" if shown else with_unit(value, unit)


def _nuisances(parameters: Sequence[Parameter]) -> BoolArray:
    return np.array([parameter.nuisance for parameter in parameters], dtype=bool)


def stated_pulls(parameters: Sequence[Parameter], z: RealArray) -> RealArray:
    """Return the pulls of all stated quantities, shape (k,)."""
    return np.asarray(z[_nuisances(parameters)])


def stated_values(parameters: Sequence[Parameter], z: RealArray, covariance: RealArray) -> tuple[RealArray, RealArray]:
    """Return the pulls of all stated quantities, shape (k,), and their covariance."""
    stated = _nuisances(parameters)
    return z[stated], covariance[np.ix_(stated, stated)]


def nuisance_p_value(parameters: Sequence[Parameter], z: RealArray) -> float:
    """Return the probability that all stated quantities together are as far off by chance as at `z`.

    This is tested apart from the misfit: beside hundreds of data even an error of many standard deviations in one
    stated quantity would go unnoticed.

    Parameters
    ----------
    parameters : sequence of Parameter
        Those marked as nuisances count.
    z : array, shape (n,)
        Standard normal coordinates.
    """
    pulls = stated_pulls(parameters, z)
    return exceeding(float(pulls @ pulls), len(pulls)) if len(pulls) else 1.0


def spreads_by_chance(covariance: RealArray) -> RealArray:
    """Return the standard deviations of pulls where all is as stated; infinite where the data hardly tell a quantity.

    A solution is then spread about what is stated by ``1 - C``, C being its covariance, in coordinates of unit prior.

    Parameters
    ----------
    covariance : array, shape (k, k)
        Of the stated quantities' coordinates.
    """
    variance = 1 - np.diag(covariance)
    return np.sqrt(np.where(variance >= _TOLD, variance, np.inf))


def pulls_p_value(pulls: RealArray, covariance: RealArray) -> float:
    """Return the probability that chance moves stated quantities as far: one of them, or all of them together.

    Each by its spread, times their number; and chi-square of all, in the directions that the data tell; the less
    probable of both, times two. As many degrees of freedom as quantities would leave room for what never moves.

    Parameters
    ----------
    pulls : array, shape (k,)
    covariance : array, shape (k, k)
        As for `spreads_by_chance`.
    """
    if not len(pulls):
        return 1.0
    spreads = spreads_by_chance(covariance)
    count = int(np.count_nonzero(np.isfinite(spreads)))
    of_one = max(count, 1) * exceeding(float(np.max((pulls / spreads) ** 2)), 1)
    variance, directions = np.linalg.eigh(np.eye(len(pulls)) - covariance)
    told = variance >= _TOLD
    if not told.any():
        return 1.0
    chi_square = float(np.sum((directions.T @ pulls)[told] ** 2 / variance[told]))
    return min(2 * min(of_one, exceeding(chi_square, int(np.count_nonzero(told)))), 1.0)


def largest_pulls(parameters: Sequence[Parameter], z: RealArray, by_chance: RealArray | None = None) -> list[Pull]:
    """Return the pulls beyond chance of quantities marked as nuisances, see `beyond_chance`.

    Parameters
    ----------
    parameters : sequence of Parameter
    z : array, shape (n,)
        Standard normal coordinates.
    by_chance : array, shape (n,), optional
        See `spreads_by_chance`; 1 when left out.
    """
    spreads = np.ones(len(z)) if by_chance is None else by_chance
    pulls = [
        Pull(parameter, float(value), float(spread))
        for parameter, value, spread, is_nuisance in zip(parameters, z, spreads, _nuisances(parameters), strict=True)
        if is_nuisance
    ]
    return beyond_chance(pulls)


def beyond_chance(pulls: Sequence[Pull]) -> list[Pull]:
    """Return the pulls beyond three times what chance makes of them, or else the largest alone; the largest first."""
    ranked = sorted(pulls, key=lambda pull: -abs(pull.deviations) / pull.by_chance)
    return [pull for pull in ranked if abs(pull.deviations) > _FAR * pull.by_chance] or ranked[:1]
