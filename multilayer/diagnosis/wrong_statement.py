"""A stated quantity that is wrong: a wrong entry of a campaign file, a plate or a sample that was mistaken for another.

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
from multilayer.diagnosis.evidence import ModelComparison
from multilayer.diagnosis.fitting import Fitted, best_of
from multilayer.diagnosis.goodness_of_fit import explains_data
from multilayer.diagnosis.place_fits import FINE, descended
from multilayer.diagnosis.thresholds import CERTAIN_P, LEAST_SCORE, TEMPERATURE, TIED
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
    """

    pull: Pull
    fitted: Fitted
    shrinkage: Shrinkage
    tied: Mapping[str, Fitted] = field(default_factory=dict)

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
        """What it explains, for people."""
        rivals = f"; the data cannot tell it from {', '.join(self.tied)}" if self.tied else ""
        return (
            "There is a gap, and none of the known effects explains it: what is stated of the laboratory is wrong, "
            f"{self.pull.in_words}{rivals}."
        )

    @property
    def entry(self) -> dict[str, Any]:
        """The entry ``wrong_statement`` of ``diagnosis.json``: value and 90 % interval of what is to be added."""
        value, low, high = self.fitted.interval(self.name)
        unit, deviations = self.pull.parameter.unit, round(self.pull.deviations, 3)
        size = {"value": value, "low": low, "high": high, "unit": unit, "deviations": deviations}
        return {"name": self.name, **size, "tied": list(self.tied)}


def wrong_statement(comparison: ModelComparison, executor: Executor | None = None) -> WrongStatement | None:
    """Return the density, height or mass that explains the gap by being wrong; None where a law does so better.

    It must explain the data, all else being as stated; be off by what no chance does (`CERTAIN_P`); and have more
    evidence than the nominal model and than any free law.

    Parameters
    ----------
    comparison : ModelComparison
        Of a campaign, whose verdict is an unknown cause.
    executor : Executor, optional
        Where fits run; in this process when left out.
    """
    nominal = comparison.nominal
    problem = nominal.hypothesis_as(CampaignProblem)
    names = problem.nuisances.of_pieces
    if not names:
        return None
    fits = dict(zip(names, run_all(call, [partial(_without, nominal, name) for name in names], executor), strict=True))
    evidence = {name: tolerant_evidence(fitted) for name, fitted in fits.items()}
    name = max(names, key=evidence.__getitem__)
    best, least = fits[name], evidence[name] - TIED
    rivals = [fit.log_evidence for fit in comparison.places.values()]
    needed = max([tolerant_evidence(nominal) + LEAST_SCORE, *rivals]) + float(np.log(len(names)))
    if evidence[name] < needed or not explains_data(best):
        return None
    index = [parameter.name for parameter in problem.parameters].index(name)
    stated = problem.parameters[index]
    value, low, high = (float(stated.prior.coordinate(end)) for end in best.interval(name))
    by_chance = float(np.hypot(1, (high - low) / (2 * _REACH)))
    if len(names) * exceeding((value / by_chance) ** 2, 1) > CERTAIN_P:
        return None
    (shrinkage,) = cross_validate(nominal, [best], executor, noise=comparison.noise)
    near = [other for other in names if other != name and evidence[other] > least]
    tied = {other: fits[other] for other in near if explains_data(fits[other])}
    return WrongStatement(Pull(stated, value, by_chance), best, shrinkage, tied)


def _without(nominal: Fitted, name: str) -> Fitted:
    """Return the nominal model without what is stated of a quantity."""
    problem = nominal.hypothesis_as(CampaignProblem)
    hypothesis, z = replace(problem, unstated=name), nominal.minimum.z.copy()
    index = [parameter.name for parameter in problem.parameters].index(name)
    z[index] = hypothesis.parameters[index].prior.coordinate(problem.parameters[index].prior.value(z[index]))
    return best_of([descended(hypothesis, start, *FINE) for start in (z, hypothesis.at_rest(z))])
