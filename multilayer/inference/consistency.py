"""Values with a common covariance: their weighted mean, whether they agree, and whether an effect shows in them.

Generalised least squares: A. C. Aitken, Proc. R. Soc. Edinb. 55 (1936) 42-48. The ratio of scatter to stated errors:
R. T. Birge, Phys. Rev. 40 (1932) 207-227.
"""

from __future__ import annotations

from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding

Verdict: TypeAlias = Literal["seen", "hint", "none"]
ALIKE = 0.01  # least probability at which values at several frequencies are taken for equal
_SEEN, _HINT = 0.0027, 0.05  # three and two standard deviations
_CHANCE = 0.05  # below it the scatter is more than the stated errors, which are then enlarged


def verdict_of(probability: float) -> Verdict:
    """Return whether an effect is seen, hinted at, or absent, from the p-value of the data without that effect."""
    return "seen" if probability < _SEEN else "hint" if probability < _HINT else "none"


def birge_ratio(chi_square: float, degrees: int) -> float:
    """Return Birge's ratio ``sqrt(chi-square / degrees)``, by which standard deviations are enlarged.

    It is 1 where chance explains the scatter.
    """
    if not degrees or exceeding(chi_square, degrees) > _CHANCE:
        return 1.0
    return float(np.sqrt(chi_square / degrees))


def generalised_least_squares(
    values: RealArray, covariance: RealArray, design: RealArray
) -> tuple[RealArray, RealArray]:
    """Return the generalised least-squares solution of ``design x = values``, and its covariance.

    Parameters
    ----------
    values : array, shape (n,)
    covariance : array, shape (n, n)
    design : array, shape (n, k)
    """
    weights = np.linalg.solve(covariance, design)
    solution_covariance = np.linalg.inv(design.T @ weights)
    return solution_covariance @ (weights.T @ values), solution_covariance


def mahalanobis_squared(difference: RealArray, covariance: RealArray) -> float:
    """Return the squared Mahalanobis distance ``d^T C^-1 d``: chi-square of a difference d, shape (n,)."""
    return float(difference @ np.linalg.solve(covariance, difference))


def p_value(difference: RealArray, covariance: RealArray, degrees: int | None = None) -> float:
    """Return the probability of a difference as large as this by chance; 1 for an empty difference.

    `degrees` of freedom are as many as there are values when left out.
    """
    count = len(difference) if degrees is None else degrees
    return exceeding(mahalanobis_squared(difference, covariance), count) if count > 0 else 1.0
