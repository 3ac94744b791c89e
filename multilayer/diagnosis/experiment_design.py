"""Which change of an experiment best separates the hypotheses that are still alive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from functools import partial
from itertools import combinations
from typing import Any, Protocol, TypeAlias, TypeVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted
from multilayer.executors import run_all

Alive: TypeAlias = Sequence[tuple[Fitted, float]]  # hypotheses with their probabilities
_MOST = 1e4  # nats


class Change(Protocol):
    """A change of an experiment."""

    @property
    def change(self) -> str:
        """In words."""

    @property
    def cost(self) -> float:
        """Hours of a laboratory's time."""


C = TypeVar("C", bound=Change)
T = TypeVar("T")


def unchanged(part: T) -> T:
    """Return a part of an experiment that a change leaves alone: by name, as other processes need it."""
    return part


def rank_changes(
    alive: Alive,
    menu: Sequence[C],
    nothing: C,
    predict: Callable[[Fitted, C], Any],
    distance: Callable[[Any, Any, Fitted], float],
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``, the most informative for its cost first.

    Parameters
    ----------
    alive : sequence of (Fitted, probability)
    menu : sequence of changes
    nothing : change
        That changes nothing.
    predict : callable
        Gives what a hypothesis foretells after a change: values of shape (n,), and whatever `distance` takes.
    distance : callable
        Gives half the squared distance, nats, of two predictions in units of their common uncertainty; its third
        argument is the first one's hypothesis.
    executor : Executor, optional
        Where predictions are made; in this process when left out. `menu` and `predict` must be fit for pickling.

    Notes
    -----
    After G. E. P. Box & W. J. Hill, Technometrics 9 (1967) 57-71: the expected gain is the distance of two hypotheses'
    predictions, weighted by the product of their probabilities.
    """
    if len(alive) < 2:
        return []
    found = []
    hypotheses = [fitted for fitted, _ in alive]
    as_before, *foretold = run_all(partial(_predictions, predict, hypotheses), [nothing, *menu], executor)
    for change, predictions in zip(menu, foretold, strict=True):
        if all(np.allclose(new[0], old[0], rtol=1e-9) for new, old in zip(predictions, as_before, strict=True)):
            continue  # of no consequence for what is still alive: a mere repetition
        best: tuple[float, int, int] = (-1.0, 0, 1)
        gains, weights = 0.0, 0.0
        for (i, a), (j, b) in combinations(enumerate(alive), 2):
            weight = a[1] * b[1]
            gain = min(distance(predictions[i], predictions[j], a[0]), _MOST)
            gains, weights = gains + weight * gain, weights + weight
            best = max(best, (weight * gain, i, j))
        found.append(
            {
                "change": change.change,
                "separates": [list(alive[i][0].names) for i in best[1:]],
                "expected_gain": round(gains / max(weights, 1e-12), 2),
                "cost_hours": change.cost,
            }
        )
    return sorted(found, key=lambda entry: -entry["expected_gain"] / entry["cost_hours"])


def _predictions(predict: Callable[[Fitted, C], Any], alive: Sequence[Fitted], change: C) -> list[Any]:
    return [predict(fitted, change) for fitted in alive]


def half_squared(delta: RealArray, spread: RealArray) -> float:
    """Return ``delta^T (1 + S S^T)^-1 delta / 2`` for whitened differences (n,) and what is open of them, S (n, d)."""
    along = spread.T @ delta
    inner = np.linalg.solve(np.eye(spread.shape[1]) + spread.T @ spread, along)
    return float(0.5 * (delta @ delta - along @ inner))
