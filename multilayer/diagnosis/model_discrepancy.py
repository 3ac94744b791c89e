"""Errors of the effects' own laws: no law is quite right, and the larger the effect the more that shows."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from multilayer.arrays import ComplexArray, RealArray
from multilayer.experiments.hypothesis import Data, Hypothesis
from multilayer.inference.derivative import FINE, Stencil
from multilayer.inference.low_rank import LowRank
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Problem

_LAW_LENGTH = 1.0  # correlation length in ln f: a power law that is off is off slowly
_LENGTH = 0.4  # that of a discrepancy of no known origin
_KEPT = 1e-4  # eigenvalues of its covariance kept, relative
_MOST = 3.0  # of ln(ratio) or its error where what is read nearly vanishes: no small change any more
_TINY = 1e-12


@dataclass(frozen=True)
class Embedded(Problem):
    """A hypothesis together with the errors of its effects' laws, in the hypothesis' unknowns.

    The data are ``r(z) + B(z) a`` with a ~ N(0, 1), see `law_parts`. With a integrated out, minus twice the log density
    is ``r^T C^-1 r + ln |C|``, ``C = 1 + B B^T``: the sum of squares of this problem's residuals, the last
    of which is the root of the second term (not below 0, as C is not below 1). `WithModelErrors` holds
    B fixed. Computing B again at the minimum so found, and so on, need not converge, and its limit depends on the
    start; here B follows z, and a minimum is that of a single function.

    Notes
    -----
    The derivative is ``C^(-1/2) d(r + B a)`` with the best amounts ``a = -B^T C^-1 r`` held: exact for the gradient,
    Gauss and Newton's for the curvature (variable projection: G. H. Golub & V. Pereyra, SIAM J. Numer. Anal. 10 (1973)
    413-432; L. Kaufman, BIT 15 (1975) 49-57).

    Attributes
    ----------
    hypothesis : Hypothesis
    """

    hypothesis: Hypothesis

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Those of the hypothesis."""
        return self.hypothesis.parameters

    def errors(self, z: RealArray) -> LowRank:
        """Return the laws' errors at coordinates of shape (d,)."""
        return LowRank.of(law_basis(self.hypothesis, z))

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data + 1)."""
        rows = z.reshape(-1, z.shape[-1])
        pairs = zip(map(self.errors, rows), self.hypothesis.residual(rows), strict=True)
        found = [np.append(errors.whitened(values), np.sqrt(errors.log_determinant)) for errors, values in pairs]
        return np.reshape(found, (*z.shape[:-1], -1))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative, shapes (n_data + 1,) and (n_data + 1, d), from one batch."""
        hypothesis = self.hypothesis
        stencil = Stencil.central(z, FINE)
        shown, changes = shown_and_changed(hypothesis, stencil.points)
        here = [[change[0] for change in parts] for parts in changes]
        basis = np.concatenate(_columns(hypothesis, here, hypothesis.data), axis=1)
        errors = LowRank.of(basis)
        residual = _whitened(hypothesis, [values[0] for values in shown])
        factors = _factors(hypothesis, -basis.T @ errors.whitened(errors.whitened(residual)))
        total = [*shown]
        for own, parts in zip(factors, changes, strict=True):
            total = [a + factor * change for a, factor, change in zip(total, own, parts, strict=True)]
        slopes = stencil.derivative(_whitened(hypothesis, total))
        # d ln |C| = 2 tr(B^T C^-1 dB)
        root = np.sqrt(errors.log_determinant)
        inverse = errors.whitened(errors.whitened(basis.T))
        growth = stencil.derivative(_traced(hypothesis, changes, inverse)) / max(root, _TINY)
        values = np.append(errors.whitened(residual), root)
        return values, np.concatenate([errors.whitened(slopes.T).T, growth[None]])

    def minimum(self, found: Minimum) -> Minimum:
        """Return a minimum of this problem as one of the hypothesis, its data whitened by `errors`."""
        residual = found.residual[:-1]
        return replace(found, misfit=float(residual @ residual), residual=residual, jacobian=found.jacobian[:-1])


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
            block[first : first + 2 * n] = hypothesis.experiments[i].whiten(part).T
            blocks.append(block)
        first += 2 * n
    return np.concatenate(blocks, axis=1)


def law_basis(hypothesis: Hypothesis, z: RealArray) -> RealArray:
    """Return columns B with B B^T the whitened covariance of the errors of the effects' own laws, shape (n_data, k)."""
    return np.concatenate(law_parts(hypothesis, z), axis=1)


def law_parts(hypothesis: Hypothesis, z: RealArray, whole: Hypothesis | None = None) -> tuple[RealArray, RealArray]:
    """Return the columns of `law_basis` in two parts: common to all configurations, and each one's own.

    What an effect changes, times a complex factor that is smooth in ln f, of the size of the effect's `law_error`. An
    error embedded in the law is large where the effect is, and nothing where it is not.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (d,)
    whole : Hypothesis, optional
        The hypothesis with all its data, of which this one has a part: the common columns of its parts then belong to
        the same unknown numbers.
    """
    changes = shown_and_changed(hypothesis, z)[1]
    return _columns(hypothesis, changes, (whole or hypothesis).data)


