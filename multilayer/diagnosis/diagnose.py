"""The diagnosis of a campaign, from recordings to a verdict."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any
from warnings import warn

import numpy as np

from multilayer.arrays import RealArray
from multilayer.diagnosis import assessment as steps
from multilayer.diagnosis.assessment import Progress, assess
from multilayer.diagnosis.effects.base import EFFECTS, BaseEffect
from multilayer.diagnosis.effects.delamination import Delamination
from multilayer.diagnosis.effects.finite_size import FiniteSize
from multilayer.diagnosis.effects.saturating_air import SaturatingAir
from multilayer.diagnosis.effects.sensor_mass import SensorMass
from multilayer.diagnosis.entries import gap_entry, stated_entries
from multilayer.diagnosis.exchanged import refuse_exchanged
from multilayer.diagnosis.fitting import (
    NEAR_LEAST,
    Fitted,
    StartedFit,
    begin_tasks,
    best_ends,
    best_of,
    finish_all,
    fit,
    fit_effects,
    polish_fits,
    rough_fit,
    with_response,
    worth_finishing,
)
from multilayer.diagnosis.free_rim import COARSE, elements_of_samples, fit_samples, free_rim, with_rigs
from multilayer.diagnosis.further_laws import explain_data, has_open_rims, with_further_laws
from multilayer.diagnosis.goodness_of_fit import lack_of_fit
from multilayer.diagnosis.moduli import moduli
from multilayer.diagnosis.place_fits import PlaceFit, fit_places, may_explain
from multilayer.diagnosis.residual_curves import residual_curves
from multilayer.diagnosis.result import Diagnosis
from multilayer.diagnosis.rig_designs import rank_rig_designs
from multilayer.diagnosis.starting_laws import other_starts
from multilayer.diagnosis.thresholds import END_ERROR, END_GROWTH, LARGEST_END_ERROR, MODEL_ERROR
from multilayer.diagnosis.two_causes import two_causes, two_causes_entry
from multilayer.diagnosis.wrong_statement import WrongStatement, wrong_statement
from multilayer.errors import InputError, PlausibilityWarning, suggest
from multilayer.executors import call, run_all
from multilayer.experiments.hypothesis import parameters_of
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.campaign import Acting, CampaignProblem
from multilayer.experiments.two_plate.nuisances import with_usual_uncertainty
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.fits.burst.fit import burst_problems
from multilayer.fits.joint.fit import cut_where_records_end, plane_wave_problem
from multilayer.fits.joint.search import refuse_none, solve_from_bursts
from multilayer.fits.settings import DEFAULT_LAW, FitSettings
from multilayer.fits.sources import read_fit
from multilayer.inference.least_squares import distinct, minimise
from multilayer.inference.problem import Minimum
from multilayer.log import logged
from multilayer.measurements.campaign import load_recordings
from multilayer.measurements.description import Campaign
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

_REFERENCE = 1000.0  # Hz, at which moduli are reported
N_STEPS = steps.N_STEPS + 1  # the places besides


def chosen_effects(wanted: Sequence[str] | None = None, without: Sequence[str] = ()) -> dict[str, BaseEffect]:
    """Return effects by name: all registered ones, or those wanted, without some.

    Raises
    ------
    InputError
        For names that are not registered.
    RegistryError
        For a plugin that is wanted and broken; without `wanted`, it is left out with a `PluginWarning`.
    """
    for name in (*(wanted or ()), *without):
        if name not in EFFECTS:
            raise InputError(f"there is no effect '{name}'; {suggest(name, EFFECTS.names())}")
    classes = dict(EFFECTS.working()) if wanted is None else {name: EFFECTS[name] for name in wanted}
    return {name: kind() for name, kind in classes.items() if name not in without}


def diagnose_campaign(
    campaign: Campaign | Path | str,
    recordings: Mapping[tuple[str, float], Recording] | None = None,
    effects: Mapping[str, BaseEffect] | None = None,
    *,
    law: str = DEFAULT_LAW,
    calibration: Calibration | None = None,
    given: Sequence[Acting] = (),
    seed: int = 0,
    progress: Progress | None = None,
    executor: Executor | None = None,
) -> Diagnosis:
    """Diagnose where model and measurement disagree, which effect causes it, and how far the gap shrinks with it.

    Uncertainties that the campaign does not state are taken as usual (`with_usual_uncertainty`), and records that end
    before all is at rest are completed (`with_complete_records`); `warnings` of the record tell both.

    Parameters
    ----------
    campaign : Campaign, path or str
        Or the path of its folder or file, with a fit file's calibration if that names one.
    recordings : mapping, optional
        Signals by (configuration name, frequency); read from the campaign's files when left out.
    effects : mapping, optional
        By name; all registered ones when left out.
    law : str
        The nominal model's causal modulus law, the same for all bursts.
    calibration : Calibration, optional
    given : sequence of Effect
        Effects that are part of the nominal model: what is left beyond them is diagnosed.
    seed : int
    progress : callable, optional
        Called with a short text after each of `N_STEPS` steps.
    executor : Executor, optional
        Where fits run, as `executors.local_pool` gives it; in this process when left out.

    Raises
    ------
    InputError
        For a campaign that cannot be fitted, or two of whose configurations look exchanged.
    """
    tell = logged(progress)
    if not isinstance(campaign, Campaign):
        job = read_fit(Path(campaign))
        warn_of_settings(job.settings, given)
        campaign, recordings = job.campaign, recordings or job.recordings
        calibration = calibration or job.calibration
    recordings = load_recordings(campaign) if recordings is None else recordings
    campaign, warnings = with_usual_uncertainty(campaign)
    every = dict(effects) if effects is not None else chosen_effects()
    if any(effect.needs_finite_elements for effect in given):  # the model has what they change
        every = {name: effect for name, effect in every.items() if not effect.needs_finite_elements}
    if has_open_rims(given):  # a chain has one pair of rims
        every = {name: effect for name, effect in every.items() if name != Delamination.name}
    nominal, minima = fit_nominal(
        campaign, recordings, law=law, calibration=calibration, given=given, seed=seed, executor=executor
    )
    refuse_exchanged(nominal, executor)
    tell("nominal model")
    usable = {name: effect for name, effect in every.items() if nominal.hypothesis.admits(effect)}
    places = fit_places(nominal, executor)
    tell("places with free laws")
    nominal, singles = fits_one_by_one(nominal, minima, usable, executor, places)
    singles, usable = with_response(singles, usable)
    nothing_fits = all(lack_of_fit(fit) for fit in [nominal, *singles.values()]) and not explain_data(places)
    if nothing_fits:
        nominal, places = with_further_laws(nominal, minima, usable, places, executor)
    tell("effects one by one")
    assessment = assess(nominal, singles, usable, tell, executor, places)
    if assessment.decision.verdict == "unknown" and not nothing_fits and not explain_data(places):
        # an effect that fits and is not the cause does not tell where this acts, nor do laws that do not fit
        nominal, places = with_further_laws(nominal, minima, usable, places, executor)
        assessment = assess(nominal, singles, usable, logged(None), executor, places)
    wrong = wrong_statement(assessment.comparison, assessment.decision, executor) if assessment.is_gap else None
    is_unknown = assessment.decision.verdict == "unknown"
    both = two_causes(assessment.comparison, executor) if is_unknown and not wrong else None
    name = campaign.folder.resolve().name
    record = assessment.entries(partial(rank_rig_designs, executor=executor), seed) | {
        "unknowns": _unknowns(nominal, assessment.corrected),
        "inputs": {"campaign": name, "multilayer": version("multilayer"), "law": law, **assessment.misfit_entries()},
        "warnings": [*warnings, *record_warnings(nominal)],
        **({"with": [effect.name for effect in given]} if given else {}),
        "two_causes": two_causes_entry(both) if both else None,
        "wrong_statement": wrong.entry if wrong else None,
    }
    if both:
        best, explanations = both.explanation, [(1.0, both.explanation)]
        record["sentence"] = f"{record['sentence']} {record['two_causes']['text']}"
        order = record["two_causes"]["places"]
        record["places"].sort(key=lambda entry: order.index(entry["place"]) if entry["place"] in order else len(order))
        record["gap"] = gap_entry(nominal, both.drawn.shrinkage)
    elif wrong and is_unknown:
        best, explanations = wrong.fitted, wrong.explanations
        record |= _stated_wrongly(nominal, wrong)
    else:
        best, explanations = assessment.best_fit, assessment.explanations
        if wrong:
            record["sentence"] = f"{record['sentence']} {wrong.doubt}"
            explanations = [*explanations, *wrong.explanations]
    record["moduli"] = told = moduli(nominal, explanations)
    return Diagnosis(name, record, residual_curves(nominal, best), assessment.similarity, told)


def warn_of_settings(settings: FitSettings, given: Sequence[Acting] = ()) -> None:
    """Warn of what a fit file says of the rig and a diagnosis does not take from it, but for effects that are given."""
    says = {
        "sensor_mass": (settings.sensor_mass != 0, SensorMass.name),
        "pores": (settings.pores is not None, SaturatingAir.name),
        "model: finite": (settings.model == "finite", FiniteSize.name),
    }
    known = {effect.name for effect in given}
    for field, (is_said, effect) in says.items():
        if is_said and effect not in known:
            text = f"{field} of the fit file is not taken by a diagnosis, which may name {effect} as the cause"
            warn(f"{text}; --with {effect} makes it a part of the nominal model", PlausibilityWarning, stacklevel=3)


def fit_nominal(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    *,
    law: str = DEFAULT_LAW,
    calibration: Calibration | None = None,
    given: Sequence[Acting] = (),
    seed: int = 0,
    executor: Executor | None = None,
) -> tuple[Fitted, list[Minimum]]:
    """Return the nominal model's fit, and the minima it started from; parameters as those of `diagnose_campaign`."""
    problems = burst_problems(campaign, recordings, FitSettings(), calibration)
    others = tuple(effect for effect in given if not effect.needs_finite_elements)
    joint = replace(plane_wave_problem(campaign, problems, law, None), model_error=MODEL_ERROR, given=others)
    minima = solve_from_bursts(joint, seed=seed, tolerance=COARSE, executor=executor)
    joint, minima = with_complete_records(joint, minima, [problem.data for problem in problems])
    if len(others) == len(given):
        return fit(joint, minima[0].z), minima
    rigs, start = free_rim(joint, minima)  # what a given free rim changes, no effect need change again
    rims = tuple(effect for effect in given if effect.needs_finite_elements)
    whole = replace(joint, rigs=rigs, finite=rigs, given=(*others, *rims))
    nominal = fit(whole, np.concatenate([start, np.zeros(len(parameters_of(rims)))]))
    if any(effect.name == FiniteSize.name for effect in rims):
        samples = elements_of_samples(nominal)
        made = dict(zip(samples, run_all(call, [*samples.values()], executor), strict=True))
        rough = fit_samples(nominal, made, executor)
        rigs = rough.hypothesis_as(CampaignProblem).finite
        nominal = fit(replace(whole, rigs=rigs, finite=rigs), rough.minimum.z)
    refuse_none(whole, [nominal.minimum] if nominal.minimum.is_finite else [])
    return nominal, [nominal.minimum]


