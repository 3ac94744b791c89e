"""Answers to the page of a model beside its measurements: unknowns and effects are turned by hand, or fitted.

Coordinates are the standard normal ones of the unknowns' priors (`multilayer.inference.priors`): a slider from -3 to 3
holds 99.7 % of what is thought of beforehand, whatever the unknown. The page remembers them; here only the files are.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any
from warnings import warn

import numpy as np

from multilayer.arrays import RealArray
from multilayer.chi2 import exceeding
from multilayer.diagnosis.diagnose import chosen_effects, fit_nominal, warn_of_settings
from multilayer.diagnosis.effects.base import BaseEffect, Effect
from multilayer.diagnosis.file import load_diagnosis
from multilayer.diagnosis.fitting import Fitted, minimise_scaled
from multilayer.diagnosis.free_rim import free_rim
from multilayer.diagnosis.nominal import fitted_nominal
from multilayer.doors import for_log
from multilayer.errors import InputError, PlausibilityWarning
from multilayer.experiments.hypothesis import Hypothesis
from multilayer.experiments.stacks.problem import StackProblem
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.nuisances import with_usual_uncertainty
from multilayer.explore.curves import rounded
from multilayer.explore.questions import Answer, Questions
from multilayer.fits.joint.samples import about, for_samples, leaves_sample_open, solid_of, stated_samples
from multilayer.fits.sources import Source
from multilayer.inference.collinearity import PREFIX
from multilayer.inference.problem import Held, Minimum
from multilayer.inference.pulls import nuisance_p_value
from multilayer.number_text import plain_unit
from multilayer.units import parse_quantity

_FARTHEST = 1e4  # standard deviations: a gap drags what is stated off by hundreds
_FIT = (80, 1e-6)  # evaluations, and relative change of the cost at which a fit has converged
_NEAR = 1e-3  # relative, by which a value that was typed may be missed
_NO_RESPONSE = "the model has no response near here; turn back what is far out, then fit"


@dataclass(frozen=True)
class NominalModel:
    """A nominal model, fitted, with the effects that may act besides.

    Attributes
    ----------
    fitted : Fitted
    minima : tuple of Minimum
        Of a campaign, the minima of its search.
    effects : mapping
        By name.
    """

    fitted: Fitted
    minima: tuple[Minimum, ...]
    effects: Mapping[str, BaseEffect]


def nominal_model(source: Source) -> NominalModel:
    """Fit the nominal model of a campaign, or of stacks with their measurements.

    Raises
    ------
    InputError
        When the files cannot be used.
    """
    minima: tuple[Minimum, ...] = ()
    if source.of_stacks:
        file = load_diagnosis(source.document)
        fitted, every = fitted_nominal(file), file.chosen()
    else:
        job = source.campaign_job(source.settings())
        warn_of_settings(job.settings)
        campaign, texts = with_usual_uncertainty(job.campaign)
        for text in texts:
            warn(text, PlausibilityWarning, stacklevel=2)
        fitted, found = fit_nominal(campaign, job.recordings, calibration=job.calibration)
        minima, every = tuple(found), chosen_effects()
    return NominalModel(
        fitted, minima, {name: effect for name, effect in every.items() if fitted.hypothesis.admits(effect)}
    )


class ModelExplorer(Questions):
    """What answers the page of one model.

    Parameters
    ----------
    source : Source
        A campaign, or stacks with their measurements.
    named : mapping, optional
        By the names of effects with which the page begins, values of their parameters; all unknowns are fitted to them.

    Raises
    ------
    InputError
        When it cannot be used.
    """

    page = "model"

    def __init__(self, source: Source, named: Mapping[str, Mapping[str, float]] | None = None) -> None:
        super().__init__(source.path)
        self.model = nominal_model(source)
        self.hypothesis: Hypothesis = self.model.fitted.hypothesis
        self.answers = {"start": self.start, "evaluate": self.evaluate, "fit": self.fit}
        self.first = self._with_named(named) if named else None

    def start(self, request: Mapping[str, Any]) -> Answer:
        """Return what there is to be turned, the nominal model's coordinates, and those to begin with if others."""
        del request
        hypothesis = self.hypothesis
        return {
            "file": for_log(self.file.resolve().name),
            "configurations": [for_log(data.name) for data in hypothesis.data],
            "apart": isinstance(hypothesis, CampaignProblem),
            "parts": [{"title": part.title, "unit": part.unit} for part in hypothesis.shown_as],
            "z": self.model.fitted.minimum.z.tolist(),
            "first": self.first,
            "unknowns": [
                {"name": one.name, "title": _title(one.name), "stated": one.nuisance}
                for one in hypothesis.nominal_parameters
            ],
            "effects": [_described(effect) for effect in self.model.effects.values()],
            "problems": [],
        }

    def _with_named(self, named: Mapping[str, Mapping[str, float]]) -> Answer:
        """Return coordinates with some effects, all of them fitted."""
        unknown = [name for name in named if name not in self.model.effects]
        if unknown:
            raise InputError(f"the effect '{for_log(unknown[0])}' is not known here; is a plugin missing?")
        effects = {}
        for name, values in named.items():
            parameters = self.model.effects[name].parameters
            if {one.name for one in parameters} != set(values):
                raise InputError(f"the effect '{for_log(name)}' has other parameters now; run diagnose again")
            effects[name] = [float(one.prior.coordinate(values[one.name])) for one in parameters]
        answer = self.fit({"z": self.model.fitted.minimum.z.tolist(), "effects": effects})
        return {"z": answer["z"], "effects": answer["effects"]}

    def evaluate(self, request: Mapping[str, Any]) -> Answer:
        """Return the curves of one configuration, and how well all of them fit.

        Of coordinates ``z`` of the nominal model's unknowns and of ``effects``, as `start` gives them; ``typed`` is
        the name of an unknown and the text that its value is to be; ``beside`` other coordinates and effects, of which
        the curves are wanted, too; ``at`` is the index of the configuration.
        """
        return self._shown(*self._asked(request), request)

    def fit(self, request: Mapping[str, Any]) -> Answer:
        """Return what `evaluate` does at the nearest minimum of all unknowns but those whose names are ``held``."""
        hypothesis, z = self._asked(request)
        held = request.get("held", [])
        if not isinstance(held, list):
            raise InputError("unknowns are held by a list of their names")
        free = np.array([parameter.name not in held for parameter in hypothesis.parameters], dtype=bool)
        if np.any(free):
            problem = Held(hypothesis, z, free)
            try:
                minimum = minimise_scaled(problem, z[free], *_FIT)
            except ValueError as error:  # NumPy's LinAlgError among them, where something overflows on the way
                raise InputError(_NO_RESPONSE) from error
            if not np.isfinite(minimum.cost):
                raise InputError(_NO_RESPONSE)
            z = problem.all_coordinates(minimum.z)
        return self._shown(hypothesis, z, request)

    def _asked(self, request: Mapping[str, Any]) -> tuple[Hypothesis, RealArray]:
        """Return the hypothesis of a request and its coordinates."""
        chosen = request.get("effects", {})
        if not isinstance(chosen, Mapping):
            raise InputError("effects are asked for by name, with their coordinates")
        unknown = [name for name in chosen if name not in self.model.effects]
        if unknown:
            raise InputError(f"there is no effect '{for_log(unknown[0])}' here")
        effects = [self.model.effects[name] for name in chosen]
        z = _numbers(request.get("z"), len(self.hypothesis.nominal_parameters), "z")
        for effect in effects:
            z += _numbers(chosen[effect.name], len(effect.parameters), effect.name)
        if any(effect.needs_finite_elements for effect in effects):
            self._add_finite_elements(effects, np.array(z))
        hypothesis, typed = self.hypothesis.with_effects(*effects), request.get("typed")
        return hypothesis, np.array(z) if typed is None else _with_typed(hypothesis, np.array(z), typed)

    def _add_finite_elements(self, effects: Sequence[BaseEffect], z: RealArray) -> None:
        """Give the campaign the finite elements that some effects need, once: they take as long as many fits.

        They are made about the sample that is asked for first.
        """
        problem = self.hypothesis
        if isinstance(problem, CampaignProblem) and not problem.finite:
            rigs, law = free_rim(problem, self.model.minima)
            acting = [effect for effect in effects if isinstance(effect, Effect)]
            if leaves_sample_open(acting):
                asked = replace(problem, finite=rigs).with_effects(*acting)
                made = {name: for_samples(*pair) for name, pair in stated_samples(asked, law).items()}
                rigs = about(asked, made, solid_of(asked, z))
            self.hypothesis = replace(problem, finite=rigs)

    def _shown(self, hypothesis: Hypothesis, z: RealArray, request: Mapping[str, Any]) -> Answer:
        at = request.get("at", 0)
        index = at if isinstance(at, int) and 0 <= at < len(hypothesis.data) else 0
        differences = hypothesis.differences(z)
        white = [
            experiment.whiten(difference)
            for experiment, difference in zip(hypothesis.experiments, differences, strict=True)
        ]
        if not all(np.all(np.isfinite(values)) for values in white):
            raise InputError("with these values the model has no response at some frequency")
        beside = request.get("beside")
        other = None
        if isinstance(beside, Mapping):
            compared, at_z = self._asked(beside)
            other = compared.differences(at_z)[index]
        n, misfit = sum(map(len, white)), float(sum(values @ values for values in white))
        count = first = len(hypothesis.nominal_parameters)
        effects = {}
        for effect in hypothesis.effects:
            effects[effect.name] = z[first : first + len(effect.parameters)].tolist()
            first += len(effect.parameters)
        return {
            "z": z[:count].tolist(),
            "effects": effects,
            "values": _values(hypothesis, z),
            "misfits": [float(values @ values) / len(values) for values in white],
            "misfit": misfit / n,
            "p_value": exceeding(misfit, n),
            "stated_p_value": nuisance_p_value(hypothesis.parameters, z),
            "curves": _curves(hypothesis, index, differences[index], other),
            "problems": [],
        }


