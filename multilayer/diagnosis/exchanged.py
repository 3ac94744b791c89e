"""Recordings, samples or plates of two configurations that stand for each other: a slip in a campaign file."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from itertools import combinations

from multilayer.diagnosis.fitting import Fitted
from multilayer.diagnosis.goodness_of_fit import explains_data
from multilayer.diagnosis.place_fits import COARSE, FINE, descended
from multilayer.diagnosis.thresholds import EXCHANGED
from multilayer.errors import InputError
from multilayer.executors import call, run_all
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.measurements.campaign import problem_in


def refuse_exchanged(nominal: Fitted, executor: Executor | None = None) -> None:
    """Refuse a campaign that the nominal model misses by far, and explains once two configurations are exchanged.

    Nothing is adjusted to that: no effect explains by chance all that a large gap holds without an unknown of its own.

    Parameters
    ----------
    nominal : Fitted
        Of a campaign.
    executor : Executor, optional
        Where fits run; in this process when left out.

    Raises
    ------
    InputError
        With the two configurations, at the line of the second.
    """
    problem, n = nominal.hypothesis_as(CampaignProblem), len(nominal.minimum.residual)
    before = nominal.minimum.cost / n
    if not before > EXCHANGED:
        return
    pairs = list(combinations(range(len(problem.configurations)), 2))
    coarse = run_all(call, [partial(_exchanged, nominal, *pair) for pair in pairs], executor)
    if not coarse:
        return
    best = min(range(len(pairs)), key=lambda i: coarse[i].minimum.cost)
    fitted = descended(coarse[best].hypothesis, coarse[best].minimum.z, *FINE)
    if not explains_data(fitted):
        return
    one, two = (problem.configurations[i].name for i in pairs[best])
    text = (
        f"'{one}' and '{two}' look exchanged: as they are, the model leaves a misfit of {before:.3g}, and "
        f"with their recordings exchanged of {fitted.minimum.cost / n:.2g}, where noise alone gives 1; exchange their "
        "files, or correct which sample and which plate they had"
    )
    places = [configuration.name for configuration in problem.campaign.configurations]
    raise InputError(problem_in(problem.campaign, text, ("configurations", places.index(two))))


def _exchanged(nominal: Fitted, i: int, j: int) -> Fitted:
    """Return a coarse fit of the nominal model to the data with those of two configurations exchanged."""
    problem = nominal.hypothesis_as(CampaignProblem)
    data = list(problem.configurations)
    for at, other in ((i, j), (j, i)):
        here = problem.configurations[at]
        data[at] = replace(problem.configurations[other], name=here.name, thickness=here.thickness)
    return descended(replace(problem, configurations=data), nominal.minimum.z, *COARSE)