def with_complete_records(
    problem: CampaignProblem, minima: list[Minimum], bursts: Sequence[BurstData]
) -> tuple[CampaignProblem, list[Minimum]]:
    """Return a problem whose data are as of records that go on until all is at rest, where that matters, and solutions.

    By what the nominal model says of the ring-down beyond their ends, the less certain the more it misses. In a joint
    fit the model is cut in place of that; here every hypothesis would have to be, at many times the cost.

    Parameters
    ----------
    problem : CampaignProblem
        Of plane waves.
    minima : list of Minimum
        Its solutions, the best first.
    bursts : sequence of BurstData
        All of the campaign.
    """
    ((_, cut, found),) = cut_where_records_end([("", problem, minima)], bursts)
    effect = cut.end_effect
    if effect is None:
        return problem, minima
    z = found[0].z
    data = []
    for part, missed in zip(cut.data, cut.differences(z), strict=True):
        if not part.ends:
            data.append(part)
            continue
        error = float(np.hypot(END_ERROR, END_GROWTH * np.sqrt(np.mean(np.abs(missed) ** 2))))
        change = effect.at(part.name, z)
        data.append(part.completed(change, error) if error < LARGEST_END_ERROR else part.incomplete(change))
    complete = replace(problem, configurations=data)
    if all(part.completed_by is None for part in data):
        return complete, minima
    return complete, distinct([minimise(complete, minimum.z, tolerance=COARSE) for minimum in found])


