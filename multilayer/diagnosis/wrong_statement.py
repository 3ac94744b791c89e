"""A stated quantity that is wrong: a slip in a campaign file, or a piece that was measured badly.

What a laboratory states has a standard deviation, and a nominal model drags it off against that; far off, a free law of
many unknowns costs less. A single wrong entry costs one unknown: its prior is that of a mistake.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Executor
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.special import ndtri

from multilayer.chi2 import exceeding
from multilayer.diagnosis.cross_validation import Shrinkage, cross_validate
from multilayer.diagnosis.decision import Decision, in_words, where_in_words
from multilayer.diagnosis.evidence import UNKNOWN, ModelComparison
from multilayer.diagnosis.fitting import Fitted, best_of
from multilayer.diagnosis.goodness_of_fit import explains_data
from multilayer.diagnosis.place_fits import COARSE, FINE, descended, near_best
from multilayer.diagnosis.simple_forms import simple_term
from multilayer.diagnosis.thresholds import CERTAIN_P, LEAST_SCORE, LEAST_SHRINKAGE, NEAR, TEMPERATURE, TIED
from multilayer.diagnosis.unknown_cause import tolerant_evidence
from multilayer.executors import call, run_all
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.inference.pulls import Pull

_REACH = float(ndtri(0.95))  # standard deviations to the ends of 90 % intervals


@dataclass(frozen=True)
class WrongStatement:
    """A stated quantity that explains the gap by being another.

    Attributes
    ----------
    pull : Pull
        Of the quantity, by what was stated of it.
    fitted : Fitted
        The nominal model with that quantity as an unknown.
    shrinkage : Shrinkage
    tied : mapping
        Fits of other quantities that the data cannot tell from it, by name.
    rivals : tuple of str
        Known effects and laws, in words, that they cannot tell from it either.
    """

    pull: Pull
    fitted: Fitted
    shrinkage: Shrinkage
    tied: Mapping[str, Fitted] = field(default_factory=dict)
    rivals: tuple[str, ...] = ()

    @property
    def name(self) -> str:
        """Name of the quantity."""
        return self.pull.parameter.name

    @property
    def explanations(self) -> list[tuple[float, Fitted]]:
        """What explains the data, with weights: the best, and what is tied with it."""
        fits = [self.fitted, *self.tied.values()]
        evidences = np.array([tolerant_evidence(fitted) for fitted in fits])
        weights = np.exp((evidences - evidences.max()) / TEMPERATURE)
        return list(zip(weights.tolist(), fits, strict=True))

    @property
    def sentence(self) -> str:
        """What it explains, for people, where no known effect does."""
        rivals = [*self.tied, *self.rivals]
        others = f"; the data cannot tell it from {', '.join(rivals)}" if rivals else ""
        return f"There is a gap, and what is stated of the laboratory is wrong: {self.pull.in_words}{others}."

    @property
    def doubt(self) -> str:
        """What it explains, for people, as well as a known effect that is named."""
        others = f" (or {', '.join(self.tied)} instead)" if self.tied else ""
        return (
            f"Without any effect, what is stated would explain it as well by being wrong: {self.pull.in_words}{others}."
        )

    @property
    def entry(self) -> dict[str, Any]:
        """The entry ``wrong_statement`` of ``diagnosis.json``: value and 90 % interval of what is to be added."""
        value, low, high = self.fitted.interval(self.name)
        unit, deviations = self.pull.parameter.unit, round(self.pull.deviations, 3)
        size = {"value": value, "low": low, "high": high, "unit": unit, "deviations": deviations}
        return {"name": self.name, **size, "tied": list(self.tied), "rivals": list(self.rivals)}


def wrong_statement(
    comparison: ModelComparison, decision: Decision, executor: Executor | None = None
) -> WrongStatement | None:
    """Return the density, height or mass that explains the gap by being wrong; None where another cause does so better.

    It must explain the data, all else being as stated, and what is left out (`LEAST_SHRINKAGE`), and be off by what no
    chance does (`CERTAIN_P`). Unless an effect is named it must have more evidence than the nominal model. Known causes
    of the verdict may not be ahead of it by more than `TIED` nor, unless an effect is named, laws at the best places,
    free or of one term. Not where the rig's model has finite elements, which know samples near the stated ones only.

    Parameters
    ----------
    comparison : ModelComparison
        Of a campaign with a gap.
    decision : Decision
        Its group holds the known causes that may explain it.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    nominal = comparison.nominal
    problem = nominal.hypothesis_as(CampaignProblem)
    names = problem.nuisances.of_pieces
    if not names or not all(rig.takes_arrays for rig in problem.rigs.values()):
        return None
    near = near_best(run_all(call, [partial(_without, nominal, name) for name in names], executor))
    ends = run_all(call, [partial(descended, fit.hypothesis, fit.minimum.z, *FINE) for fit in near], executor)
    fits = {fit.hypothesis_as(CampaignProblem).unstated: fit for fit in ends}
    evidences = {name: tolerant_evidence(fitted) for name, fitted in fits.items()}
    name = max(fits, key=evidences.__getitem__)
    best, evidence = fits[name], evidences[name] - float(np.log(len(names)))
    is_named = decision.verdict == "effect"
    effects = {in_words(cause): comparison.evidence[cause] for cause in decision.group if cause != UNKNOWN}
    least = max(effects.values()) - TIED if is_named else tolerant_evidence(nominal) + LEAST_SCORE
    pull = _pull(nominal, best, name)
    is_chance = len(names) * exceeding((pull.deviations / pull.by_chance) ** 2, 1) > CERTAIN_P
    if evidence < least or is_chance or not explains_data(best):
        return None
    rivals = effects if is_named else effects | _laws(comparison, executor)
    if evidence < max(rivals.values(), default=-np.inf) - TIED:
        return None
    (shrinkage,) = cross_validate(nominal, [best], executor, noise=comparison.noise)
    if not shrinkage.share >= LEAST_SHRINKAGE:  # nan: nothing could be left out
        return None
    rest = [other for other in fits if other != name and evidences[other] > evidences[name] - TIED]
    tied = {other: fits[other] for other in rest if explains_data(fits[other])}
    others = tuple(text for text, other in rivals.items() if other > evidence - TIED)
    return WrongStatement(pull, best, shrinkage, tied, others)


