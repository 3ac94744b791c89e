"""Finite elements of the free rim for a comparison of hypotheses, and a law that fits with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.diagnosis.effects.finite_size import FiniteSize
from multilayer.diagnosis.fitting import COARSELY, Fitted, at_minimum
from multilayer.errors import MultilayerError
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.effects import Setting
from multilayer.experiments.two_plate.finite_elements import Fineness, FiniteRig, with_solids
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.fits.joint.fit import rigs_around, with_free_rim
from multilayer.fits.joint.search import search_laws
from multilayer.fits.settings import FitSettings
from multilayer.inference.problem import Minimum
from multilayer.rig.reduced import ReducedRig, Solid
from multilayer.rig.shape_factor import relative_shape_factor

COARSE = 1e-4  # relative change of the cost at which a first search has converged
_RESOLUTION, _TOLERANCE = 0.9, 1e-4  # of mesh and reduced basis
_ROOM = (0.98, 1.02)  # factors around the data's frequencies
_FEW = 2  # solutions of plane waves from which the search starts
# of elements for other samples: relative error of the basis; factors around the fitted moduli and loss factors
_MANY_TOLERANCE, _MODULI, _LOSSES = 1e-4, 2.0, 2.0
_TRAINED = (0.3, 0.6)  # relative error of Poisson's ratio and |ln(E_r/E_z)| that the basis is made for
# steps of these for the change of ln(motion) to second order, in rounds, each about the last one's fit
_STEPS = ((0.15, 0.3), (0.05, 0.1), *2 * ((0.015, 0.03),))
_NEAR = 0.5  # of a step: a fit as near to the centre is right to 0.1 % of the motion, at sharp resonances, too
_MOST_RATIO = 0.495  # Poisson's ratio


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
    """Return, by configuration, what makes finite elements that hold for several samples, moduli about those of a fit.

    A task returns None where no elements can be made, of a law far from any sample's.
    """
    pairs = stated_samples(fitted.hypothesis_as(CampaignProblem), fitted.minimum.z)
    return {name: partial(_made, *pair) for name, pair in pairs.items()}


def stated_samples(problem: CampaignProblem, z: RealArray) -> dict[str, tuple[FiniteRig, ComplexArray]]:
    """Return, by configuration, the finite elements of the stated sample, and its moduli at coordinates, Pa."""
    rigs = [(setting, problem.finite[setting.data.name]) for setting in problem.settings]
    return {s.data.name: (rig, problem.modulus(z, s.frequency)) for s, rig in rigs if isinstance(rig, FiniteRig)}


def fit_samples(fitted: Fitted, made: Mapping[str, FiniteRig | None]) -> Fitted:
    """Return a coarse fit with finite elements about the sample that explains the data best.

    Parameters
    ----------
    fitted : Fitted
        With `FiniteSize` among its effects, given ones or not, and the finite elements of the stated sample: those of
        others so far act by their static stiffness.
    made : mapping
        What the tasks of `elements_of_samples` return; with a None among it, the fit is returned as it is.
    """
    problem, z = fitted.hypothesis_as(CampaignProblem), np.array(fitted.minimum.z)
    rigs = {name: rig for name, rig in made.items() if rig is not None}
    if len(rigs) < len(made):
        return fitted
    z[_places(problem)] = 0.0
    for steps in _STEPS:
        centre = solid_of(problem, z)
        fitted = at_minimum(replace(problem, finite=about(problem, rigs, centre, steps)), z, *COARSELY)
        z = fitted.minimum.z
        if steps == _STEPS[-1] and np.all(np.abs(solid_of(problem, z) - centre) < _NEAR * np.array(steps)):
            break
    return fitted


def about(
    problem: CampaignProblem,
    made: Mapping[str, FiniteRig],
    centre: RealArray,
    steps: tuple[float, float] = _STEPS[0],
) -> dict[str, Rig]:
    """Return rigs whose samples are near a centre, with steps about it.

    Parameters
    ----------
    problem : CampaignProblem
    made : mapping
        By configuration, as `for_samples` returns them.
    centre : array, shape (2,)
        Error of Poisson's ratio and ln(E_r/E_z); the former is kept low enough for all steps to be solids.
    steps : (float, float)
    """
    return {s.data.name: _about(s, made[s.data.name], centre, steps) for s in problem.settings}


def solid_of(problem: CampaignProblem, z: RealArray) -> RealArray:
    """Return the error of Poisson's ratio and ln(E_r/E_z) at coordinates, shape (2,)."""
    error, radial = (float(problem.parameters[i].prior.value(z[i])) for i in _places(problem))
    return np.array([error, np.log(radial)])


def _places(problem: CampaignProblem) -> list[int]:
    """Return where the parameters of `FiniteSize` stand."""
    names = [parameter.name for parameter in problem.parameters]
    return [names.index(f"{FiniteSize.name}.{parameter.name}") for parameter in FiniteSize.parameters]


def _made(rig: FiniteRig, modulus: ComplexArray) -> FiniteRig | None:
    try:
        return for_samples(rig, modulus)
    except MultilayerError:
        return None


def for_samples(rig: FiniteRig, modulus: ComplexArray) -> FiniteRig:
    """Return a rig that holds for several samples, with moduli near those given.

    Raises
    ------
    MultilayerError
        Where no elements can be made, of moduli far from any sample's.
    """
    reduced, loss = rig.reduced, modulus.imag / modulus.real
    moduli = (float(modulus.real.min() / _MODULI), float(modulus.real.max() * _MODULI))
    losses = (float(loss.min() / _LOSSES), float(loss.max() * _LOSSES))
    ratio, (error, radial) = reduced.rig.poisson_ratio, _TRAINED
    solids: list[Solid] = [
        (min(ratio * (1 + error), _MOST_RATIO), 1.0),
        (ratio * (1 - error), 1.0),
        (ratio, float(np.exp(radial))),
        (ratio, float(np.exp(-radial))),
    ]
    ranges = replace(reduced.ranges, modulus=moduli, loss_factor=losses)
    return replace(rig, reduced=ReducedRig.of_solids(reduced.rig, ranges, solids, _MANY_TOLERANCE))


def _about(setting: Setting, rig: FiniteRig, centre: RealArray, steps: tuple[float, float]) -> FiniteRig:
    """Return a rig whose sample is near a centre, with steps about it; below the highest ratio with all of them."""
    stated = setting.campaign.specimen.poisson_ratio

    def stiffening(error: float, radial: float) -> float:
        return float(relative_shape_factor(stated, setting.shape, np.array(error), np.array(radial)))

    highest = _MOST_RATIO / stated - 1 - steps[0] if stated > 0 else np.inf
    return with_solids(rig, stiffening, (float(min(centre[0], highest)), float(centre[1])), steps)
