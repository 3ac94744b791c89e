"""Cross-validation: how far the gap shrinks on data that were not used in the fit.

Leave-one-group-out, with the log predictive density as score: A. Vehtari, A. Gelman & J. Gabry, Stat. Comput. 27 (2017)
1413-1432.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted, minimise_scaled
from multilayer.diagnosis.model_discrepancy import law_parts
from multilayer.executors import run_all
from multilayer.experiments.hypothesis import Data, Hypothesis
from multilayer.inference.low_rank import LowRank, WithModelErrors, prediction_root
from multilayer.inference.problem import Minimum, Problem
from multilayer.inference.pulls import stated_pulls

_FEWEST, _MANY = 4, 6  # bursts that can be divided into blocks, and into blocks of several
_FINE = (60, 1e-6)  # evaluations, and relative change of the cost at convergence: a thousandth of a nat


class Part(NamedTuple):
    """The misfit of one part of the data that was held out, ``r^T C^-1 r`` over their number, without pulls.

    Attributes
    ----------
    before, after : float
        Of the nominal model and of the hypothesis.
    n : int
        Number of the data.
    """

    before: float
    after: float
    n: int


@dataclass(frozen=True)
class Shrinkage:
    """The gap on held-out data.

    Attributes
    ----------
    before, after : float
        ``G = (r^T C^-1 r + p^T p) / n`` of the nominal model and of the hypothesis, C being the covariance of noise and
        of predictions from the data that were fitted, p the pulls of stated quantities: a model that predicts well with
        a stated quantity many standard deviations off has a gap. `noise` where only noise is left.
    held_out : str
        What was left out, in words.
    log_score : float
        Log predictive density of the held-out data with the hypothesis, without a constant of the data.
    noise : float
        What noise alone leaves of G: 1 where it is as large as stated.
    n : float
        Number of the data held out, each part of a complex one by itself.
    parts : tuple of Part
        The parts that were held out in turn.
    """

    before: float
    after: float
    held_out: str
    log_score: float = 0.0
    noise: float = 1.0
    n: float = float("inf")
    parts: tuple[Part, ...] = ()

    @property
    def share(self) -> float:
        """``1 - (G_after - noise)+ / (G_before - noise)+``; 0 where there was no gap."""
        gap = self.before - self.noise
        return 0.0 if gap <= 0 else float(1 - max(self.after - self.noise, 0.0) / gap)

    @property
    def scatter(self) -> float:
        """Standard deviation of the share of a right cause, by noise alone; infinite where there is no gap."""
        gap = self.before - self.noise
        return float(self.noise * np.sqrt(2 / self.n) / gap) if gap > 0 else float("inf")


def folds(hypothesis: Hypothesis) -> tuple[str, list[tuple[list[Data], list[Data]]]]:
    """Return what is held out, in words, and pairs of data (fitted, held out).

    Each configuration in turn; of a single one contiguous blocks of bursts, whose neighbours are not fitted either.
    """
    data = list(hypothesis.data)
    if len(data) > 1:
        pairs = [([other for other in data if other is not part], [part]) for part in data]
        return "leave one configuration out", pairs
    (only,) = data
    n = len(only.centres)
    if n < _FEWEST:
        return "nothing could be left out", []
    pairs = []
    # of few, one by one: beside two with their neighbours hardly any would be left
    for block in np.array_split(np.arange(n), min(hypothesis.blocks, n // 2) if n >= _MANY else n):
        guard = np.arange(max(block[0] - 1, 0), min(block[-1] + 2, n))
        kept = np.setdiff1d(np.arange(n), guard)
        if len(kept) > 1:
            pairs.append(([only.part(kept)], [only.part(block)]))
    return "contiguous blocks of frequencies, with guards", pairs


def cross_validate(
    nominal: Fitted,
    fitted: Sequence[Fitted],
    executor: Executor | None = None,
    known: Shrinkage | None = None,
    noise: float = 1.0,
) -> list[Shrinkage]:
    """Return the shrinkage of the gap on held-out data for several hypotheses.

    Parameters
    ----------
    nominal : Fitted
    fitted : sequence of Fitted
    executor : Executor, optional
        Where fits run; in this process when left out.
    known : Shrinkage, optional
        Of another hypothesis beside the same nominal model, of which it tells the gap.
    noise : float
        `Shrinkage.noise`.
    """
    held_out, pairs = folds(nominal.hypothesis)
    if not pairs:
        return [Shrinkage(float("nan"), float("nan"), held_out) for _ in fitted]
    hypotheses = [*fitted] if known else [nominal, *fitted]
    tasks = [(hypothesis, kept, left) for hypothesis in hypotheses for kept, left in pairs]
    predicted = run_all(_predict_held_out, tasks, executor)
    by_hypothesis = [predicted[i : i + len(pairs)] for i in range(0, len(predicted), len(pairs))]
    n = sum(part.n for part in by_hypothesis[0])
    without = [] if known else by_hypothesis.pop(0)
    before = known.before if known else _gap(without)
    each = [part.before for part in known.parts] if known else [part.square / part.n for part in without]
    return [
        Shrinkage(
            before, _gap(parts), held_out, sum(part.log_score for part in parts), noise, n,
            tuple(Part(one, part.square / part.n, part.n) for one, part in zip(each, parts, strict=True)),
        )
        for parts in by_hypothesis
    ]  # fmt: skip


class _Prediction(NamedTuple):
    """How held-out data lie to what is predicted of them: without the errors of laws, and the density with these.

    Attributes
    ----------
    square : float
        Squared distance in standard deviations, of noise and of the unknowns' posterior.
    n : int
        Number of the data.
    log_score : float
        Log predictive density.
    pulls : array
        Of stated quantities in the fit of the other data.
    """

    square: float
    n: int
    log_score: float
    pulls: RealArray

    @classmethod
    def of(cls, residual: RealArray, by_unknowns: LowRank, with_laws: LowRank, pulls: RealArray) -> _Prediction:
        """Return it from a residual and its covariances, without and with the errors of laws."""
        square = float(np.sum(by_unknowns.whitened(residual) ** 2))
        return cls(square, len(residual), with_laws.log_density(residual), pulls)


def _gap(parts: Sequence[_Prediction]) -> float:
    squares, n = sum(part.square for part in parts), sum(part.n for part in parts)
    return float((squares + np.mean([part.pulls @ part.pulls for part in parts])) / n)


def _predict_held_out(task: tuple[Fitted, Sequence[Data], Sequence[Data]]) -> _Prediction:
    """Return the whitened residuals of held-out data, and the log predictive density of these data.

    The task is a fit of all data, the data to be fitted again, and those held out. Residuals are whitened by noise and
    by the posterior of the unknowns. In the density the effects' laws may be wrong, too; the errors of laws that are
    common to all configurations are predicted from the fitted data.
    """
    fitted, kept_data, held_out_data = task
    kept, held_out = fitted.hypothesis.with_data(kept_data), fitted.hypothesis.with_data(held_out_data)

    def law_columns(part: Hypothesis, z: RealArray) -> tuple[RealArray, RealArray]:
        return law_parts(part, z, fitted.hypothesis)

    start = fitted.minimum.z
    problem: Problem = kept
    if fitted.errors:
        problem = WithModelErrors(kept, LowRank.of(np.concatenate(law_columns(kept, start), axis=1)))
    minimum = minimise_scaled(problem, start, *_FINE)
    residual, slopes = held_out.linearised(minimum.z)
    pulls = stated_pulls(kept.parameters, minimum.z)
    by_unknowns = LowRank.of(prediction_root(slopes, minimum.jacobian))
    if not fitted.errors:
        found = [_Prediction.of(residual, by_unknowns, by_unknowns, pulls)]
        if fitted.hypothesis.effects:
            found.append(_by_joint_minimum(start, kept, held_out, minimum, pulls))
        return max(found, key=lambda prediction: prediction.log_score)
    kept_residual, kept_slopes = kept.linearised(minimum.z)
    common, separate = law_columns(kept, minimum.z)
    held_out_common, held_out_separate = law_columns(held_out, minimum.z)
    laws = np.concatenate([common, separate], axis=1)
    amounts = np.linalg.solve(np.eye(laws.shape[1]) + laws.T @ laws, laws.T @ kept_residual)
    residual = residual - held_out_common @ amounts[: common.shape[1]]
    # unknowns and errors of laws together; errors separate for each configuration do not act on the held-out ones
    fitted_columns = np.concatenate([kept_slopes, laws], axis=1)
    zeros = np.zeros((len(residual), separate.shape[1]))
    predicted_columns = np.concatenate([slopes, held_out_common, zeros], axis=1)
    root = np.concatenate([prediction_root(predicted_columns, fitted_columns), held_out_separate], axis=1)
    return _Prediction.of(residual, by_unknowns, LowRank.of(root), pulls)


def _by_joint_minimum(
    start: RealArray, kept: Hypothesis, held_out: Hypothesis, minimum: Minimum, pulls: RealArray
) -> _Prediction:
    """Return the prediction by the ratio of two evidences: of fitted and held-out data together, and of the former.

    The same as by derivatives where the unknowns' posterior is normal. It is far from normal where the fitted data do
    not show what acts among the others, as a resonance there does: then derivatives hold next to a minimum only that
    fitted data do not tell from others.

    Parameters
    ----------
    start : array, shape (d,)
        Coordinates at which the hypothesis fits all data.
    kept, held_out : Hypothesis
    minimum : Minimum
        Of the fitted data.
    pulls : array
        Of stated quantities there.
    """
    parts = [part.linearised(start) for part in (kept, held_out)]
    residual, slopes = (np.concatenate(columns) for columns in zip(*parts, strict=True))
    joint = Minimum(start, residual, slopes)
    n = len(residual) - len(minimum.residual)
    return _Prediction(joint.cost - minimum.cost, n, joint.log_evidence - minimum.log_evidence, pulls)
