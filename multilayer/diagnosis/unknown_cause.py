"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.model_discrepancy import smooth_basis

SIZES = (0.005, 0.01, 0.02, 0.04, 0.08)  # relative, of the discrepancy


def discrepancy_evidence(fitted: Fitted, sizes: Sequence[float] = SIZES) -> tuple[float, float]:
    """Return the log evidence of a model with a smooth discrepancy, and the most probable size of that.

    ``r ~ N(0, C + J J^T + P K_s P^T)``, ``P = (1 + J J^T)^-1``: what the unknowns leave of a discrepancy, their priors
    being what they are, averaged over sizes s. Where the data say all, P projects off the columns of the Jacobian (M.
    Plumlee, J. Am. Stat. Assoc. 112 (2017) 1274-1285); what the data hardly tell absorbs nothing, and the direction of
    its slopes, which is one of rounding, does not count. C holds the errors of the effects' own laws. On the same
    scale as `Fitted.log_evidence`.
    """
    gains = _Leftover.of(fitted).gains(sizes)
    best = float(sizes[int(np.argmax(gains))])
    return fitted.log_evidence + float(logsumexp(gains)) - float(np.log(len(gains))), best


def tolerant_p_value(fitted: Fitted, size: float) -> float:
    """Return the probability of a misfit as large as this where a smooth discrepancy of relative `size` is tolerated.

    The misfit is chi-square distributed for a linear model with normal priors: the bootstrap's answer in closed form.
    """
    excess = _Leftover.of(fitted).explained(size)
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


@dataclass(frozen=True)
class _Leftover:
    """The part of a smooth discrepancy that the unknowns cannot absorb: Gram matrix, product with the residual."""

    gram: RealArray
    along: RealArray

    @classmethod
    def of(cls, fitted: Fitted) -> _Leftover:
        minimum = fitted.minimum
        basis = fitted.softened(smooth_basis(fitted.hypothesis).T).T
        u, s, _ = np.linalg.svd(minimum.jacobian, full_matrices=False)
        left = 1 / (1 + s**2)  # P along the columns of u; of a linear model a minimum's residual is P r(0)
        along = u.T @ basis
        free = basis - u @ ((1 - left)[:, None] * along)
        whitened = basis - u @ ((1 - left**1.5)[:, None] * along)
        return cls(whitened.T @ whitened, free.T @ minimum.residual)

    def gains(self, sizes: Sequence[float]) -> list[float]:
        """Return the gains of log evidence for discrepancies of some sizes."""
        found = []
        for size in sizes:
            factor = self._factor(size)
            found.append(0.5 * self.explained(size) - float(np.sum(np.log(np.diag(factor)))))
        return found

    def explained(self, size: float) -> float:
        """Return by how much the misfit falls, a discrepancy of this size being marginalised."""
        solved = np.linalg.solve(self._factor(size), self.along)
        return float(size**2 * solved @ solved)

    def _factor(self, size: float) -> RealArray:
        return np.asarray(np.linalg.cholesky(np.eye(len(self.gram)) + size**2 * self.gram))
