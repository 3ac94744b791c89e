"""Which change of an experiment best separates the hypotheses that are still alive."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations
from typing import Any, Protocol, TypeVar

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import Fitted

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


def rank_changes(
    alive: Sequence[tuple[Fitted, float]],
    menu: Sequence[C],
    nothing: C,
    predict: Callable[[Fitted, C], Any],
    distance: Callable[[Any, Any, Fitted], float],
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

    Notes
    -----
    After G. E. P. Box & W. J. Hill, Technometrics 9 (1967) 57-71: the expected gain is the distance of two hypotheses'
    predictions, weighted by the product of their probabilities.
    """
    if len(alive) < 2:
        return []
    found = []
    as_before = [predict(fitted, nothing)[0] for fitted, _ in alive]
    for change in menu:
        predictions = [predict(fitted, change) for fitted, _ in alive]
        if all(np.allclose(new[0], old, rtol=1e-9) for new, old in zip(predictions, as_before, strict=True)):
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


def half_squared(delta: RealArray, spread: RealArray) -> float:
    """Return ``delta^T (1 + S S^T)^-1 delta / 2`` for whitened differences (n,) and what is open of them, S (n, d)."""
    along = spread.T @ delta
    inner = np.linalg.solve(np.eye(spread.shape[1]) + spread.T @ spread, along)
    return float(0.5 * (delta @ delta - along @ inner))
