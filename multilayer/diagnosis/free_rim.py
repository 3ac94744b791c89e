"""Finite elements of the free rim for a comparison of hypotheses, and what fits with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial

from multilayer.arrays import RealArray
from multilayer.diagnosis.fitting import COARSELY, Fitted, at_minimum
from multilayer.errors import MultilayerError
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.finite_elements import Fineness, FiniteRig
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.fits.joint import samples
from multilayer.fits.joint.fit import rigs_around, with_free_rim
from multilayer.fits.joint.search import search_laws
from multilayer.fits.settings import FitSettings
from multilayer.inference.problem import Minimum

COARSE = 1e-4  # relative change of the cost at which a first search has converged
_RESOLUTION, _TOLERANCE = 0.9, 1e-4  # of mesh and reduced basis
_ROOM = (0.98, 1.02)  # factors around the data's frequencies
_FEW = 2  # solutions of plane waves from which the search starts


def free_rim(problem: CampaignProblem, minima: Sequence[Minimum]) -> tuple[Mapping[str, Rig], RealArray]:
    """Return finite elements by configuration, and coordinates of a law that fits with them roughly.

    The elements hold for the data's frequencies only, and are coarser than those of a fit: right to a tenth of
    `thresholds.MODEL_ERROR`.

    Parameters
    ----------
    problem : CampaignProblem
        Of plane waves.
    minima : sequence of Minimum
        Solutions of that problem, the best first.
    """
    few, settings = [*minima[:_FEW]], FitSettings()
    bands = {data.name: (_ROOM[0] * data.frequency.min(), _ROOM[1] * data.frequency.max()) for data in problem.data}
    fineness, solve = Fineness(_RESOLUTION, _TOLERANCE, bands), partial(search_laws, n_best=1, tolerance=COARSE)
    try:
        with_rim, solutions = with_free_rim(problem.campaign, problem, few, _silent, settings, fineness, solve)
    except MultilayerError:  # no law fits the data with a free rim
        return rigs_around(problem.campaign, problem, minima[0], _silent, settings, fineness), minima[0].z
    return with_rim.rigs, solutions[0].z


def _silent(text: str) -> None:
    pass


def elements_of_samples(fitted: Fitted) -> dict[str, Callable[[], FiniteRig | None]]:
    """Return the tasks of `samples.elements_of_samples` for a fit."""
    return samples.elements_of_samples(fitted.hypothesis_as(CampaignProblem), fitted.minimum.z)


def fit_samples(fitted: Fitted, made: Mapping[str, FiniteRig | None], executor: Executor | None = None) -> Fitted:
    """Return a coarse fit with finite elements about the sample that explains the data best.

    Parameters
    ----------
    fitted : Fitted
        With `FiniteSize` among its effects, given ones or not, and the finite elements of the stated sample.
    made : mapping
        What the tasks of `elements_of_samples` return; with a None among it, the fit is returned as it is.
    executor : Executor, optional
    """
    rigs = {name: rig for name, rig in made.items() if rig is not None}
    if len(rigs) < len(made):
        return fitted

    def solve(problem: CampaignProblem, z: RealArray) -> Fitted:
        return at_minimum(problem, z, *COARSELY)

    problem = fitted.hypothesis_as(CampaignProblem)
    return samples.fit_samples(problem, fitted.minimum.z, rigs, solve, lambda found: found.minimum.z, executor)


def with_rigs(fitted: Fitted, rigs: Mapping[str, Rig]) -> Fitted:
    """Return a fit with finite elements, to which any effects may be added."""
    return replace(fitted, hypothesis=replace(fitted.hypothesis_as(CampaignProblem), finite=rigs))