def shown_and_changed(hypothesis: Hypothesis, z: RealArray) -> tuple[list[ComplexArray], list[list[ComplexArray]]]:
    """Return `differences`, and by effect what an error of its law by all of its size changes, as far as that is small.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (..., d)
    """
    shown = hypothesis.differences(z)
    changes = [
        [_limited(change) for change in hypothesis.law_change(index, z, shown)]
        for index, effect in enumerate(hypothesis.effects)
        if effect.law_error
    ]
    return shown, changes


def _columns(
    hypothesis: Hypothesis, changes: Sequence[Sequence[ComplexArray]], everything: Sequence[Data]
) -> tuple[RealArray, RealArray]:
    """Return the columns of `law_parts` from what each effect changes by configuration, shape (n,)."""
    shapes = _shapes(hypothesis, everything)
    total = sum(2 * len(data.frequency) for data in hypothesis.data)
    common, own = [np.empty((total, 0))], [np.empty((total, 0))]
    for size, parts in zip(_sizes(hypothesis, len(everything)), changes, strict=True):
        blocks = _modulated(hypothesis, parts, shapes)
        common.append(size * np.concatenate(blocks, axis=0))
        if len(everything) > 1:
            own.append(size * block_diag(*blocks))
    return np.concatenate(common, axis=1), np.concatenate(own, axis=1)


def _sizes(hypothesis: Hypothesis, configurations: int) -> list[float]:
    """Return the standard deviation of the error of each law that has one: common to all configurations, or its own."""
    share = np.sqrt(0.5) if configurations > 1 else 1.0
    return [float(share * effect.law_error) for effect in hypothesis.effects if effect.law_error]


def _shapes(hypothesis: Hypothesis, everything: Sequence[Data]) -> list[RealArray]:
    """Return by configuration smooth functions of ln f, shape (k, n), whose sum with normal weights is an error."""
    at = np.log(np.concatenate([data.frequency for data in everything]))
    knots = np.arange(at.min(), at.max() + _LAW_LENGTH / 2, _LAW_LENGTH / 2)
    sizes, vectors = np.linalg.eigh(_kernel(knots, knots, _LAW_LENGTH))
    kept = sizes > 1e-3 * sizes[-1]
    weights = vectors[:, kept] / np.sqrt(sizes[kept])
    return [(_kernel(np.log(data.frequency), knots, _LAW_LENGTH) @ weights).T for data in hypothesis.data]


def _factors(hypothesis: Hypothesis, amounts: RealArray) -> list[list[ComplexArray]]:
    """Return by effect with a law's error, and configuration, that relative error, shape (n,), of some amounts."""
    shapes = _shapes(hypothesis, hypothesis.data)
    sizes = _sizes(hypothesis, len(shapes))
    width, half = 2 * len(shapes[0]), len(shapes[0])
    common, own = np.split(amounts, [width * len(sizes)])
    rows = common.reshape(len(sizes), 1, width)
    rows = rows + own.reshape(len(sizes), len(shapes), width) if len(shapes) > 1 else rows
    return [
        [np.asarray(size * (row[:half] + 1j * row[half:]) @ shape) for row, shape in zip(weights, shapes, strict=True)]
        for size, weights in zip(sizes, rows, strict=True)
    ]


def _traced(hypothesis: Hypothesis, changes: Sequence[Sequence[ComplexArray]], weights: RealArray) -> RealArray:
    """Return ``tr(W B)``, shape (m,), for bases B of changes of shape (m, n) each, and W of shape (k, n_data)."""
    shapes = _shapes(hypothesis, hypothesis.data)
    sizes = _sizes(hypothesis, len(shapes))
    width, count = 2 * len(shapes[0]), len(shapes)
    ends = np.cumsum([2 * len(data.frequency) for data in hypothesis.data])
    found = np.zeros(len(changes[0][0]))
    for e, (size, parts) in enumerate(zip(sizes, changes, strict=True)):
        for i, (change, smooth, end) in enumerate(zip(parts, shapes, ends, strict=True)):
            rows = np.s_[end - 2 * change.shape[-1] : end]
            weight = weights[e * width : (e + 1) * width, rows]
            if count > 1:
                first = width * (len(sizes) + e * count + i)
                weight = weight + weights[first : first + width, rows]
            both = np.concatenate([smooth, 1j * smooth])[:, None] * change
            found += size * np.einsum("kn,kmn->m", weight, hypothesis.experiments[i].whiten(both))
    return found


def _whitened(hypothesis: Hypothesis, logs: Sequence[ComplexArray]) -> RealArray:
    return np.concatenate([hypothesis.experiments[i].whiten(values) for i, values in enumerate(logs)], axis=-1)


def _modulated(
    hypothesis: Hypothesis, signature: Sequence[ComplexArray], shapes: Sequence[RealArray]
) -> list[RealArray]:
    """Return by configuration the whitened columns of a signature with smooth relative errors of unit size."""
    blocks = []
    for experiment, limited, smooth in zip(hypothesis.experiments, signature, shapes, strict=True):
        parts = [experiment.whiten(smooth * limited).T, experiment.whiten(1j * smooth * limited).T]
        blocks.append(np.concatenate(parts, axis=1))
    return blocks


def _limited(change: ComplexArray) -> ComplexArray:
    """Return a change of ln(ratio) no larger than what still is a small error of it; nothing where it is not known."""
    known = np.where(np.isfinite(change), change, 0.0)
    return np.asarray(known / np.maximum(np.abs(known) / _MOST, 1.0))


def _kernel(a: RealArray, b: RealArray, length: float) -> RealArray:
    return np.asarray(np.exp(-0.5 * (np.subtract.outer(a, b) / length) ** 2))
