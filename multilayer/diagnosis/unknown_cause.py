"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

from multilayer.chi2 import exceeding
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.model_discrepancy import smooth_basis
from multilayer.inference.discrepancy import OrthogonalDiscrepancy

SIZES = (0.005, 0.01, 0.02, 0.04, 0.08)  # relative, of the discrepancy


def discrepancy_evidence(fitted: Fitted, sizes: Sequence[float] = SIZES) -> tuple[float, float]:
    """Return the log evidence of a model with a smooth discrepancy, and the most probable size of that.

    Averaged over sizes, see `OrthogonalDiscrepancy`; the errors of the effects' laws are in the noise. On the same
    scale as `Fitted.log_evidence`.
    """
    gains = _leftover(fitted).log_bayes_factors(sizes)
    best = float(sizes[int(np.argmax(gains))])
    return fitted.log_evidence + float(logsumexp(gains)) - float(np.log(len(gains))), best


def _leftover(fitted: Fitted) -> OrthogonalDiscrepancy:
    return OrthogonalDiscrepancy.of(fitted.minimum, fitted.softened(smooth_basis(fitted.hypothesis).T).T)


def tolerant_p_value(fitted: Fitted, size: float) -> float:
    """Return the probability of a misfit as large as this where a smooth discrepancy of relative `size` is tolerated.

    The misfit is chi-square distributed for a linear model with normal priors: the bootstrap's answer in closed form.
    """
    excess = _leftover(fitted).misfit_reduction(size)
    return exceeding(fitted.minimum.cost - excess, len(fitted.minimum.residual))


def size_p_value(fitted: Fitted) -> float:
    """Return the probability that effects are as far from their usual sizes, all their parameters together."""
    own = len(fitted.hypothesis.effect_parameters)
    amounts = fitted.minimum.z[len(fitted.minimum.z) - own :]
    return exceeding(float(amounts @ amounts), own) if own else 1.0


def law_p_value(fitted: Fitted) -> float:
    """Return the probability that the effects' laws are as wrong as the fit takes them.

    The errors' posterior means have a weighted chi-square distribution, here by its first two moments.
    """
    if fitted.errors is None or not len(fitted.errors.sizes):
        return 1.0
    weights = fitted.errors.sizes**2 / (1 + fitted.errors.sizes**2)
    amounts = np.sqrt(weights) * (fitted.minimum.residual @ fitted.errors.directions)
    scale = float(np.sum(weights**2) / np.sum(weights))
    return exceeding(float(amounts @ amounts) / scale, float(np.sum(weights)) / scale)
