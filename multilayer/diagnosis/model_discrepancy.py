"""Model discrepancy: errors embedded in the laws of effects, and smooth discrepancies of unknown origin.

No law is exact, and its error grows with the effect. Errors embedded in a model instead of added to its results: K.
Sargsyan, X. Huan & H. N. Najm, Int. J. Uncertain. Quantif. 9 (2019) 365-394.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial

import numpy as np
from scipy.linalg import block_diag

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.thresholds import DISCREPANCY_LENGTH, LAW_LENGTH
from multilayer.experiments.hypothesis import Data, Hypothesis
from multilayer.inference.derivative import FINE, Stencil
from multilayer.inference.low_rank import LowRank
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.reparameterisation import Reparameterisation

_KEPT = 1e-4  # least eigenvalue of its covariance that is kept, relative to the largest
_MOST = 3.0  # limit of changes of ln(ratio) where the reading nearly vanishes: larger ones are not first-order errors
_TINY = 1e-12


@dataclass(frozen=True)
class WithLawErrors(Problem):
    """A hypothesis with errors of its effects' laws integrated out, in the hypothesis' unknowns.

    The data are ``r(z) + B(z) a`` with a ~ N(0, 1), see `law_parts`. With a integrated out, minus twice the log density
    is ``r^T C^-1 r + ln |C|``, ``C = 1 + B B^T``: the sum of squares of this problem's residuals, the last of which is
    the root of the second term (which is not negative, as no eigenvalue of C is below 1). `WithModelErrors` holds
    B fixed. Computing B again at the minimum so found, and so on, need not converge, and its limit depends on the
    start; here B follows z, and a minimum is that of a single function.

    Notes
    -----
    The derivative is ``C^(-1/2) d(r + B a)`` with the best amounts ``a = -B^T C^-1 r`` fixed: exact for the gradient,
    the Gauss-Newton approximation for the Hessian (variable projection: G. H. Golub & V. Pereyra, SIAM J. Numer. Anal.
    10 (1973) 413-432; L. Kaufman, BIT 15 (1975) 49-57).

    Attributes
    ----------
    hypothesis : Hypothesis
    exact : bool
        Whether differences for derivatives are to both sides, as a minimum needs that is right to many digits; one that
        is only compared is found with half as many points.
    """

    hypothesis: Hypothesis
    exact: bool = True

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The hypothesis' parameters."""
        return self.hypothesis.parameters

    def reparameterisation(self, z: RealArray, *, far: bool = False) -> Reparameterisation | None:
        """Return that of the hypothesis."""
        return self.hypothesis.reparameterisation(z, far=far)

    def errors(self, z: RealArray) -> LowRank:
        """Return the covariance of noise and laws' errors at coordinates of shape (d,)."""
        return LowRank.of(law_basis(self.hypothesis, z))

    def residual(self, z: RealArray) -> RealArray:
        """Return whitened residuals, shape (..., n_data + 1)."""
        rows = z.reshape(-1, z.shape[-1])
        pairs = zip(map(self.errors, rows), self.hypothesis.residual(rows), strict=True)
        residuals = [np.append(errors.whitened(values), np.sqrt(errors.log_determinant)) for errors, values in pairs]
        return np.reshape(residuals, (*z.shape[:-1], -1))

    def linearised(self, z: RealArray) -> tuple[RealArray, RealArray]:
        """Return residual and derivative, shapes (n_data + 1,) and (n_data + 1, d), from one batch."""
        hypothesis = self.hypothesis
        stencil = self.stencil(z, partial(Stencil.central, step=FINE) if self.exact else Stencil.forward)
        differences, changes = differences_and_changes(hypothesis, stencil.points)
        here = [[change[0] for change in parts] for parts in changes]
        basis = np.concatenate(_columns(hypothesis, here, hypothesis.data), axis=1)
        errors = LowRank.of(basis)
        residual = _whitened(hypothesis, [values[0] for values in differences])
        factors = _factors(hypothesis, -basis.T @ errors.inverse(residual))
        total = [*differences]
        for of_effect, parts in zip(factors, changes, strict=True):
            total = [a + factor * change for a, factor, change in zip(total, of_effect, parts, strict=True)]
        slopes = stencil.derivative(_whitened(hypothesis, total))
        # d ln |C| = 2 tr(B^T C^-1 dB)
        root = np.sqrt(errors.log_determinant)
        traces = _traced(hypothesis, changes, errors.inverse(basis.T), self._units)
        growth = stencil.derivative(traces) / max(root, _TINY)
        values = np.append(errors.whitened(residual), root)
        return values, np.concatenate([errors.whitened(slopes.T).T, growth[None]])

    @cached_property
    def _units(self) -> list[list[RealArray]]:
        """Whitened unit changes of each part of each datum, by experiment and part, shape (n_data, n)."""
        h = self.hypothesis
        return [
            [experiment.whiten(unit * np.eye(len(data.frequency))).T for unit in h.part_units]
            for experiment, data in zip(h.experiments, h.data, strict=True)
        ]

    def minimum(self, minimum: Minimum) -> Minimum:
        """Return a minimum of this problem as that of the hypothesis, with residuals whitened by `errors`."""
        return replace(minimum, residual=minimum.residual[:-1], jacobian=minimum.jacobian[:-1])