def record_warnings(nominal: Fitted) -> list[str]:
    """Return warnings of records that end before all is at rest."""
    problem, texts = nominal.hypothesis_as(CampaignProblem), []
    left_out = sum(len(c.bursts) for c in problem.campaign.configurations) - sum(len(d.centres) for d in problem.data)
    if left_out:
        texts.append(f"bursts left out, whose records end long before all is at rest: {left_out}; record longer")
    ending = "bursts whose records end before all is at rest, by"
    late = _beside_solvers([data.completed_by for data in problem.data], END_ERROR)
    if late.size:
        text = f"{ending} up to {100 * late.max():.0f} % of the ratio: {late.size}"
        texts.append(f"{text}; the rest is added as the nominal model has it, record longer")
    late = _beside_solvers([data.incomplete_by for data in problem.data], 1.0)
    if late.size:
        text = f"{ending} some {float(f'{100 * late.max():.1g}'):g} % by the nominal model of the ratio: {late.size}"
        texts.append(f"{text}; that model misses too much to add the rest: it may pass for a gap, record longer")
    return texts


def _beside_solvers(by: Sequence[RealArray | None], share: float) -> RealArray:
    """Return the changes by ends of records of which the share that stays in the data exceeds the solvers' error."""
    every = np.concatenate([np.zeros(0), *(changes for changes in by if changes is not None)])
    return every[share * every > MODEL_ERROR]


