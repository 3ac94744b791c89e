"""Fits of hypotheses, and the evidence of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import ndtri

from multilayer.arrays import RealArray
from multilayer.diagnosis.discrepancy import tolerant_covariance
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.interface import AnyHypothesis
from multilayer.inverse.least_squares import minimise
from multilayer.inverse.problem import Minimum

_TOLERANCE = 1e-5  # of the cost, relative: some hundredths of a nat
_STARTS = (0.0, -3.0, -1.5, 1.5, 3.0)  # of the effects' coordinates: their prior's centre and to either side


@dataclass(frozen=True)
class Fitted:
    """A hypothesis at its most probable parameters.

    Attributes
    ----------
    hypothesis : AnyHypothesis
    minimum : Minimum
    """

    hypothesis: AnyHypothesis
    minimum: Minimum

    @property
    def names(self) -> tuple[str, ...]:
        """Names of its effects."""
        return self.hypothesis.names

    @property
    def log_evidence(self) -> float:
        """Laplace's, but for the constant of the whitened data."""
        return self.minimum.log_evidence

    @cached_property
    def covariance(self) -> RealArray:
        """Of the coordinates, the errors of the effects' laws included."""
        return tolerant_covariance(self.hypothesis, self.minimum)

    def interval(self, name: str, probability: float = 0.9) -> tuple[float, float, float]:
        """Return value and ends of the central interval of a parameter, in its own unit, by Laplace's approximation."""
        index = [p.name for p in self.hypothesis.parameters].index(name)
        prior = self.hypothesis.parameters[index].prior
        spread = float(np.sqrt(self.covariance[index, index])) * float(ndtri(0.5 + probability / 2))
        z = float(self.minimum.z[index])
        value, low, high = (float(prior.value(np.asarray(x))) for x in (z, z - spread, z + spread))
        return value, low, high


def fit(
    hypothesis: AnyHypothesis, start: RealArray, starts: Sequence[float] = _STARTS, *, followed: int | None = None
) -> Fitted:
    """Return the most probable parameters of a hypothesis.

    Parameters
    ----------
    hypothesis : AnyHypothesis
    start : array
        Coordinates of law and nuisances, and of effects that are given already.
    starts : sequence of float
        Coordinates tried for the effects that `start` does not hold.
    followed : int, optional
        How many of the starts with the least cost are followed; by default one for a single number to be found, two
        for several: resonances have more than one valley.
    """
    missing = len(hypothesis.parameters) - len(start)
    points = np.stack([np.concatenate([start, at]) for at in _starting_points(hypothesis, missing, starts)])
    costs = np.sum(hypothesis.residual(points) ** 2, axis=-1) + np.sum(points**2, axis=-1)
    best = points[np.argsort(costs)[: followed or (1 if missing < 2 else 2)]]
    found = [minimise(hypothesis, z, tolerance=_TOLERANCE) for z in best]
    return Fitted(hypothesis, min(found, key=lambda minimum: minimum.cost))


def _starting_points(hypothesis: AnyHypothesis, missing: int, starts: Sequence[float]) -> list[RealArray]:
    """Return the coordinates to start from of what is missing: the last effect's own where it says some."""
    if not missing:
        return [np.empty(0)]
    own = hypothesis.effects[-1].starts if hypothesis.effects else ()
    if own and len(own[0]) == missing:
        return [np.array(point) for point in own]
    return [np.full(missing, at) for at in starts]


def fit_effects(nominal: Fitted, effects: Mapping[str, BaseEffect]) -> dict[tuple[str, ...], Fitted]:
    """Return the fit of every effect by itself."""
    z = nominal.minimum.z
    return {
        (name,): fit(nominal.hypothesis.with_effects(effect), z)
        for name, effect in effects.items()
        if nominal.hypothesis.admits(effect)
    }
