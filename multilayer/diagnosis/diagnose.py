"""The diagnosis of a campaign, from recordings to verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from typing import Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis.effects.base import EFFECTS, BaseEffect, Effect
from multilayer.diagnosis.experiments import alive_hypotheses, next_experiments
from multilayer.diagnosis.fitting import Fitted, fit, fit_effects
from multilayer.diagnosis.held_out import Shrinkage, shrinkage
from multilayer.diagnosis.hypothesis import Hypothesis, rig_hypothesis
from multilayer.diagnosis.locate import locate, shown
from multilayer.diagnosis.ranking import (
    Decision,
    Hypotheses,
    compare,
    decide,
    global_p_value,
    is_gap,
)
from multilayer.diagnosis.record import cause_entries, confounded_entries, gap_entry, sentence, worth_checking
from multilayer.diagnosis.result import Curves, Diagnosis, Similarity
from multilayer.diagnosis.signatures import detectable, inner_products, signature
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

Progress = Callable[[str], None]
_REFERENCE = 1000.0  # Hz, where moduli are told


def chosen_effects(wanted: Sequence[str] | None = None, without: Sequence[str] = ()) -> dict[str, BaseEffect]:
    """Return effects by name: all registered ones, or those wanted, without some.

    Raises
    ------
    InputError
        For names that are not registered.
    """
    names = list(EFFECTS.names() if wanted is None else wanted)
    for name in (*names, *without):
        if name not in EFFECTS:
            raise InputError(f"there is no effect '{name}'; {suggest(name, EFFECTS.names())}")
    return {name: EFFECTS[name]() for name in names if name not in without}


def diagnose_campaign(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    effects: Mapping[str, BaseEffect] | None = None,
    *,
    law: str = "fractional_zener",
    calibration: Calibration | None = None,
    seed: int = 0,
    progress: Progress | None = None,
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
    singles = fit_effects(nominal, usable, starts)
    tell("effects one by one")
    found = compare(nominal, singles, usable)
    tell("effects in pairs")
    gap = is_gap(found)
    tried = worth_checking(found) if gap else []
    held = dict(zip(tried, shrinkage(nominal, [found.fitted[names] for names in tried]), strict=True)) if tried else {}
    tell("held-out data")
    decision = decide(found, held)
    columns = np.stack([signature(nominal, effect) for effect in usable.values()], axis=1)
    cosines, kept = inner_products(nominal.minimum, columns)
    similarity = Similarity(tuple(usable), cosines, kept)
    record = _record(campaign, found, decision, held, similarity, detectable(nominal, usable, columns), seed)
    tell("verdict")
    best = found.fitted.get(decision.best, nominal)
    return Diagnosis(
        campaign=campaign.folder.resolve().name,
        record=record,
        curves=_curves(nominal, best),
        similarity=similarity,
        moduli=_moduli(nominal, best),
    )


N_STEPS = 5


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


def _record(
    campaign: Campaign,
    found: Hypotheses,
    decision: Decision,
    held: Mapping[tuple[str, ...], Shrinkage],
    similarity: Similarity,
    sizes: dict[str, dict[str, object]],
    seed: int,
) -> dict[str, Any]:
    """Return ``diagnosis.json``."""
    places, limit = locate(found.nominal.hypothesis, found.nominal.minimum, seed)
    probabilities = found.probabilities()
    causes = [] if decision.verdict == "no_gap" else cause_entries(found, held, similarity, probabilities)
    probability = found.probability_of(decision)
    alive = alive_hypotheses(
        [(found.fitted[names], probabilities[names]) for names in found.ranked if names in found.fitted], decision.group
    )
    gap = held.get(decision.best) or next(iter(held.values()), None)
    return {
        "version": 1,
        "verdict": decision.verdict,
        "sentence": sentence(found, decision, probability),
        "probability": round(probability, 4),
        "where": [] if decision.verdict == "no_gap" else shown(places, limit),
        "causes": causes,
        "group": [list(names) for names in decision.group if decision.verdict == "effect"],
        "gap": gap_entry(found.nominal, gap),
        "unknowns": _unknowns(found, decision),
        "detectable": sizes,
        "confounded": confounded_entries(similarity),
        "next_experiment": next_experiments(alive),
        "hypotheses_tried": len(found.evidence),
        "inputs": {
            "campaign": campaign.folder.resolve().name,
            "multilayer": version("multilayer"),
            "law": rig_hypothesis(found.nominal.hypothesis).joint.space.template.law,
            "p_value": global_p_value(found.nominal),
            "chi_square": found.nominal.minimum.cost,
            "n_data": len(found.nominal.minimum.residual),
        },
    }


def _modulus(fitted: Fitted, frequency: RealArray) -> Any:
    joint = rig_hypothesis(fitted.hypothesis).joint
    return joint.space.modulus(joint.law_coordinates(fitted.minimum.z), frequency)


def _unknowns(found: Hypotheses, decision: Decision) -> dict[str, Any]:
    f = np.concatenate([data.frequency for data in found.nominal.hypothesis.data])
    at = float(np.clip(_REFERENCE, f.min(), f.max()))
    best = found.fitted.get(decision.best, found.nominal) if decision.verdict == "effect" else found.nominal
    before, after = (_modulus(one, np.array([at]))[0] for one in (found.nominal, best))
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


_DB = 20 / np.log(10)
