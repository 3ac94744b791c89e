"""The diagnosis of measured transmission loss and absorption, from a file to a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial
from importlib.metadata import version
from typing import Any

from multilayer.diagnosis import assessment as steps
from multilayer.diagnosis.assessment import Progress, assess
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.file import DiagnosisFile
from multilayer.diagnosis.fitting import fit_effects, polish_fits, rough_fit, with_response
from multilayer.diagnosis.levels.data import spread_in_words
from multilayer.diagnosis.levels.designs import rank_level_designs
from multilayer.diagnosis.nominal import fitted_nominal, unknown_entries
from multilayer.diagnosis.place_fits import fit_places, may_explain
from multilayer.diagnosis.residual_curves import residual_curves
from multilayer.diagnosis.result import Diagnosis
from multilayer.experiments.levels.problem import LevelProblem
from multilayer.log import logged

N_STEPS = steps.N_STEPS + 1  # the places besides


def diagnose_levels(
    file: DiagnosisFile,
    name: str = "levels",
    effects: Mapping[str, BaseEffect] | None = None,
    *,
    seed: int = 0,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Diagnosis:
    """Diagnose where constructions and their measured levels disagree, which effect causes it, how far it shrinks.

    Parameters
    ----------
    file : DiagnosisFile
        Of transmission losses, or of absorption coefficients.
    name : str
        Of the result.
    effects : mapping, optional
        By name; those that the file names when left out.
    seed : int
        Of the Monte Carlo test of the gap's places.
    progress : callable, optional
        Called with a short text after each of `N_STEPS` steps.
    executor : Executor, optional
        Where fits run; in this process when left out.

    Raises
    ------
    InputError
        When the stacks have no response for most values that the priors allow.
    """
    tell = logged(progress)
    nominal = fitted_nominal(file)
    hypothesis = nominal.hypothesis_as(LevelProblem)
    tell("nominal model")
    every = file.chosen() if effects is None else effects
    usable = {key: effect for key, effect in every.items() if hypothesis.admits(effect)}
    places = fit_places(nominal, executor)
    tell("places with free laws")
    wanted = {key: effect for key, effect in usable.items() if may_explain(nominal, places, effect)}
    fits = polish_fits(fit_effects(nominal, wanted, executor=executor), executor)
    fits |= {(key,): rough_fit(nominal, effect) for key, effect in usable.items() if key not in wanted}
    singles, usable = with_response({(key,): fits[key,] for key in usable}, usable)
    tell("effects one by one")
    assessment = assess(nominal, singles, usable, tell, executor, places)
    record = assessment.entries(partial(rank_level_designs, executor=executor), seed) | {
        "unknowns": unknown_entries(nominal, assessment.corrected),
        "warnings": hypothesis.warnings(nominal.minimum.z),
        "inputs": _inputs(file, name, hypothesis) | assessment.misfit_entries(),
    }
    return Diagnosis(name, record, residual_curves(nominal, assessment.best_fit), assessment.similarity, {})


def _inputs(file: DiagnosisFile, name: str, hypothesis: LevelProblem) -> dict[str, Any]:
    pairs = list(zip(hypothesis.observations, file.measurements, strict=True))
    usual = {data.name: spread_in_words(measured, file.uncertainty, file.tube) for data, measured in pairs}
    return {
        "file": name,
        "kind": "levels",
        "multilayer": version("multilayer"),
        "stacks": ", ".join(hypothesis.stacks),
        "noise": {data.name: "as stated" if data.estimated is None else usual[data.name][0] for data, _ in pairs},
        "model_error": {
            data.name: usual[data.name][1] if measured.model_error is None else "as stated" for data, measured in pairs
        },
        "probabilities": "calibrated on campaigns of the two-plate rig, not on levels",
    }