def _numbers(part: Any, count: int, what: str) -> list[float]:
    """Return coordinates that a page sent, kept within what priors hold."""
    if not isinstance(part, list) or len(part) != count or not all(isinstance(one, int | float) for one in part):
        raise InputError(f"{what}: {count} coordinates are needed, all of them numbers")
    # kept before they are floats: an integer may be larger than any
    return [float(min(max(one, -_FARTHEST), _FARTHEST)) for one in part]


def _own(hypothesis: Hypothesis, z: RealArray) -> RealArray:
    """Return coordinates in the unknowns' own priors, where an earlier measurement has narrowed those."""
    if not isinstance(hypothesis, StackProblem):
        return z
    count = len(hypothesis.nominal_parameters)
    return np.concatenate([hypothesis.own_coordinates(z), z[count:]])


def _quantities(hypothesis: Hypothesis, z: RealArray) -> list[tuple[float, str]]:
    """Return value and unit of every unknown; of logarithms, what they are the logarithm of."""
    units = _law_units(hypothesis)
    found = []
    for parameter, own in zip(hypothesis.parameters, _own(hypothesis, z), strict=True):
        value = float(parameter.prior.value(own))
        is_logarithm = parameter.name.startswith(PREFIX)
        unit = units.get(parameter.name.removeprefix(PREFIX), "") if is_logarithm else parameter.unit
        found.append((float(np.exp(value)) if is_logarithm else value, unit))
    return found