def _without(nominal: Fitted, name: str) -> Fitted:
    """Return a coarse fit of the nominal model without what is stated of a quantity."""
    problem = nominal.hypothesis_as(CampaignProblem)
    hypothesis, z = replace(problem, unstated=name), nominal.minimum.z.copy()
    index = [parameter.name for parameter in problem.parameters].index(name)
    z[index] = hypothesis.parameters[index].prior.coordinate(problem.parameters[index].prior.value(z[index]))
    return best_of([descended(hypothesis, start, *COARSE) for start in (z, hypothesis.at_rest(z))])


def _pull(nominal: Fitted, fitted: Fitted, name: str) -> Pull:
    """Return by how much a quantity is off that is an unknown of a fit, by what was stated of it."""
    stated = next(parameter for parameter in nominal.hypothesis.parameters if parameter.name == name)
    value, low, high = (float(stated.prior.coordinate(end)) for end in fitted.interval(name))
    return Pull(stated, value, float(np.hypot(1, (high - low) / (2 * _REACH))))


def _laws(comparison: ModelComparison, executor: Executor | None) -> dict[str, float]:
    """Return the evidence of laws at the best places, free or of one term, by what they are in words."""
    best = max((fit.log_evidence for fit in comparison.places.values()), default=0.0)
    near = [fit for fit in comparison.places.values() if fit.log_evidence > best - NEAR]
    terms = [fit.term or simple_term(comparison.nominal, fit, executor) for fit in near]
    return {
        f"a law of its own {where_in_words(fit.place)}": max(fit.log_evidence, term.log_evidence)
        for fit, term in zip(near, terms, strict=True)
    }
