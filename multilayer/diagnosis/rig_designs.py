"""Designs of the next experiment with a two-plate rig, and their ranking."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.diagnosis.effects.base import CENTRED_SENSOR, VACUUM, Setting
from multilayer.diagnosis.experiment_design import (
    Design,
    Prediction,
    Rivals,
    posterior_without,
    rank_designs,
    unchanged,
)
from multilayer.diagnosis.fitting import Fitted
from multilayer.experiments.two_plate.burst import STRETCH_POWERS
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.inference.derivative import WIDE, Stencil

_QUIET = 0.3  # of the level


@dataclass(frozen=True)
class RigDesign(Design):
    """A planned change of the rig.

    Attributes
    ----------
    setting : callable
        The new setting from that of an existing configuration.
    swapped : bool
        Whether the channels are exchanged.
    """

    setting: Callable[[Setting], Setting] = unchanged
    swapped: bool = False


def _resized(setting: Setting, **factors: float) -> Setting:
    """Return a setting with dimensions multiplied."""
    old = setting.configuration
    sizes = {name: getattr(old, name) * factor for name, factor in factors.items()}
    data = replace(setting.data, thickness=sizes.get("specimen_thickness", setting.data.thickness))
    return replace(setting, configuration=old.model_copy(update=sizes), data=data)


def _quieter(setting: Setting) -> Setting:
    burst = setting.campaign.burst
    quiet = burst.model_copy(update={"level_rms": _QUIET * burst.level_rms})
    data = setting.data
    if data.stretch_moments is not None:
        data = replace(data, stretch_moments=data.stretch_moments * _QUIET ** np.array(STRETCH_POWERS)[:, np.newaxis])
    if data.friction is not None:
        data = replace(data, friction=data.friction / _QUIET)
    return replace(setting, campaign=setting.campaign.model_copy(update={"burst": quiet}), data=data)


def _reversed(setting: Setting) -> Setting:
    return replace(setting, order=1 - setting.order)


RIG_DESIGNS = (
    RigDesign("specimen_thickness x 2", 2.0, partial(_resized, specimen_thickness=2.0)),
    RigDesign("specimen_thickness x 0.5", 2.0, partial(_resized, specimen_thickness=0.5)),
    RigDesign("top_plate_thickness x 3", 1.0, partial(_resized, top_plate_thickness=3.0)),
    RigDesign("specimen_radius x 0.5", 2.0, partial(_resized, specimen_radius=0.5)),
    RigDesign(f"level x {_QUIET:g}", 0.5, _quieter),
    RigDesign("channels swapped", 0.5, swapped=True),
    RigDesign(CENTRED_SENSOR, 0.5),
    RigDesign(VACUUM, 8.0),
    RigDesign("remounted, measured in reversed order", 1.5, _reversed),
)


def rank_rig_designs(rivals: Rivals, executor: Executor | None = None) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``: changes of the first configuration, see `rank_designs`."""
    return rank_designs(rivals, RIG_DESIGNS, RigDesign("none", 0.0), _predict, executor, has_phase=True)


def _predict(fitted: Fitted, design: RigDesign) -> Prediction:
    """Return ln(ratio) of the first configuration with a design."""
    hypothesis = fitted.hypothesis_as(CampaignProblem)
    effects, z, root = posterior_without(fitted, design.removes)
    stencil = Stencil.central(z, WIDE)
    moved, shown = hypothesis.with_effects(*effects).predict(design.setting(hypothesis.settings[0]), stencil.points)
    # an error of the top channel becomes one of the base channel when the channels are exchanged
    logs: ComplexArray = np.log(moved**2 / shown) if design.swapped else np.log(shown)
    values, slopes = stencil.linearised(logs)
    return Prediction(values, np.asarray(slopes @ root))
