"""The diagnosis of a campaign, from recordings to verdict."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import EFFECTS, BaseEffect, Effect
from multilayer.diagnosis.experiments import next_experiments
from multilayer.diagnosis.fitting import Fitted, fit, fit_effects
from multilayer.diagnosis.hypothesis import Hypothesis, rig_hypothesis
from multilayer.diagnosis.judgement import Progress, judge
from multilayer.diagnosis.result import Curves, Diagnosis
from multilayer.diagnosis.thresholds import MODEL_ERROR
from multilayer.errors import InputError, MultilayerError, suggest
from multilayer.inverse.fit import burst_problems
from multilayer.inverse.joint import JointProblem, solve_joint
from multilayer.inverse.joint_fit import plane_wave_problem, rigs_around, with_free_rim
from multilayer.inverse.problem import Minimum
from multilayer.inverse.rig import Rig
from multilayer.inverse.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.measurements.recording import Recording
from multilayer.signals.calibration import Calibration

_REFERENCE = 1000.0  # Hz, where moduli are told
_DB = 20 / np.log(10)


def chosen_effects(wanted: Sequence[str] | None = None, without: Sequence[str] = ()) -> dict[str, BaseEffect]:
    """Return effects by name: all registered ones, or those wanted, without some.

    Raises
    ------
    InputError
        For names that are not registered.
    RegistryError
        For a plugin that is wanted and broken; of all, it is left out with a `PluginWarning`.
    """
    for name in (*(wanted or ()), *without):
        if name not in EFFECTS:
            raise InputError(f"there is no effect '{name}'; {suggest(name, EFFECTS.names())}")
    found = dict(EFFECTS.working()) if wanted is None else {name: EFFECTS[name] for name in wanted}
    return {name: kind() for name, kind in found.items() if name not in without}


def diagnose_campaign(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    effects: Mapping[str, BaseEffect] | None = None,
    *,
    law: str = "fractional_zener",
    calibration: Calibration | None = None,
    seed: int = 0,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Diagnosis:
    """Say where model and measurement disagree, which effect causes it, and how far the gap shrinks with it.

    Parameters
    ----------
    campaign : Campaign
    recordings : mapping
        Signals by (configuration name, frequency).
    effects : mapping, optional
        By name; all registered ones when left out.
    law : str
        Of the nominal model: one causal modulus law for all bursts.
    calibration : Calibration, optional
    seed : int
    progress : callable, optional
        Called with a short text after each of `N_STEPS` steps.
    executor : Executor, optional
        Where fits run, as `executors.local_pool` gives it; in this process when left out.

    Raises
    ------
    InputError
        For a campaign that cannot be fitted.
    """
    tell = progress or (lambda text: None)
    every = dict(effects) if effects is not None else chosen_effects()
    nominal, starts = _nominal(campaign, recordings, law, calibration, every, seed)
    tell("nominal model")
    usable = {name: effect for name, effect in every.items() if nominal.hypothesis.admits(effect)}
    singles = fit_effects(nominal, usable, starts, executor)
    tell("effects one by one")
    judgement = judge(nominal, singles, usable, tell, executor)
    name = campaign.folder.resolve().name
    record = judgement.record(next_experiments, seed) | {
        "unknowns": _unknowns(nominal, judgement.corrected),
        "inputs": {"campaign": name, "multilayer": version("multilayer"), "law": law, **judgement.fit_numbers()},
    }
    best = judgement.shown
    return Diagnosis(name, record, _curves(nominal, best), judgement.similarity, _moduli(nominal, best))


def _nominal(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    law: str,
    calibration: Calibration | None,
    effects: Mapping[str, BaseEffect],
    seed: int,
) -> tuple[Fitted, dict[str, RealArray]]:
    """Return the nominal model's fit, and by effect where to start where that is of no use."""
    problems = burst_problems(campaign, recordings, FitSettings(), calibration)
    joint = replace(plane_wave_problem(campaign, problems, law, None), model_error=MODEL_ERROR)
    minima = solve_joint(joint, seed=seed)
    found = fit(Hypothesis(campaign, joint), minima[0].z)
    acting = [effect for effect in effects.values() if isinstance(effect, Effect) and effect.applies(campaign)]
    finite = [effect.name for effect in acting if effect.needs_finite_elements]
    if not finite:
        return found, {}
    rigs, start = _with_rim(campaign, joint, minima)
    return Fitted(replace(rig_hypothesis(found.hypothesis), finite=rigs), found.minimum), dict.fromkeys(finite, start)


def _with_rim(campaign: Campaign, joint: JointProblem, minima: list[Minimum]) -> tuple[Mapping[str, Rig], RealArray]:
    """Return finite elements by configuration, and the unknowns that fit best with them."""
    silent, settings = (lambda text: None), FitSettings()
    try:
        problem, found = with_free_rim(campaign, joint, minima, silent, settings)
    except MultilayerError:  # the free rim is so wrong here that no law is found with it
        return rigs_around(campaign, joint, minima[0], silent, settings), minima[0].z
    return problem.rigs, found[0].z


def _modulus(fitted: Fitted, frequency: RealArray) -> Any:
    joint = rig_hypothesis(fitted.hypothesis).joint
    return joint.space.modulus(joint.law_coordinates(fitted.minimum.z), frequency)


def _unknowns(nominal: Fitted, corrected: Fitted) -> dict[str, Any]:
    f = np.concatenate([data.frequency for data in nominal.hypothesis.data])
    at = float(np.clip(_REFERENCE, f.min(), f.max()))
    before, after = (_modulus(one, np.array([at]))[0] for one in (nominal, corrected))
    pairs = {"nominal": before, "corrected": after}
    values: dict[str, Any] = {name: [float(e.real), float(e.imag)] for name, e in pairs.items()} | {"unit": "Pa"}
    return {f"E({at:.0f} Hz)": values}


def _moduli(nominal: Fitted, best: Fitted) -> dict[str, Any]:
    f = np.concatenate([data.frequency for data in nominal.hypothesis.data])
    at = np.geomspace(f.min(), f.max(), 60)
    found: dict[str, Any] = {"frequency_hz": at.tolist()}
    for name, one in (("nominal", nominal), ("corrected", best)):
        e = _modulus(one, at)
        found[name] = {"E1": e.real.tolist(), "E2": e.imag.tolist()}
    return found


def _curves(nominal: Fitted, best: Fitted) -> tuple[Curves, ...]:
    pairs = zip(
        rig_hypothesis(nominal.hypothesis).data,
        nominal.hypothesis.log_ratios(nominal.minimum.z),
        best.hypothesis.log_ratios(best.minimum.z),
        strict=True,
    )
    found = []
    for data, before, after in pairs:
        spread = np.sqrt(np.diag(data.covariance(MODEL_ERROR)))
        levels = (-_DB * before.real, -_DB * after.real)
        phases = (-np.rad2deg(before.imag), -np.rad2deg(after.imag))
        found.append(
            Curves(
                data.name, data.frequency, data.burst, levels[0], phases[0], levels[1], phases[1],
                _DB * spread, np.rad2deg(spread),
            )
        )  # fmt: skip
    return tuple(found)
