"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import logsumexp
from scipy.stats import chi2

from multilayer.arrays import RealArray
from multilayer.diagnosis.hypothesis import Hypothesis
from multilayer.inverse.problem import Minimum

SIZES = (0.005, 0.01, 0.02, 0.04, 0.08)  # relative, of the discrepancy
_LENGTH = 0.4  # correlation length in ln f
_KEPT = 1e-4  # eigenvalues of a covariance kept, relative


def smooth_basis(hypothesis: Hypothesis) -> RealArray:
    """Return columns B with B B^T the whitened covariance of a smooth unit discrepancy, shape (n_data, k).

    Amplitude and phase of every configuration have one of their own, smooth in ln f.
    """
    blocks = []
    total = sum(2 * len(data.frequency) for data in hypothesis.data)
    first = 0
    for i, data in enumerate(hypothesis.data):
        n = len(data.frequency)
        distance = np.subtract.outer(np.log(data.frequency), np.log(data.frequency)) / _LENGTH
        sizes, vectors = np.linalg.eigh(np.exp(-0.5 * distance**2))
        kept = sizes > _KEPT * sizes[-1]
        columns = (vectors[:, kept] * np.sqrt(sizes[kept])).T
        for part in (columns + 0j, 1j * columns):
            block = np.zeros((total, columns.shape[0]))
            block[first : first + 2 * n] = hypothesis.whitened(i, part).T
            blocks.append(block)
        first += 2 * n
    return np.concatenate(blocks, axis=1)


def discrepancy_evidence(
    hypothesis: Hypothesis, minimum: Minimum, sizes: Sequence[float] = SIZES
) -> tuple[float, float]:
    """Return the log evidence of a model with a smooth discrepancy, and the most probable size of that.

    ``r ~ N(0, C + P K_s P^T)`` with `P` the projector off the columns of the Jacobian: a discrepancy orthogonal to what
    the unknowns can absorb (M. Plumlee, J. Am. Stat. Assoc. 112 (2017) 1274-1285), averaged over sizes s. On the same
    scale as `Minimum.log_evidence`.
    """
    gains = _Gains.of(hypothesis, minimum).at(sizes)
    best = float(sizes[int(np.argmax(gains))])
    return minimum.log_evidence + float(logsumexp(gains)) - float(np.log(len(gains))), best


def tolerant_p_value(hypothesis: Hypothesis, minimum: Minimum, size: float) -> float:
    """Return the probability of a misfit as large as this where a smooth discrepancy of relative `size` is tolerated.

    The misfit is chi-square distributed for a linear model with normal priors: the bootstrap's answer in closed form.
    """
    excess = _Gains.of(hypothesis, minimum).explained(size)
    return float(chi2.sf(minimum.cost - excess, len(minimum.residual)))


@dataclass(frozen=True)
class _Gains:
    """The part of a discrepancy that the unknowns cannot absorb: its Gram matrix, and its product with the residual."""

    gram: RealArray
    along: RealArray

    @classmethod
    def of(cls, hypothesis: Hypothesis, minimum: Minimum) -> _Gains:
        basis = smooth_basis(hypothesis)
        q, _ = np.linalg.qr(minimum.jacobian)
        free = basis - q @ (q.T @ basis)
        # off the Jacobian's columns the unknowns change nothing: the nominal evidence, the misfit there marginalised
        residual = minimum.residual - q @ (q.T @ minimum.residual)
        return cls(free.T @ free, free.T @ residual)

    def at(self, sizes: Sequence[float]) -> list[float]:
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