def _law_units(hypothesis: Hypothesis) -> dict[str, str]:
    """Return the units of laws' parameters, by their names."""
    if isinstance(hypothesis, CampaignProblem):
        return dict(zip(hypothesis.space.names, hypothesis.space.units, strict=True))
    unknowns = hypothesis.unknowns if isinstance(hypothesis, StackProblem) else ()
    return {name: unit for each in unknowns for name, unit in zip(each.names, each.units, strict=True)}


def _values(hypothesis: Hypothesis, z: RealArray) -> dict[str, dict[str, Any]]:
    """Return what every unknown is in words: number and unit."""
    pairs = zip(hypothesis.parameters, _quantities(hypothesis, z), strict=True)
    return {parameter.name: _in_words(value, unit) for parameter, (value, unit) in pairs}


def _in_words(value: float, unit: str) -> dict[str, Any]:
    symbol, factor = plain_unit(value, unit)
    return {"text": f"{value / factor:.4g}", "unit": symbol, "factor": factor}


def _with_typed(hypothesis: Hypothesis, z: RealArray, typed: Any) -> RealArray:
    """Return coordinates with those of one unknown at a value that was typed.

    Raises
    ------
    InputError
        When there is no such unknown, or the text is no value of it.
    """
    name, text = (str(typed.get(key, "")) for key in ("name", "text")) if isinstance(typed, Mapping) else ("", "")
    names = [parameter.name for parameter in hypothesis.parameters]
    if name not in names:
        raise InputError(f"there is no unknown '{for_log(name)}' here")
    index = names.index(name)
    parameter = hypothesis.parameters[index]
    now, unit = _quantities(hypothesis, z)[index]
    value = _parsed(text, unit, _in_words(now, unit)["factor"], _title(name))
    is_logarithm = parameter.name.startswith(PREFIX)
    if is_logarithm or parameter.prior.is_logarithmic:
        if not value > 0:
            raise InputError(f"{_title(name)}: {for_log(text)} is not above 0")
        value = float(np.log(value)) if is_logarithm else value
    own = _own(hypothesis, z)
    own[index] = float(parameter.prior.coordinate(value))
    if isinstance(hypothesis, StackProblem) and hypothesis.earlier is not None:
        count = len(hypothesis.nominal_parameters)
        root = hypothesis.earlier.root
        own[:count] = np.linalg.solve(root, own[:count] - hypothesis.earlier.mean)
    moved = z.copy()
    moved[index] = np.clip(own[index], -_FARTHEST, _FARTHEST)
    reached, wanted = (_quantities(hypothesis, moved)[index][0], np.exp(value) if is_logarithm else value)
    if abs(reached - wanted) > _NEAR * max(abs(reached), abs(wanted)):
        words = _in_words(reached, unit)
        told = f"{words['text']} {words['unit']}".rstrip()
        raise InputError(f"{_title(name)}: {for_log(text)} is beyond what its prior holds, {told} at most or at least")
    return moved