def smooth_basis(hypothesis: Hypothesis) -> RealArray:
    """Return columns B with B B^T the whitened covariance of a smooth unit discrepancy, shape (n_data, k).

    Amplitude and phase of every configuration have independent discrepancies, smooth in ln f.
    """
    blocks = []
    parts = hypothesis.part_units
    total = sum(len(parts) * len(data.frequency) for data in hypothesis.data)
    first = 0
    for i, data in enumerate(hypothesis.data):
        n = len(data.frequency)
        distance = np.subtract.outer(np.log(data.frequency), np.log(data.frequency)) / DISCREPANCY_LENGTH
        sizes, vectors = np.linalg.eigh(np.exp(-0.5 * distance**2))
        kept = sizes > _KEPT * sizes[-1]
        columns = (vectors[:, kept] * np.sqrt(sizes[kept])).T * hypothesis.unit
        for part in parts:
            block = np.zeros((total, columns.shape[0]))
            block[first : first + len(parts) * n] = hypothesis.experiments[i].whiten(part * columns).T
            blocks.append(block)
        first += len(parts) * n
    return np.concatenate(blocks, axis=1)


def law_basis(hypothesis: Hypothesis, z: RealArray) -> RealArray:
    """Return columns B with B B^T the whitened covariance of the errors of the effects' laws, shape (n_data, k)."""
    return np.concatenate(law_parts(hypothesis, z), axis=1)


def law_parts(hypothesis: Hypothesis, z: RealArray, whole: Hypothesis | None = None) -> tuple[RealArray, RealArray]:
    """Return the columns of `law_basis` in two parts: common to all configurations, and separate for each.

    The error is the change by an effect times a complex factor that is smooth in ln f, of the size of the effect's
    `law_error`: large where the effect is large, and 0 where it does not act.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (d,)
    whole : Hypothesis, optional
        The hypothesis with all its data, where `hypothesis` has only a part: the common columns of all parts then refer
        to the same unknown errors.
    """
    changes = differences_and_changes(hypothesis, z)[1]
    return _columns(hypothesis, changes, (whole or hypothesis).data)


def differences_and_changes(
    hypothesis: Hypothesis, z: RealArray
) -> tuple[list[ComplexArray], list[list[ComplexArray]]]:
    """Return `differences`, and by effect their limited change for a relative error of 1 in its law.

    Parameters
    ----------
    hypothesis : Hypothesis
    z : array, shape (..., d)
    """
    differences = hypothesis.differences(z)
    changes = [
        [_limited(change, hypothesis.unit) for change in hypothesis.law_change(index, z, differences)]
        for index, error in enumerate(hypothesis.law_errors)
        if error
    ]
    return differences, changes


def _columns(
    hypothesis: Hypothesis, changes: Sequence[Sequence[ComplexArray]], all_data: Sequence[Data]
) -> tuple[RealArray, RealArray]:
    """Return the columns of `law_parts` from the changes by each effect and configuration, shape (n,)."""
    shapes = _shapes(hypothesis, all_data)
    total = sum(len(hypothesis.part_units) * len(data.frequency) for data in hypothesis.data)
    common, separate = [np.empty((total, 0))], [np.empty((total, 0))]
    for size, parts in zip(_sizes(hypothesis, len(all_data)), changes, strict=True):
        blocks = _modulated(hypothesis, parts, shapes)
        common.append(size * np.concatenate(blocks, axis=0))
        if len(all_data) > 1:
            separate.append(size * block_diag(*blocks))
    return np.concatenate(common, axis=1), np.concatenate(separate, axis=1)


def _sizes(hypothesis: Hypothesis, configurations: int) -> list[float]:
    """Return the standard deviations of errors of laws, each for the common part and for the separate parts alike."""
    share = np.sqrt(0.5) if configurations > 1 else 1.0
    return [float(share * error) for error in hypothesis.law_errors if error]


