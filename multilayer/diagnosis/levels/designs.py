"""Designs of the next measurement of a construction, and their ranking."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilayer.diagnosis.experiment_design import (
    Design,
    Prediction,
    Rivals,
    posterior_without,
    rank_designs,
    unchanged,
)
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.levels.effects import with_each
from multilayer.experiments.levels.problem import LevelProblem
from multilayer.experiments.levels.response import LevelResponse
from multilayer.experiments.levels.sound_field import plates_of
from multilayer.experiments.stacks.effects import with_layer, with_layers
from multilayer.experiments.stacks.places import with_factors
from multilayer.inference.derivative import WIDE, central
from multilayer.layers.equivalent_fluid import EquivalentFluid
from multilayer.layers.fluid import Fluid
from multilayer.stack import Stack


@dataclass(frozen=True)
class LevelDesign(Design):
    """A planned change of the measurement.

    Attributes
    ----------
    stack : callable
        The new nominal stack from the old one.
    """

    stack: Callable[[Stack], Stack] = unchanged


def _doubled(stack: Stack) -> Stack:
    """Return the stack with plates of twice the mass and bending stiffness, as two boards that lie loose on each other.

    Their coincidence stays.
    """
    for index in plates_of(stack):
        stack = with_factors(stack, stack.layers[index].name or str(index), young_modulus=2.0)
    return with_each(stack, plates_of(stack), "density", np.asarray(2.0))


def _filled(stack: Stack) -> Stack:
    plates = plates_of(stack)
    for index in range(plates[0], plates[-1]) if plates else ():
        layer = stack.layers[index]
        if isinstance(layer, Fluid):
            wool = EquivalentFluid(thickness=0.05, model="miki", flow_resistivity=8e3)
            stack = with_layer(stack, index, wool.model_copy(update={"thickness": layer.thickness}))
    return stack


def _before_cavity(stack: Stack) -> Stack:
    return with_layers(stack, (*stack.layers, Fluid(thickness=0.1))) if stack.termination == "rigid" else stack


LEVEL_DESIGNS = (
    LevelDesign("all joints sealed", 1.0, without=("leak",)),
    LevelDesign("intensity close to the sample instead of pressures in the rooms", 4.0,
                without=("flanking_path", "receiving_absorption")),
    LevelDesign("a second board of the same mass on each leaf", 4.0, stack=_doubled),
    LevelDesign("air cavities filled with mineral wool", 3.0, stack=_filled, without=("cavity_damping",)),
    LevelDesign("leaves on separate frames", 6.0, without=("structural_links",)),
    LevelDesign("boards weighed", 0.5, without=("board_mass",)),
    LevelDesign("decay of vibration of the boards as mounted", 2.0, without=("edge_damping", "plate_losses")),
    LevelDesign("modulus of the boards by a bending resonance", 2.0, without=("board_stiffness",)),
    LevelDesign("rooms exchanged, reverberation time again", 1.5, without=("receiving_absorption",)),
    LevelDesign("flow resistivity measured", 1.0, without=("flow_resistivity",)),
    LevelDesign("sample pressed to the wall", 0.5, without=("rear_air_gap",)),
    LevelDesign("a cavity of 100 mm behind the sample", 1.0, stack=_before_cavity),
    LevelDesign("thickness by a calliper", 0.2, without=("thickness_error",)),
)  # fmt: skip


def rank_level_designs(rivals: Rivals, executor: Executor | None = None) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``: changes of the first measurement, see `rank_designs`."""
    return rank_designs(rivals, LEVEL_DESIGNS, LevelDesign("none", 0.0), _predict, executor)


def _predict(fitted: Fitted, design: LevelDesign) -> Prediction:
    """Return levels of the first measurement with a design."""
    hypothesis = fitted.hypothesis_as(LevelProblem)
    effects, z, root = posterior_without(fitted, design.removes)
    stacks = {name: design.stack(stack) for name, stack in hypothesis.stacks.items()}
    first = hypothesis.data[0]
    assert isinstance(first.response, LevelResponse)
    data = replace(first, response=first.response.forgetful)
    changed = replace(hypothesis, stacks=stacks, effects=tuple(effects), used=(data,))
    values, slopes = central(lambda points: changed.predict(points)[0], z, WIDE)
    return Prediction(np.asarray(values), np.asarray(slopes @ root))
