"""Correlated values: their mean, whether they are one, and whether something is seen in them."""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding

Verdict: TypeAlias = Literal["seen", "hint", "none"]
ALIKE = 0.01  # least probability at which values at several frequencies are taken for one
_SEEN, _HINT = 0.0027, 0.05  # three and two standard deviations
_CHANCE = 0.05  # below it the scatter is more than the stated errors, which are then enlarged


def verdict_of(probability: float) -> Verdict:
    """Return whether an effect is seen, hinted at, or none, from the probability of what was found without it."""
    return "seen" if probability < _SEEN else "hint" if probability < _HINT else "none"


def birge(chi_square: float, degrees: int) -> float:
    """Return Birge's ratio where the scatter is more than chance, else 1: the factor on all standard deviations."""
    if not degrees or exceeding(chi_square, degrees) > _CHANCE:
        return 1.0
    return float(np.sqrt(chi_square / degrees))


def combined(values: RealArray, covariance: RealArray, design: RealArray) -> tuple[RealArray, RealArray]:
    """Return the generalised least-squares solution of ``design x = values``, and its covariance."""
    weights = np.linalg.solve(covariance, design)
    found = np.linalg.inv(design.T @ weights)
    return found @ (weights.T @ values), found


def distance(difference: RealArray, covariance: RealArray) -> float:
    """Return the squared Mahalanobis distance."""
    return float(difference @ np.linalg.solve(covariance, difference))


def probability(difference: RealArray, covariance: RealArray, degrees: int | None = None) -> float:
    """Return the probability of a difference as large as this by chance; 1 where there is nothing to differ."""
    count = len(difference) if degrees is None else degrees
    return exceeding(distance(difference, covariance), count) if count > 0 else 1.0
