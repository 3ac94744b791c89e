"""The hypothesis of an unknown cause: a smooth discrepancy in place of any known effect.

See `multilayer.inference.discrepancy` for the equations and their sources.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.model_discrepancy import smooth_basis
from multilayer.diagnosis.thresholds import TOLERANCE
from multilayer.inference.discrepancy import OrthogonalDiscrepancy

NO_DISCREPANCY = 1e-6  # relative size that counts for nothing, where one is needed
_SMALL = (NO_DISCREPANCY, 0.5 * TOLERANCE, TOLERANCE)  # relative sizes of a discrepancy that every hypothesis may keep


def smooth_discrepancy(fitted: Fitted) -> OrthogonalDiscrepancy:
    """Return a smooth discrepancy at a fit, the errors of the effects' laws being part of the noise."""
    return OrthogonalDiscrepancy.of(fitted.minimum, fitted.whitened(smooth_basis(fitted.hypothesis).T).T)


def discrepancy_evidence(fitted: Fitted, sizes: Sequence[float]) -> float:
    """Return the log evidence of a model with a smooth discrepancy, averaged over relative sizes.

    On the same scale as `Fitted.log_evidence`; minus infinity where there is no response.
    """
    if not fitted.minimum.is_finite:
        return -np.inf
    log_factors = smooth_discrepancy(fitted).log_bayes_factors(sizes)
    return fitted.log_evidence + float(logsumexp(log_factors)) - float(np.log(len(log_factors)))


def tolerant_evidence(fitted: Fitted) -> float:
    """Return the log evidence of a hypothesis with a discrepancy as large as the differences of solvers."""
    return discrepancy_evidence(fitted, _SMALL)
