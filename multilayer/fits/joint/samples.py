"""Finite elements of samples near the stated one, for an effect that leaves its Poisson's ratio and stiffness open."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import MultilayerError
from multilayer.executors import run_all
from multilayer.experiments.two_plate.campaign import Acting, CampaignProblem
from multilayer.experiments.two_plate.effects import SOLID, Setting
from multilayer.experiments.two_plate.finite_elements import FiniteRig, with_solids
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.rig.reduced import ReducedRig, Solid
from multilayer.rig.shape_factor import relative_shape_factor

F = TypeVar("F")
# relative error of the basis; factors around the fitted moduli and loss factors
_TOLERANCE, _MODULI, _LOSSES = 1e-4, 2.0, 2.0
_TRAINED = (0.3, 0.6)  # relative error of Poisson's ratio and |ln(E_r/E_z)| that the basis is made for
# steps of these for the change of ln(motion) to second order, in rounds, each about the last one's fit
_STEPS = ((0.15, 0.3), (0.05, 0.1), *2 * ((0.015, 0.03),))
_NEAR = 0.5  # of a step: a fit as near to the centre is right to 0.1 % of the motion, at sharp resonances, too
_MOST_RATIO = 0.495  # Poisson's ratio


def leaves_sample_open(effects: Sequence[Acting]) -> bool:
    """Tell whether an effect leaves the sample's Poisson's ratio and stiffness along the radius open."""
    return _open(effects) is not None


def elements_of_samples(problem: CampaignProblem, z: RealArray) -> dict[str, Callable[[], FiniteRig | None]]:
    """Return, by configuration, what makes finite elements that hold for several samples, moduli about those at z.

    A task returns None where no elements can be made, of a law far from any sample's.
    """
    return {name: partial(_made, *pair) for name, pair in stated_samples(problem, z).items()}


def stated_samples(problem: CampaignProblem, z: RealArray) -> dict[str, tuple[FiniteRig, ComplexArray]]:
    """Return, by configuration, the finite elements of the stated sample, and its moduli at coordinates, Pa."""
    rigs = [(setting, problem.finite[setting.data.name]) for setting in problem.settings]
    return {s.data.name: (rig, problem.modulus(z, s.frequency)) for s, rig in rigs if isinstance(rig, FiniteRig)}


def fit_samples(
    problem: CampaignProblem,
    z: RealArray,
    made: Mapping[str, FiniteRig],
    solve: Callable[[CampaignProblem, RealArray], F],
    reached: Callable[[F], RealArray],
    executor: Executor | None = None,
) -> F:
    """Return a fit with finite elements about the sample that explains the data best.

    Parameters
    ----------
    problem : CampaignProblem
        With an effect that leaves the sample open, and the finite elements of the stated sample: others so far act by
        their static stiffness.
    z : array, shape (n,)
        Where it begins, but for what is stated of the laboratory.
    made : mapping
        By configuration, what the tasks of `elements_of_samples` return.
    solve : callable
        Gives the fit reached from a start.
    reached : callable
        Gives the coordinates of that.
    executor : Executor, optional
        Where the partial fractions of all samples are made; in this process when left out.
    """
    z = np.array(z)
    z[_places(problem)] = 0.0
    # with the stated sample these were bent to make up for the true one
    z[len(problem.law_parameters) : len(problem.nominal_parameters)] = 0.0
    for steps in _STEPS:
        centre = solid_of(problem, z)
        rigs = about(problem, made, centre, steps)
        found = solve(replace(problem, finite=_expanded(problem, rigs, z, executor)), z)
        z = reached(found)
        if steps == _STEPS[-1] and np.all(np.abs(solid_of(problem, z) - centre) < _NEAR * np.array(steps)):
            break
    return found


def _expanded(
    problem: CampaignProblem, rigs: Mapping[str, Rig], z: RealArray, executor: Executor | None
) -> dict[str, Rig]:
    """Return rigs that know their partial fractions at the data's frequencies, as the first derivative makes them."""
    tasks = [(replace(problem.with_data([data]), finite={data.name: rigs[data.name]}), z) for data in problem.data]
    expanded = run_all(_differentiated, tasks, executor)
    return {data.name: rig for data, rig in zip(problem.data, expanded, strict=True)}


def _differentiated(task: tuple[CampaignProblem, RealArray]) -> Rig:
    problem, z = task
    problem.linearised(z)
    (rig,) = problem.finite.values()
    return rig


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


def _open(effects: Sequence[Acting]) -> Acting | None:
    rims = (effect for effect in effects if effect.needs_finite_elements)
    return next((rim for rim in rims if set(SOLID) <= {parameter.name for parameter in rim.parameters}), None)


def _places(problem: CampaignProblem) -> list[int]:
    """Return where the unknowns of the sample stand."""
    effect, names = _open((*problem.given, *problem.effects)), [parameter.name for parameter in problem.parameters]
    assert effect is not None, "of a problem with other samples"
    return [names.index(f"{effect.name}.{name}") for name in SOLID]


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
    return replace(rig, reduced=ReducedRig.of_solids(reduced.rig, ranges, solids, _TOLERANCE))


def _about(setting: Setting, rig: FiniteRig, centre: RealArray, steps: tuple[float, float]) -> FiniteRig:
    """Return a rig whose sample is near a centre, with steps about it; below the highest ratio with all of them."""
    stated = setting.campaign.specimen.poisson_ratio

    def stiffening(error: float, radial: float) -> float:
        return float(relative_shape_factor(stated, setting.shape, np.array(error), np.array(radial)))

    highest = _MOST_RATIO / stated - 1 - steps[0] if stated > 0 else np.inf
    return with_solids(rig, stiffening, (float(min(centre[0], highest)), float(centre[1])), steps)
