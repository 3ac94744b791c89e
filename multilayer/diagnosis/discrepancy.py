"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.special import logsumexp

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
    total = sum(2 * len(data.frequency) for data in hypothesis.joint.data)
    first = 0
    for i, data in enumerate(hypothesis.joint.data):
        n = len(data.frequency)
        distance = np.subtract.outer(np.log(data.frequency), np.log(data.frequency)) / _LENGTH
        sizes, vectors = np.linalg.eigh(np.exp(-0.5 * distance**2))
        kept = sizes > _KEPT * sizes[-1]
        columns = (vectors[:, kept] * np.sqrt(sizes[kept])).T
        for part in (columns + 0j, 1j * columns):
            block = np.zeros((total, columns.shape[0]))
            block[first : first + 2 * n] = hypothesis.joint.whitened(i, part).T
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
    jacobian, basis = minimum.jacobian, smooth_basis(hypothesis)
    q, _ = np.linalg.qr(jacobian)
    free = basis - q @ (q.T @ basis)
    # off the Jacobian's columns the unknowns change nothing: the nominal evidence, with the misfit there marginalised
    residual = minimum.residual - q @ (q.T @ minimum.residual)
    gram, along = free.T @ free, free.T @ residual
    gains = []
    for size in sizes:
        inner = np.eye(len(gram)) + size**2 * gram
        factor = np.linalg.cholesky(inner)
        solved = np.linalg.solve(factor, along)
        gains.append(0.5 * size**2 * float(solved @ solved) - float(np.sum(np.log(np.diag(factor)))))
    best = float(sizes[int(np.argmax(gains))])
    return minimum.log_evidence + float(logsumexp(gains)) - float(np.log(len(gains))), best
