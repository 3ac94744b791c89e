"""Errors of the effects' own laws: no law is quite right, and the larger the effect the more that shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.inverse.priors import Parameter

_LAW_LENGTH = 1.0  # correlation length in ln f: a power law that is off is off slowly
_LENGTH = 0.4  # that of a discrepancy of no known origin
_KEPT = 1e-4  # eigenvalues of its covariance kept, relative
_MOST = 3.0  # of ln(ratio) or its error where what is read nearly vanishes: no small change any more
_LEAST = 0.03  # standard deviations of the data: smaller errors change nothing
_ROUNDING = 1e-12  # of the largest, squared: smaller ones are not resolved


@dataclass(frozen=True)
class LawErrors:
    """The covariance ``1 + B B^T`` of whitened residuals, B = U diag(s) V^T.

    Attributes
    ----------
    directions : array, shape (n_data, k)
        U.
    sizes : array, shape (k,)
        s, standard deviations.
    """

    directions: RealArray
    sizes: RealArray

    @classmethod
    def of(cls, basis: RealArray) -> LawErrors:
        """Return it from columns B, shape (n_data, m)."""
        # of B^T B: a tenth of the time of singular values, and as good for those that are kept
        squares, vectors = np.linalg.eigh(basis.T @ basis)
        kept = squares > max(_LEAST**2, _ROUNDING * squares.max(initial=0.0))
        sizes = np.sqrt(squares[kept])
        return cls(basis @ vectors[:, kept] / sizes, sizes)

    @property
    def log_determinant(self) -> float:
        """Of the covariance."""
        return float(np.sum(np.log1p(self.sizes**2)))

    def whitened(self, values: RealArray) -> RealArray:
        """Return ``(1 + B B^T)^(-1/2)`` times values, shape (..., n_data)."""
        shrink = 1 - 1 / np.sqrt(1 + self.sizes**2)
        return np.asarray(values - (values @ self.directions * shrink) @ self.directions.T)


@dataclass(frozen=True)
class Softened:
    """A hypothesis whose effects' laws may be wrong: a `Problem` with residuals of unit variance again.

    Attributes
    ----------
    hypothesis : AnyHypothesis
    errors : LawErrors
    """

    hypothesis: AnyHypothesis
    errors: LawErrors

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the hypothesis."""
        return self.hypothesis.parameters

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data)."""
        return self.errors.whitened(self.hypothesis.residual(z))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative."""
        residual, slopes = self.hypothesis.linearised(z)
        return self.errors.whitened(residual), self.errors.whitened(slopes.T).T


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


def law_basis(hypothesis: AnyHypothesis, z: RealArray) -> RealArray:
    """Return columns B with B B^T the whitened covariance of the errors of the effects' own laws, shape (n_data, k)."""
    return np.concatenate(law_parts(hypothesis, z), axis=1)


def law_parts(
    hypothesis: AnyHypothesis, z: RealArray, whole: AnyHypothesis | None = None
) -> tuple[RealArray, RealArray]:
    """Return the columns of `law_basis` in two parts: common to all configurations, and each one's own.

    What an effect changes, times a complex factor that is smooth in ln f, of the size of the effect's `law_error`. An
    error embedded in the law is large where the effect is, and nothing where it is not.

    Parameters
    ----------
    hypothesis : AnyHypothesis
    z : array, shape (d,)
    whole : AnyHypothesis, optional
        The hypothesis with all its data, of which this one has a part: the common columns of its parts then belong to
        the same unknown numbers.
    """
    everything = (whole or hypothesis).data
    at = np.log(np.concatenate([data.frequency for data in everything]))
    knots = np.arange(at.min(), at.max() + _LAW_LENGTH / 2, _LAW_LENGTH / 2)
    sizes, vectors = np.linalg.eigh(_kernel(knots, knots, _LAW_LENGTH))
    kept = sizes > 1e-3 * sizes[-1]
    shape = vectors[:, kept] / np.sqrt(sizes[kept])
    share = np.sqrt(0.5) if len(everything) > 1 else 1.0
    total = sum(2 * len(data.frequency) for data in hypothesis.data)
    common, own = [np.empty((total, 0))], [np.empty((total, 0))]
    for index, effect in enumerate(hypothesis.effects):
        if effect.law_error:
            blocks = _modulated(hypothesis, hypothesis.law_change(index, z), knots, shape)
            common.append(share * effect.law_error * np.concatenate(blocks, axis=0))
            if len(everything) > 1:
                own.append(share * effect.law_error * block_diag(*blocks))
    return np.concatenate(common, axis=1), np.concatenate(own, axis=1)


def _modulated(
    hypothesis: AnyHypothesis, signature: Sequence[ComplexArray], knots: RealArray, shape: RealArray
) -> list[RealArray]:
    """Return by configuration the whitened columns of a signature with smooth relative errors of unit size."""
    blocks = []
    for i, (data, own) in enumerate(zip(hypothesis.data, signature, strict=True)):
        smooth = (_kernel(np.log(data.frequency), knots, _LAW_LENGTH) @ shape).T
        limited = own / np.maximum(np.abs(own) / _MOST, 1.0)
        parts = [hypothesis.whitened(i, smooth * limited).T, hypothesis.whitened(i, 1j * smooth * limited).T]
        blocks.append(np.concatenate(parts, axis=1))
    return blocks


def _kernel(a: RealArray, b: RealArray, length: float) -> RealArray:
    return np.asarray(np.exp(-0.5 * (np.subtract.outer(a, b) / length) ** 2))