def fits_one_by_one(
    nominal: Fitted,
    minima: list[Minimum],
    effects: Mapping[str, BaseEffect],
    executor: Executor | None,
    places: Mapping[str, PlaceFit] | None = None,
) -> tuple[Fitted, dict[tuple[str, ...], Fitted]]:
    """Return the nominal model with the finite elements that some effects need, and the fits of effects one by one.

    Parameters
    ----------
    nominal, minima
        As `fit_nominal` returns them.
    effects : mapping
        By name; those that the model admits.
    executor : Executor or None
        Where fits run; None for this process.
    places : mapping, optional
        Places with a free law, by label: effects at places whose free law is far behind are not searched for.
    """
    wanted = {name: effect for name, effect in effects.items() if may_explain(nominal, places or {}, effect)}
    rest = {name: effect for name, effect in effects.items() if name not in wanted}
    finite = {name: effect for name, effect in wanted.items() if effect.needs_finite_elements}
    tasks = begin_tasks(
        nominal,
        {name: effect for name, effect in wanted.items() if name not in finite},
        others={name: other_starts(nominal, minima, places or {}, effect) for name, effect in wanted.items()},
    )
    # what takes longest comes first, as the finite elements, which the other fits do not need
    tasks = dict(sorted(tasks.items(), key=lambda item: not effects[item[0][0]].is_slow))
    first: list[Callable[[], Any]] = [partial(_fits_with_rim, nominal, minima, finite)] if finite else []
    started = run_all(call, [*first, *tasks.values()], executor)
    rigs, fits = started.pop(0) if finite else (nominal.hypothesis_as(CampaignProblem).finite, {})
    rim, begun = fits.get((FiniteSize.name,)), dict(zip(tasks, started, strict=True))
    samples = elements_of_samples(rim) if rim is not None and rim.log_evidence > nominal.log_evidence else {}
    ends = worth_finishing(begun, list(fits.values()))
    # elements for other samples take as long as several fits, and the other fits do not need them
    first = [*samples.values()]
    reached = run_all(call, [*first, *(end for _, end in ends)], executor)
    made, finished = reached[: len(samples)], reached[len(samples) :]
    if rim is not None and samples:
        fits[FiniteSize.name,] = rim = fit_samples(rim, dict(zip(samples, made, strict=True)), executor)
        rigs = rim.hypothesis_as(CampaignProblem).finite
    fits |= best_ends(begun, ends, finished)
    fits = _with_finer_law(polish_fits(fits, executor), executor)
    fits |= {(name,): rough_fit(nominal, effect) for name, effect in rest.items()}
    return with_rigs(nominal, rigs), {names: with_rigs(fits[names], rigs) for names in ((name,) for name in effects)}


