"""The next measurement in a tube: which change best separates the hypotheses that are still alive."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.tube import Tube, sample_index, thickness_of, with_layer, with_layers
from multilayer.diagnosis.experiment_design import Alive, half_squared, rank_changes, unchanged
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.inference.derivative import WIDE, central
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack

_CAVITY = 0.05  # m


@dataclass(frozen=True)
class Change:
    """A change of the measurement, and what it costs in hours of a laboratory's time.

    Attributes
    ----------
    change : str
    cost : float
    stack : callable
        The new nominal stack from the old one.
    tube : callable
        The new tube.
    without : tuple of str
        Effects that the change takes away.
    """

    change: str
    cost: float
    stack: Callable[[Stack], Stack] = unchanged
    tube: Callable[[Tube], Tube] = unchanged
    without: tuple[str, ...] = ()


def _thicker(stack: Stack) -> Stack:
    index = sample_index(stack)
    if index is None:
        return stack
    layer = stack.layers[index]
    return with_layer(stack, index, layer.model_copy(update={"thickness": 2 * thickness_of(layer)}))


def _stood_off(stack: Stack) -> Stack:
    return with_layers(stack, (*stack.layers, Fluid(thickness=_CAVITY)))


def _narrower(tube: Tube) -> Tube:
    return tube.model_copy(update={"diameter": 0.3 * tube.diameter})


MENU = (
    Change("two samples, one behind the other", 0.5, stack=_thicker),
    Change("a cavity of 50 mm behind the sample", 0.5, stack=_stood_off),
    Change("sample pressed to the wall", 0.3, without=("rear_air_gap",)),
    Change("edge of the sample sealed", 0.5, without=("lateral_air_gap",)),
    Change("tube diameter x 0.3", 3.0, tube=_narrower),
    Change("facing taken off, or the sample turned round", 0.3, without=("facing",)),
    Change("microphones exchanged", 0.3, without=("microphone_gain", "microphone_phase")),
    Change("empty tube, its wall at the sample's place", 0.3, without=("sample_position",)),
    Change("thermometer in the tube", 0.1, without=("temperature",)),
    Change("frame held by needles or a grid", 1.0, without=("frame_motion", "edge_constraint")),
)


def next_measurements(alive: Alive, executor: Executor | None = None) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``: changes of the first measurement, see `rank_changes`."""
    return rank_changes(alive, MENU, Change("none", 0.0), _predict, _distance, executor)


def _predict(fitted: Fitted, change: Change) -> tuple[ComplexArray, ComplexArray]:
    """Return R of the first measurement after a change, shape (n,), and what its unknowns leave open, shape (n, d)."""
    hypothesis = fitted.hypothesis
    assert isinstance(hypothesis, StackProblem)
    kept = tuple(effect for effect in hypothesis.effects if effect.name not in change.without)
    names = {p.name for p in hypothesis.with_effects(*kept).parameters}
    own = [i for i, p in enumerate(hypothesis.parameters) if p.name in names]
    z, covariance = fitted.minimum.z[own], fitted.minimum.covariance[np.ix_(own, own)]
    stacks = {name: change.stack(stack) for name, stack in hypothesis.stacks.items()}
    changed = replace(hypothesis, stacks=stacks, tube=change.tube(hypothesis.tube), effects=kept)
    r, slopes = central(lambda points: changed.with_data(changed.data[:1]).predict(points)[0], z, WIDE)
    return np.asarray(r, dtype=complex), np.asarray(slopes @ np.linalg.cholesky(covariance), dtype=complex)


def _distance(a: tuple[ComplexArray, ComplexArray], b: tuple[ComplexArray, ComplexArray], fitted: Fitted) -> float:
    """Return half the squared distance of two predictions in units of noise and of what is open, nats."""
    whiten = fitted.hypothesis.experiments[0].whiten
    return half_squared(whiten(a[0] - b[0]), whiten(np.concatenate([a[1], b[1]], axis=1).T).T)
