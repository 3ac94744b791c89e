"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp

from multilayer.arrays import RealArray
from multilayer.chance import exceeding
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.law_errors import smooth_basis

SIZES = (0.005, 0.01, 0.02, 0.04, 0.08)  # relative, of the discrepancy


def discrepancy_evidence(fitted: Fitted, sizes: Sequence[float] = SIZES) -> tuple[float, float]:
    """Return the log evidence of a model with a smooth discrepancy, and the most probable size of that.

    ``r ~ N(0, C + P K_s P^T)`` with `P` the projector off the columns of the Jacobian: a discrepancy orthogonal to what
    the unknowns can absorb (M. Plumlee, J. Am. Stat. Assoc. 112 (2017) 1274-1285), averaged over sizes s. C holds the
    errors of the effects' own laws. On the same scale as `Fitted.log_evidence`.
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
        q, _ = np.linalg.qr(minimum.jacobian)
        free = basis - q @ (q.T @ basis)
        # off the Jacobian's columns the unknowns change nothing: the nominal evidence, the misfit there marginalised
        residual = minimum.residual - q @ (q.T @ minimum.residual)
        return cls(free.T @ free, free.T @ residual)

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
