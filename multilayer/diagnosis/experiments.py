"""The next experiment: which change of the rig best separates the hypotheses that are still alive."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, half_turn
from multilayer.diagnosis.effects.base import CENTRED_SENSOR, VACUUM, Setting
from multilayer.diagnosis.experiment_design import Alive, half_squared, rank_changes, unchanged
from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.rig_hypothesis import rig_hypothesis
from multilayer.inference.derivative import WIDE, Stencil

_QUIET = 0.3  # of the level


@dataclass(frozen=True)
class Experiment:
    """A change of the rig, and what it costs in hours of a laboratory's time.

    Attributes
    ----------
    change : str
        Effects that it takes away name it as `absent_in`.
    cost : float
    setting : callable
        The new setting from that of an existing configuration.
    swapped : bool
        Whether the channels are exchanged.
    """

    change: str
    cost: float
    setting: Callable[[Setting], Setting] = unchanged
    swapped: bool = False


def _resized(setting: Setting, **factors: float) -> Setting:
    """Return a setting with dimensions multiplied."""
    old = setting.configuration
    sizes = {name: getattr(old, name) * factor for name, factor in factors.items()}
    data = replace(setting.data, thickness=sizes.get("specimen_thickness", setting.data.thickness))
    return replace(setting, configuration=old.model_copy(update=sizes), data=data)


def _level(setting: Setting) -> Setting:
    burst = setting.campaign.burst
    quiet = burst.model_copy(update={"level_rms": _QUIET * burst.level_rms})
    data = setting.data
    if data.stretch_moments is not None:
        data = replace(data, stretch_moments=data.stretch_moments * np.array([[_QUIET], [_QUIET**2]]))
    return replace(setting, campaign=setting.campaign.model_copy(update={"burst": quiet}), data=data)


def _reversed(setting: Setting) -> Setting:
    return replace(setting, order=1 - setting.order)


MENU = (
    Experiment("specimen_thickness x 2", 2.0, partial(_resized, specimen_thickness=2.0)),
    Experiment("specimen_thickness x 0.5", 2.0, partial(_resized, specimen_thickness=0.5)),
    Experiment("top_plate_thickness x 3", 1.0, partial(_resized, top_plate_thickness=3.0)),
    Experiment("specimen_radius x 0.5", 2.0, partial(_resized, specimen_radius=0.5)),
    Experiment(f"level x {_QUIET:g}", 0.5, _level),
    Experiment("channels swapped", 0.5, swapped=True),
    Experiment(CENTRED_SENSOR, 0.5),
    Experiment(VACUUM, 8.0),
    Experiment("remounted, measured in reversed order", 1.5, _reversed),
)


def next_experiments(alive: Alive, executor: Executor | None = None) -> list[dict[str, Any]]:
    """Return the entries of ``next_experiment``: changes of the first configuration, see `rank_changes`."""
    return rank_changes(alive, MENU, Experiment("none", 0.0), _predict, _distance, executor)


def _predict(fitted: Fitted, experiment: Experiment) -> tuple[ComplexArray, ComplexArray]:
    """Return ln(ratio), shape (n,), and its derivatives by the coordinates, shape (n, d)."""
    hypothesis = rig_hypothesis(fitted.hypothesis)
    kept = tuple(effect for effect in hypothesis.effects if effect.absent_in != experiment.change)
    names = {p.name for p in replace(hypothesis, effects=kept).parameters}
    own = [i for i, p in enumerate(hypothesis.parameters) if p.name in names]
    z, covariance = fitted.minimum.z[own], fitted.minimum.covariance[np.ix_(own, own)]
    stencil = Stencil.central(z, WIDE)
    moved, shown = hypothesis.with_effects(*kept).predict(experiment.setting(hypothesis.settings[0]), stencil.points)
    # what made the top channel wrong makes the base channel wrong once they are exchanged
    logs: ComplexArray = np.log(moved**2 / shown) if experiment.swapped else np.log(shown)
    value, slopes = stencil.linearised(logs)
    return value, np.asarray(slopes @ np.linalg.cholesky(covariance))


def _distance(a: tuple[ComplexArray, ComplexArray], b: tuple[ComplexArray, ComplexArray], fitted: Fitted) -> float:
    """Return half the squared distance of two predictions, nats."""
    difference = a[0] - b[0]
    difference = difference.real + 1j * half_turn(difference.imag)
    whiten = fitted.hypothesis.experiments[0].whiten
    return half_squared(whiten(difference), whiten(np.concatenate([a[1], b[1]], axis=1).T).T)
