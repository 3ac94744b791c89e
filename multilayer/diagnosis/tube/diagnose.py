"""The diagnosis of tube measurements, from a file to a verdict."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from functools import partial
from importlib.metadata import version
from typing import Any

import numpy as np

from multilayer.diagnosis import assessment as steps
from multilayer.diagnosis.assessment import Progress, assess
from multilayer.diagnosis.effects.base import BaseEffect
from multilayer.diagnosis.file import DiagnosisFile
from multilayer.diagnosis.fitting import Fitted, fit_effects, polish_fits, with_response
from multilayer.diagnosis.nominal import fitted_nominal, unknown_entries
from multilayer.diagnosis.place_fits import fit_places
from multilayer.diagnosis.residual_curves import residual_curves
from multilayer.diagnosis.result import Diagnosis
from multilayer.diagnosis.tube.designs import rank_tube_designs
from multilayer.experiments.stacks.observations import Observation
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.log import logged
from multilayer.simulation.warned import collected_warnings

N_STEPS = steps.N_STEPS + 1  # the places besides
_FAR = 0.7  # standard deviations of a prior


def diagnose_tube(
    file: DiagnosisFile,
    name: str = "tube",
    effects: Mapping[str, BaseEffect] | None = None,
    *,
    seed: int = 0,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Diagnosis:
    """Diagnose where stacks and tube measurements disagree, which effect causes it, and how far the gap shrinks.

    Parameters
    ----------
    file : DiagnosisFile
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
    tell("nominal model")
    every = file.chosen() if effects is None else effects
    usable = {key: effect for key, effect in every.items() if nominal.hypothesis.admits(effect)}
    singles, usable = with_response(single_fits(nominal, usable, executor), usable)
    tell("effects one by one")
    places = fit_places(nominal, executor)
    tell("places with free laws")
    assessment = assess(nominal, singles, usable, tell, executor, places)
    record = assessment.entries(partial(rank_tube_designs, executor=executor), seed) | {
        "unknowns": unknown_entries(nominal, assessment.corrected),
        "warnings": _warnings(nominal),
        "inputs": _inputs(file, name, nominal) | assessment.misfit_entries(),
    }
    return Diagnosis(name, record, residual_curves(nominal, assessment.best_fit), assessment.similarity, {})


def single_fits(
    nominal: Fitted, effects: Mapping[str, BaseEffect], executor: Executor | None
) -> dict[tuple[str, ...], Fitted]:
    """Return the fit of every effect by itself.

    From the nominal fit, and again from the nominal values where the gap has moved the unknowns far from these, since a
    descent may not lead back.
    """
    hypothesis = nominal.hypothesis_as(StackProblem)
    fits = fit_effects(nominal, effects, executor=executor)
    if np.max(np.abs(nominal.minimum.z - hypothesis.start)) < _FAR:
        return polish_fits(fits, executor)
    others = fit_effects(Fitted(hypothesis, hypothesis.as_minimum(hypothesis.start)), effects, executor=executor)
    best = {names: min(fit, others[names], key=lambda fitted: fitted.minimum.cost) for names, fit in fits.items()}
    return polish_fits(best, executor)


def _warnings(nominal: Fitted) -> list[str]:
    """Return warnings where formulae do not hold, and where noise had to be estimated."""
    hypothesis = nominal.hypothesis_as(StackProblem)
    with collected_warnings() as texts:
        for setting, data in zip(hypothesis.settings, hypothesis.data, strict=True):
            setting.reflection(hypothesis.stacks[data.stack])
    estimated = [
        f"{data.name}: no noise is said; estimated from neighbouring frequencies as {data.estimated:.2g} of each part "
        "of R, which does not see what changes from one mounting to the next"
        for data in hypothesis.data
        if data.estimated is not None
    ]
    return [*dict.fromkeys(" ".join(text.split()) for text in texts), *estimated]


def _inputs(file: DiagnosisFile, name: str, nominal: Fitted) -> dict[str, Any]:
    hypothesis = nominal.hypothesis_as(StackProblem)
    return {
        "file": name,
        "multilayer": version("multilayer"),
        "stacks": ", ".join(hypothesis.stacks),
        "noise": {
            data.name: "as stated" if data.estimated is None else f"estimated, {data.estimated:.2g} of each part of R"
            for data in hypothesis.data
        },
        "model_error": {
            data.name: model_error_text(data, is_stated=measured.model_error is not None)
            for data, measured in zip(hypothesis.data, file.measurements, strict=True)
        },
        "probabilities": "calibrated on campaigns of the two-plate rig, not on tubes",
    }


def model_error_text(data: Observation, *, is_stated: bool) -> str:
    """Return the size of the model's error, in words."""
    size = 0.0 if data.error is None else data.error.relative
    return f"{size:.2g}, as stated" if is_stated else f"{size:.2g} of R (none is said)"
