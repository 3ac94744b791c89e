"""Experimental design: which change of an experiment best discriminates between rival hypotheses.

G. E. P. Box & W. J. Hill, Technometrics 9 (1967) 57-71: the expected gain is the distance of two hypotheses'
predictions, weighted by the product of their probabilities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import partial
from itertools import combinations
from typing import Any, NamedTuple, TypeAlias, TypeVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray, half_turn
from multilayer.diagnosis.evidence import UNKNOWN
from multilayer.diagnosis.fitting import Fitted
from multilayer.executors import run_all
from multilayer.experiments.effects import BaseEffect
from multilayer.experiments.places import LawAtPlace

Rivals: TypeAlias = Sequence[tuple[Fitted, float]]  # hypotheses with their probabilities
_ENOUGH = 100.0  # nats: a design that is sure to tell; of such the cheapest comes first


@dataclass(frozen=True)
class Design:
    """A planned change of an experiment.

    Attributes
    ----------
    change : str
        In words.
    cost : float
        Hours of a laboratory's time.
    without : tuple of str
        Effects that the change removes, besides those that name it as `absent_in`.
    """

    change: str
    cost: float
    without: tuple[str, ...] = field(default=(), kw_only=True)

    def removes(self, effect: BaseEffect) -> bool:
        """Tell whether an effect does not act after the change."""
        return effect.name in self.without or effect.absent_in == self.change


class Prediction(NamedTuple):
    """Predicted values, shape (n,), and a root of their covariance by the unknowns' posterior, shape (n, d)."""

    values: ComplexArray
    root: ComplexArray


D = TypeVar("D", bound=Design)
T = TypeVar("T")


def unchanged(part: T) -> T:
    """Return a part of an experiment that a design leaves as it is; a named function, as pickling needs it."""
    return part


def rank_designs(
    rivals: Rivals,
    designs: Sequence[D],
    unchanged_design: D,
    predict: Callable[[Fitted, D], Prediction],
    executor: Executor | None = None,
    *,
    has_phase: bool = False,
) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``, the most informative for its cost first.

    Parameters
    ----------
    rivals : sequence of (Fitted, probability)
    designs : sequence of Design
    unchanged_design : Design
        That of the experiment as it was.
    predict : callable
        Prediction of a hypothesis for a design.
    executor : Executor, optional
        Where predictions are made; in this process when left out. `designs` and `predict` must be picklable.
    has_phase : bool
        Whether the imaginary part of predictions is an angle.
    """
    if len(rivals) < 2:
        return []
    entries = []
    hypotheses = [fitted for fitted, _ in rivals]
    tasks = [unchanged_design, *designs]
    as_before, *predicted = run_all(partial(_predictions, predict, hypotheses), tasks, executor)
    for design, predictions in zip(designs, predicted, strict=True):
        if all(np.allclose(new[0], old[0], rtol=1e-9) for new, old in zip(predictions, as_before, strict=True)):
            continue  # changes nothing for these hypotheses: a mere repetition
        best: tuple[float, int, int] = (-1.0, 0, 1)
        gains, weights = 0.0, 0.0
        for (i, a), (j, b) in combinations(enumerate(rivals), 2):
            weight = a[1] * b[1]
            gain = _half_squared_distance(predictions[i], predictions[j], a[0], has_phase=has_phase)
            gains, weights = gains + weight * gain, weights + weight
            best = max(best, (weight * gain, i, j))
        entries.append(
            {
                "change": design.change,
                "separates": [_names(rivals[i][0]) for i in best[1:]],
                "expected_gain": round(gains / max(weights, 1e-12), 2),
                "cost_hours": design.cost,
            }
        )
    return sorted(entries, key=lambda entry: -min(entry["expected_gain"], _ENOUGH) / entry["cost_hours"])


def _names(fitted: Fitted) -> list[str]:
    """Return the names of a hypothesis' effects; that of the unknown cause where a law is drawn."""
    is_drawn = any(isinstance(effect, LawAtPlace) and not effect.error_of for effect in fitted.hypothesis.effects)
    return list(UNKNOWN if is_drawn else fitted.names)


def _predictions(predict: Callable[[Fitted, D], Prediction], rivals: Sequence[Fitted], design: D) -> list[Prediction]:
    return [predict(fitted, design) for fitted in rivals]


def posterior_without(fitted: Fitted, removed: Callable[[Any], bool]) -> tuple[list[Any], RealArray, RealArray]:
    """Return the effects that a design leaves, and the posterior of the unknowns without the removed effects.

    Parameters
    ----------
    fitted : Fitted
    removed : callable
        Whether the design removes an effect.

    Returns
    -------
    effects : list of effects
    z : array, shape (d,)
    root : array, shape (d, d)
        Of the covariance of z.
    """
    hypothesis = fitted.hypothesis
    effects = [effect for effect in hypothesis.effects if not removed(effect)]
    names = {parameter.name for parameter in hypothesis.with_effects(*effects).parameters}
    index = [i for i, parameter in enumerate(hypothesis.parameters) if parameter.name in names]
    # of directions that the data know to rounding only, the variance may come out below 0
    variances, axes = np.linalg.eigh(fitted.minimum.covariance[np.ix_(index, index)])
    return effects, fitted.minimum.z[index], np.asarray(axes * np.sqrt(np.maximum(variances, 0.0)))


def _half_squared_distance(a: Prediction, b: Prediction, fitted: Fitted, *, has_phase: bool) -> float:
    """Return half the squared Mahalanobis distance of two predictions, nats, by noise and by both posteriors."""
    difference = a.values - b.values
    if has_phase:
        difference = difference.real + 1j * half_turn(difference.imag)
    whiten = fitted.hypothesis.experiments[0].whiten
    delta, root = whiten(difference), whiten(np.concatenate([a.root, b.root], axis=1).T).T
    # (1 + S S^T)^-1 by the matrix inversion lemma
    along = root.T @ delta
    inner = np.linalg.solve(np.eye(root.shape[1]) + root.T @ root, along)
    return float(0.5 * (delta @ delta - along @ inner))
