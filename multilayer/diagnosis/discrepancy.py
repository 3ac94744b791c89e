"""The hypothesis that something acts which is none of the known effects."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag
from scipy.special import logsumexp
from scipy.stats import chi2

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.inverse.problem import Minimum

SIZES = (0.005, 0.01, 0.02, 0.04, 0.08)  # relative, of the discrepancy
_LENGTH = 0.4  # correlation length in ln f
_LAW_LENGTH = 1.0  # that of the errors of laws: a power law that is off is off slowly
_KEPT = 1e-4  # eigenvalues of a covariance kept, relative


def smooth_basis(hypothesis: AnyHypothesis) -> RealArray:
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


def law_basis(hypothesis: AnyHypothesis, minimum: Minimum) -> RealArray:
    """Return columns B with B B^T the whitened covariance of the errors of the effects' own laws, shape (n_data, k).

    What an effect changes in ln(ratio), times a complex factor that is smooth in ln f: partly common to all
    configurations, partly each one's own. Its size is the effect's `law_error`. An error
    embedded in the law is large where the effect is, and nothing where it is not.
    """
    total = sum(2 * len(data.frequency) for data in hypothesis.data)
    blocks = [np.empty((total, 0))]
    whole = hypothesis.log_ratios(minimum.z)
    for index, effect in enumerate(hypothesis.effects):
        if effect.law_error:
            own = [full - bare for full, bare in zip(whole, hypothesis.without_effect(index, minimum.z), strict=True)]
            blocks.append(effect.law_error * _modulated(hypothesis, own))
    return np.concatenate(blocks, axis=1)


def _modulated(hypothesis: AnyHypothesis, signature: Sequence[ComplexArray]) -> RealArray:
    """Return whitened columns of a signature with smooth relative errors of unit size."""
    at = np.log(np.concatenate([data.frequency for data in hypothesis.data]))
    knots = np.arange(at.min(), at.max() + _LAW_LENGTH / 2, _LAW_LENGTH / 2)
    sizes, vectors = np.linalg.eigh(_kernel(knots, knots, _LAW_LENGTH))
    kept = sizes > 1e-3 * sizes[-1]
    shape = vectors[:, kept] / np.sqrt(sizes[kept])
    columns: list[list[RealArray]] = []
    for i, (data, own) in enumerate(zip(hypothesis.data, signature, strict=True)):
        smooth = (_kernel(np.log(data.frequency), knots, _LAW_LENGTH) @ shape).T
        # beyond half a turn or a neper the effect is no small change of ln(ratio) any more
        limited = own / np.maximum(np.abs(own), 1.0)
        columns.append([hypothesis.whitened(i, smooth * limited).T, hypothesis.whitened(i, 1j * smooth * limited).T])
    common = np.concatenate([np.concatenate(parts, axis=1) for parts in columns], axis=0)
    if len(columns) == 1:
        return common
    return np.asarray(
        np.sqrt(0.5) * np.concatenate([common, block_diag(*(np.concatenate(p, axis=1) for p in columns))], axis=1)
    )


def _kernel(a: RealArray, b: RealArray, length: float) -> RealArray:
    return np.asarray(np.exp(-0.5 * (np.subtract.outer(a, b) / length) ** 2))


def discrepancy_evidence(
    hypothesis: AnyHypothesis, minimum: Minimum, sizes: Sequence[float] = SIZES
) -> tuple[float, float]:
    """Return the log evidence of a model with a smooth discrepancy, and the most probable size of that.

    ``r ~ N(0, C + P K_s P^T)`` with `P` the projector off the columns of the Jacobian: a discrepancy orthogonal to what
    the unknowns can absorb (M. Plumlee, J. Am. Stat. Assoc. 112 (2017) 1274-1285), averaged over sizes s; the errors of
    the effects' own laws (`law_basis`) are part of K. On the same scale as `Minimum.log_evidence`.
    """
    gains = Leftover.of(hypothesis, minimum).gains(sizes)
    best = float(sizes[int(np.argmax(gains))])
    return minimum.log_evidence + float(logsumexp(gains)) - float(np.log(len(gains))), best


def tolerant_p_value(hypothesis: AnyHypothesis, minimum: Minimum, size: float) -> float:
    """Return the probability of a misfit as large as this where a smooth discrepancy of relative `size` is tolerated.

    The misfit is chi-square distributed for a linear model with normal priors: the bootstrap's answer in closed form.
    """
    excess = Leftover.of(hypothesis, minimum).explained(size)
    return float(chi2.sf(minimum.cost - excess, len(minimum.residual)))


def tolerant_covariance(hypothesis: AnyHypothesis, minimum: Minimum) -> RealArray:
    """Return the covariance of the coordinates, shape (d, d), the errors of the effects' laws included.

    They shift what least squares finds: ``H^-1 (J^T (1 + B B^T) J + 1) H^-1``, H the precision.
    """
    along = minimum.jacobian.T @ law_basis(hypothesis, minimum)
    spread = minimum.covariance @ along
    return np.asarray(minimum.covariance + spread @ spread.T)


@dataclass(frozen=True)
class Leftover:
    """The part of discrepancies that the unknowns cannot absorb: Gram matrix, and product with the residual.

    Attributes
    ----------
    gram : array, shape (k, k)
    along : array, shape (k,)
    smooth : array of bool, shape (k,)
        Which are of the smooth discrepancy, whose size is given later; the others are errors of laws.
    """

    gram: RealArray
    along: RealArray
    smooth: BoolArray

    @classmethod
    def of(cls, hypothesis: AnyHypothesis, minimum: Minimum) -> Leftover:
        """Return it at a hypothesis' most probable parameters."""
        smooth, own = smooth_basis(hypothesis), law_basis(hypothesis, minimum)
        basis = np.concatenate([smooth, own], axis=1)
        q, _ = np.linalg.qr(minimum.jacobian)
        free = basis - q @ (q.T @ basis)
        # off the Jacobian's columns the unknowns change nothing: the nominal evidence, the misfit there marginalised
        residual = minimum.residual - q @ (q.T @ minimum.residual)
        return cls(free.T @ free, free.T @ residual, np.arange(basis.shape[1]) < smooth.shape[1])

    def gains(self, sizes: Sequence[float]) -> list[float]:
        """Return the gains of log evidence for smooth discrepancies of some sizes."""
        found = []
        for size in sizes:
            factor = self._factor(size)
            found.append(0.5 * self.explained(size) - float(np.sum(np.log(np.diag(factor)))))
        return found

    def explained(self, size: float) -> float:
        """Return by how much the misfit falls, a discrepancy of this size being marginalised."""
        along = self._scale(size) * self.along
        solved = np.linalg.solve(self._factor(size), along)
        return float(solved @ solved)

    def _scale(self, size: float) -> RealArray:
        return np.where(self.smooth, size, 1.0)

    def _factor(self, size: float) -> RealArray:
        scale = self._scale(size)
        return np.asarray(np.linalg.cholesky(np.eye(len(scale)) + np.outer(scale, scale) * self.gram))