def _parsed(text: str, unit: str, factor: float, title: str) -> float:
    """Return a value in `unit` from a text; a bare number is in the unit that stands beside it."""
    try:
        value = float(text) * factor
    except ValueError:
        try:
            value = parse_quantity(text, unit)
        except ValueError as error:
            raise InputError(f"{title}: {error}") from None
    if not np.isfinite(value):
        raise InputError(f"{title}: {for_log(text)} is no number")
    return value


def _title(name: str) -> str:
    """Return the name of an unknown for people: ``layers.foam.flow_resistivity`` as ``foam: flow resistivity``."""
    path, bracket, rest = name.removeprefix(PREFIX).removeprefix("layers.").partition("[")
    return for_log((path.replace(".", ": ", 1) + bracket + rest).replace("_", " "))


def _described(effect: BaseEffect) -> dict[str, Any]:
    """Return what a page shows of an effect: as it begins, of its usual size."""
    told = (type(effect).__doc__ or "").strip().splitlines()
    return {
        "name": effect.name,
        "title": effect.name.replace("_", " "),
        "summary": told[0].replace("`", "") if told else "",
        "law": effect.law,
        "slow": effect.needs_finite_elements,
        "unknowns": [
            {"name": f"{effect.name}.{one.name}", "title": one.name.replace("_", " "), "stated": False}
            for one in effect.parameters
        ],
        "z": effect.usual,
    }


def _curves(hypothesis: Hypothesis, index: int, here: Any, other: Any | None) -> dict[str, Any]:
    """Return measured and modelled values of one configuration, as they are shown."""
    data, spreads = hypothesis.data[index], hypothesis.spreads[index]
    parts = []
    for i, (part, spread) in enumerate(zip(hypothesis.shown_as, spreads, strict=True)):

        def shown(values: Any, number: int = i, factor: float = part.factor) -> list[float | None]:
            return rounded(factor * (values.imag if number else values.real))

        parts.append(
            {
                "measured": shown(data.target),
                "model": shown(data.target + here),
                "beside": None if other is None else shown(data.target + other),
                "spread": rounded(part.factor * spread),
            }
        )
    return {"frequency": rounded(data.frequency), "burst": data.burst.tolist(), "parts": parts}
