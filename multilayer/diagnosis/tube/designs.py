"""Designs of the next measurement in a tube, and their ranking."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilayer.diagnosis.effects.tube import Tube, sample_index, thickness_of, with_layer, with_layers
from multilayer.diagnosis.experiment_design import (
    Design,
    Prediction,
    Rivals,
    posterior_without,
    rank_designs,
    unchanged,
)
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.inference.derivative import WIDE, central
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack

_CAVITY = 0.05  # m


@dataclass(frozen=True)
class TubeDesign(Design):
    """A planned change of the measurement.

    Attributes
    ----------
    stack : callable
        The new nominal stack from the old one.
    tube : callable
        The new tube from the old one.
    """

    stack: Callable[[Stack], Stack] = unchanged
    tube: Callable[[Tube], Tube] = unchanged


def _thicker(stack: Stack) -> Stack:
    index = sample_index(stack)
    if index is None:
        return stack
    layer = stack.layers[index]
    return with_layer(stack, index, layer.model_copy(update={"thickness": 2 * thickness_of(layer)}))


def _before_cavity(stack: Stack) -> Stack:
    return with_layers(stack, (*stack.layers, Fluid(thickness=_CAVITY)))


def _narrower(tube: Tube) -> Tube:
    return tube.model_copy(update={"diameter": 0.3 * tube.diameter})


TUBE_DESIGNS = (
    TubeDesign("two samples, one behind the other", 0.5, stack=_thicker),
    TubeDesign("a cavity of 50 mm behind the sample", 0.5, stack=_before_cavity),
    TubeDesign("sample pressed to the wall", 0.3, without=("rear_air_gap",)),
    TubeDesign("edge of the sample sealed", 0.5, without=("lateral_air_gap",)),
    TubeDesign("tube diameter x 0.3", 3.0, tube=_narrower),
    TubeDesign("facing taken off, or the sample turned round", 0.3, without=("facing",)),
    TubeDesign("microphones exchanged", 0.3, without=("microphone_gain", "microphone_phase")),
    TubeDesign("empty tube, its wall at the sample's place", 0.3, without=("sample_position",)),
    TubeDesign("thermometer in the tube", 0.1, without=("temperature",)),
    TubeDesign("frame held by needles or a grid", 1.0, without=("frame_motion", "edge_constraint")),
)


def rank_tube_designs(rivals: Rivals, executor: Executor | None = None) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``: changes of the first measurement, see `rank_designs`."""
    return rank_designs(rivals, TUBE_DESIGNS, TubeDesign("none", 0.0), _predict, executor)


def _predict(fitted: Fitted, design: TubeDesign) -> Prediction:
    """Return R of the first measurement with a design."""
    hypothesis = fitted.hypothesis_as(StackProblem)
    effects, z, root = posterior_without(fitted, design.removes)
    stacks = {name: design.stack(stack) for name, stack in hypothesis.stacks.items()}
    changed = replace(hypothesis, stacks=stacks, tube=design.tube(hypothesis.tube), effects=tuple(effects))
    r, slopes = central(lambda points: changed.with_data(changed.data[:1]).predict(points)[0], z, WIDE)
    return Prediction(np.asarray(r, dtype=complex), np.asarray(slopes @ root, dtype=complex))