def _shapes(hypothesis: Hypothesis, all_data: Sequence[Data]) -> list[RealArray]:
    """Return by configuration smooth functions of ln f, shape (k, n), whose sum with normal weights is an error."""
    at = np.log(np.concatenate([data.frequency for data in all_data]))
    low, high = float(at.min()), float(at.max())
    return [_smooth(low, high, np.asarray(data.frequency, dtype=float).tobytes()) for data in hypothesis.data]


@lru_cache(maxsize=256)
def _smooth(low: float, high: float, frequency: bytes) -> RealArray:
    knots = np.arange(low, high + LAW_LENGTH / 2, LAW_LENGTH / 2)
    sizes, vectors = np.linalg.eigh(_kernel(knots, knots, LAW_LENGTH))
    kept = sizes > 1e-3 * sizes[-1]
    weights = vectors[:, kept] / np.sqrt(sizes[kept])
    return np.asarray((_kernel(np.log(np.frombuffer(frequency)), knots, LAW_LENGTH) @ weights).T)


def _factors(hypothesis: Hypothesis, amounts: RealArray) -> list[list[ComplexArray]]:
    """Return relative errors of laws by effect and configuration, shape (n,), for amounts of the columns."""
    shapes = _shapes(hypothesis, hypothesis.data)
    sizes = _sizes(hypothesis, len(shapes))
    half, n_parts = len(shapes[0]), len(hypothesis.part_units)
    width = n_parts * half
    common, separate = np.split(amounts, [width * len(sizes)])
    rows = common.reshape(len(sizes), 1, width)
    rows = rows + separate.reshape(len(sizes), len(shapes), width) if len(shapes) > 1 else rows
    return [
        [np.asarray(size * _joined(row, half, n_parts) @ shape) for row, shape in zip(weights, shapes, strict=True)]
        for size, weights in zip(sizes, rows, strict=True)
    ]


def _traced(
    hypothesis: Hypothesis,
    changes: Sequence[Sequence[ComplexArray]],
    weights: RealArray,
    whitened_units: Sequence[Sequence[RealArray]],
) -> RealArray:
    """Return ``tr(W B)``, shape (m,), for bases B of changes of shape (m, n) each, and W of shape (k, n_data).

    Whitening is linear: W, whitened in place of the bases, costs as much for many changes as for one.
    """
    shapes, units = _shapes(hypothesis, hypothesis.data), hypothesis.part_units
    sizes = _sizes(hypothesis, len(shapes))
    width, count = len(units) * len(shapes[0]), len(shapes)
    ends = np.cumsum([len(units) * len(data.frequency) for data in hypothesis.data])
    trace = np.zeros(len(changes[0][0]))
    for i, (smooth, end, of_units) in enumerate(zip(shapes, ends, whitened_units, strict=True)):
        rows = np.s_[end - len(units) * smooth.shape[-1] : end]
        every = np.concatenate([unit * smooth for unit in units])
        for e, size in enumerate(sizes):
            weight = weights[e * width : (e + 1) * width, rows]
            if count > 1:
                first = width * (len(sizes) + e * count + i)
                weight = weight + weights[first : first + width, rows]
            on_change = sum(np.conj(unit) * (weight @ of_unit) for unit, of_unit in zip(units, of_units, strict=True))
            trace += size * (changes[e][i] @ np.sum(every * on_change, axis=0)).real
    return trace


def _whitened(hypothesis: Hypothesis, logs: Sequence[ComplexArray]) -> RealArray:
    return np.concatenate([hypothesis.experiments[i].whiten(values) for i, values in enumerate(logs)], axis=-1)


def _modulated(hypothesis: Hypothesis, changes: Sequence[ComplexArray], shapes: Sequence[RealArray]) -> list[RealArray]:
    """Return by configuration the whitened columns of changes with smooth relative errors of unit size."""
    blocks = []
    for experiment, change, smooth in zip(hypothesis.experiments, changes, shapes, strict=True):
        parts = [experiment.whiten(unit * smooth * change).T for unit in hypothesis.part_units]
        blocks.append(np.concatenate(parts, axis=1))
    return blocks


def _joined(row: RealArray, half: int, n_parts: int) -> ComplexArray | RealArray:
    """Return amounts of real and imaginary part, if there is one, as numbers, shape (half,)."""
    return row[:half] + 1j * row[half:] if n_parts > 1 else row[:half]


def _limited(change: ComplexArray, unit: float) -> ComplexArray:
    """Return a change of ln(ratio) limited in amplitude to `_MOST` units, and 0 where it is not finite."""
    finite = np.where(np.isfinite(change), change, 0.0)
    return np.asarray(finite / np.maximum(np.abs(finite) / (_MOST * unit), 1.0))


def _kernel(a: RealArray, b: RealArray, length: float) -> RealArray:
    return np.asarray(np.exp(-0.5 * (np.subtract.outer(a, b) / length) ** 2))
