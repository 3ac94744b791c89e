"""How far the gap shrinks on data that were not used in the fit."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted, minimised
from multilayer.diagnosis.model_discrepancy import law_parts
from multilayer.executors import run_all
from multilayer.experiments.hypothesis import Data, Hypothesis
from multilayer.inference.low_rank import LowRank, WithModelErrors, prediction_root

_FEWEST = 4  # bursts of which blocks can be made


@dataclass(frozen=True)
class Shrinkage:
    """The gap on held-out data.

    Attributes
    ----------
    before, after : float
        ``G = r^T C^-1 r / n`` of nominal model and hypothesis; 1 where nothing but noise is left, and what the kept
        data leave open of the parameters.
    held_out : str
        What was left out.
    log_score : float
        Log density of the left-out data as foretold with the hypothesis, but for a constant of the data.
    """

    before: float
    after: float
    held_out: str
    log_score: float = 0.0

    @property
    def share(self) -> float:
        """``1 - (G_after - 1)+ / (G_before - 1)+``; 0 where there was no gap."""
        gap = self.before - 1
        return 0.0 if gap <= 0 else float(1 - max(self.after - 1, 0.0) / gap)


def folds(hypothesis: Hypothesis) -> tuple[str, list[tuple[list[Data], list[Data]]]]:
    """Return how data are left out, and pairs (kept, left out).

    One configuration after the other; of a single one contiguous blocks of bursts, whose neighbours are left out too.
    """
    data = list(hypothesis.data)
    if len(data) > 1:
        pairs = [([other for other in data if other is not one], [one]) for one in data]
        return "leave one configuration out", pairs
    (only,) = data
    n = len(only.centres)
    if n < _FEWEST:
        return "nothing could be left out", []
    found = []
    for block in np.array_split(np.arange(n), min(hypothesis.blocks, n // 2)):
        guard = np.arange(max(block[0] - 1, 0), min(block[-1] + 2, n))
        kept = np.setdiff1d(np.arange(n), guard)
        if len(kept) > 1:
            found.append(([only.part(kept)], [only.part(block)]))
    return "contiguous blocks of frequencies, with guards", found


def shrinkage(
    nominal: Fitted, fitted: Sequence[Fitted], executor: Executor | None = None, before: float | None = None
) -> list[Shrinkage]:
    """Return the held-out shrinkage of several hypotheses.

    Parameters
    ----------
    nominal : Fitted
    fitted : sequence of Fitted
    executor : Executor, optional
        Where fits run; in this process when left out.
    before : float, optional
        `Shrinkage.before` of the nominal model where it is known already.
    """
    how, pairs = folds(nominal.hypothesis)
    if not pairs:
        return [Shrinkage(float("nan"), float("nan"), how) for _ in fitted]
    everything = [*fitted] if before is not None else [nominal, *fitted]
    tasks = [(one, kept, left) for one in everything for kept, left in pairs]
    foretold = run_all(_foretold, tasks, executor)
    folded = [foretold[i : i + len(pairs)] for i in range(0, len(foretold), len(pairs))]
    gaps = [float(np.mean(np.concatenate([residual for residual, _ in parts]) ** 2)) for parts in folded]
    scores = [sum(score for _, score in parts) for parts in folded]
    if before is None:
        before, gaps, scores = gaps[0], gaps[1:], scores[1:]
    return [Shrinkage(before, gap, how, score) for gap, score in zip(gaps, scores, strict=True)]


def _foretold(task: tuple[Fitted, Sequence[Data], Sequence[Data]]) -> tuple[RealArray, float]:
    """Return the residuals of data that are left out, in units of noise and of what the kept data leave open.

    And the logarithm of their density as foretold, in which the effects' laws may be wrong, too. The task is a fit, and
    the data that are kept and left. What the kept data tell of the error that a law makes everywhere is foretold.
    """
    one, kept, left = task
    seen, unseen = one.hypothesis.with_data(kept), one.hypothesis.with_data(left)

    def errors(part: Hypothesis, z: RealArray) -> tuple[RealArray, RealArray]:
        return law_parts(part, z, one.hypothesis)

    start = one.minimum.z
    soft = WithModelErrors(seen, LowRank.of(np.concatenate(errors(seen, start), axis=1))) if one.errors else seen
    found = minimised(soft, start)
    residual, slopes = unseen.linearised(found.z)
    open_of_unknowns = LowRank.of(prediction_root(slopes, found.jacobian))
    if not one.errors:
        return open_of_unknowns.whitened(residual), open_of_unknowns.log_density(residual)
    here, slopes_here = seen.linearised(found.z)
    common, own = errors(seen, found.z)
    elsewhere, anew = errors(unseen, found.z)
    laws = np.concatenate([common, own], axis=1)
    amounts = np.linalg.solve(np.eye(laws.shape[1]) + laws.T @ laws, laws.T @ here)
    residual = residual - elsewhere @ amounts[: common.shape[1]]
    # unknowns and errors of laws together; what is each configuration's own is not seen elsewhere
    known = np.concatenate([slopes_here, laws], axis=1)
    told = np.concatenate([slopes, elsewhere, np.zeros((len(residual), own.shape[1]))], axis=1)
    every = LowRank.of(np.concatenate([prediction_root(told, known), anew], axis=1))
    return open_of_unknowns.whitened(residual), every.log_density(residual)