def _with_finer_law(fits: dict[tuple[str, ...], Fitted], executor: Executor | None) -> dict[tuple[str, ...], Fitted]:
    """Return the fits, by finer laws of their effects where the best does not fit.

    Of effects that leave little more than the best does: which of them is ahead by a law that does not fit means
    little. Finer laws are tried one after the other, each from the minimum of the one before.
    """
    if not fits:
        return fits
    best = best_of([*fits.values()])
    if not lack_of_fit(best):
        return fits
    most = NEAR_LEAST * best.minimum.cost
    refined = {names: _by_finer_laws(found, executor) for names, found in fits.items() if found.minimum.cost < most}
    return fits | refined


def _by_finer_laws(found: Fitted, executor: Executor | None) -> Fitted:
    """Return a fit of a single effect by the first of its finer laws that fits; as it is where none does."""
    best = found
    while lack_of_fit(best):
        hypothesis, z = best.hypothesis.bare(best.minimum.z)
        (effect,) = hypothesis.effects
        finer = effect.finer([data.name for data in hypothesis.data])
        if finer is None:
            return found
        more = sorted({start[len(effect.parameters) :] for start in finer.starts})
        begun = StartedFit.at(hypothesis.with_effects(finer), np.array([[*z, *start] for start in more]))
        best = polish_fits(finish_all({(): begun}, executor), executor)[()]
    return best_of([found, best])


def _fits_with_rim(
    nominal: Fitted, minima: list[Minimum], effects: Mapping[str, BaseEffect]
) -> tuple[Mapping[str, Rig], dict[tuple[str, ...], Fitted]]:
    """Return finite elements by configuration, and the fits of effects that need them."""
    rigs, start = free_rim(nominal.hypothesis_as(CampaignProblem), minima)
    return rigs, fit_effects(with_rigs(nominal, rigs), effects, start)


def _modulus(fitted: Fitted, frequency: RealArray) -> Any:
    return fitted.hypothesis_as(CampaignProblem).own_modulus(fitted.minimum.z, frequency)


def _stated_wrongly(nominal: Fitted, wrong: WrongStatement) -> dict[str, Any]:
    """Return the entries of ``diagnosis.json`` that are others where a wrong statement explains the gap."""
    deviations = stated_entries(nominal, wrong.fitted, {wrong.name: wrong.pull.deviations})
    return {
        "sentence": wrong.sentence,
        "gap": gap_entry(nominal, wrong.shrinkage, wrong.fitted),
        "stated_deviations": deviations,
        "unknowns": _unknowns(nominal, wrong.fitted),
    }


def _unknowns(nominal: Fitted, corrected: Fitted) -> dict[str, Any]:
    f = np.concatenate([data.frequency for data in nominal.hypothesis.data])
    at = float(np.clip(_REFERENCE, f.min(), f.max()))
    before, after = (_modulus(fitted, np.array([at]))[0] for fitted in (nominal, corrected))
    pairs = {"nominal": before, "corrected": after}
    values: dict[str, Any] = {name: [float(e.real), float(e.imag)] for name, e in pairs.items()} | {"unit": "Pa"}
    return {f"E({at:.0f} Hz)": values}
