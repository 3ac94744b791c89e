"""Where the solutions of a joint fit are: laws first, then laws with what is uncertain of the rig."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.chi2 import exceeded
from multilayer.errors import InputError
from multilayer.executors import run_all
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.campaign import CampaignProblem, Material, RigExperiment
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.ratios import ConfigurationData
from multilayer.experiments.two_plate.record_end import RecordEnd, period_of, rings_at_end
from multilayer.inference.least_squares import TIGHT, distinct, is_competitive, minimise, search
from multilayer.inference.multistart import lowest_on_grid, valleys
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum, Points, Problem
from multilayer.measurements.description import Uncertainty
from multilayer.media.laws.parameters import LawSpace
from multilayer.media.laws.template import law_template

_COARSE = 0.02  # model error while only the law is sought: minima are wide then, and what nuisances explain is forgiven
Tell = Callable[[str], None]
N_BEST, N_FOLLOWED = 6, 3
_IMPROBABLE = 0.01
_SETTLED = 0.3  # of whitened residuals: less moves chi-square by a tenth
_MOST_SETTLED = 4
_FEW = 60  # evaluations after which a start of the coarse search must be near the best
_GRID = np.geomspace(1e3, 1e9, 139)[:, None] * (1 + 1j * np.array([0.02, 0.05, 0.1, 0.2, 0.4, 0.8]))  # Pa
_PER_BURST, _OF_BURSTS = 6, 3  # moduli that are looked into, and laws through them that are followed at most
_ALIKE = 0.3  # of ln abs(E): moduli nearer than this lead to one law
_NEAR, _ROUGHLY = 0.03, 1e-2  # of ln E: how near a law comes to a modulus; and tolerance of the search for it


def first_guess(data: Sequence[ConfigurationData], rigs: Mapping[str, Rig]) -> tuple[RealArray, ComplexArray]:
    """Return the constant modulus that fits each configuration best: the data's frequencies, Hz, and moduli, Pa.

    Where to look for a law: a coarse search over (E1, loss factor).
    """
    best: list[ComplexArray] = []
    for measured in data:
        misfit = np.sum(_misfits(measured, rigs[measured.name]), axis=-1)
        best.append(np.full(measured.frequency.shape, complex(_GRID.flat[int(np.argmin(misfit))])))
    return np.concatenate([measured.frequency for measured in data]), np.concatenate(best)


def _misfits(measured: ConfigurationData, rig: Rig) -> RealArray:
    """Return relative misfits of the moduli of `_GRID` at each bin, squared, shape (n_moduli, n_losses, n)."""
    f, ratio = measured.frequency, measured.ratio
    modelled = rig.transmissibility(f, _GRID.reshape(-1, 1) + 0 * f)
    misfit = np.abs(modelled - ratio) ** 2 / (np.abs(ratio) + np.abs(modelled)) ** 2
    return np.where(np.isnan(misfit), np.inf, misfit).reshape(*_GRID.shape, -1)


def laws_of_bursts(problem: CampaignProblem) -> list[RealArray]:
    """Return coordinates of laws, shape (n_law,) each, near which all data are explained roughly, the best first.

    A sample may hold a wavelength more or less, and few laws of a wide prior are near the right one. Of a single burst
    a grid has every modulus that explains it: from laws through these the search for valleys begins.
    """
    n = len(problem.law_parameters)
    bases = [_law_through(problem.material, f, modulus) for f, modulus in _moduli_of_bursts(problem)]
    points = np.array([np.concatenate([z, np.zeros(len(problem.given_parameters))]) for z in bases])
    return [z[:n] for z in valleys(_law_only(problem), points, np.zeros((1, 0)))[:_OF_BURSTS]]


def _moduli_of_bursts(problem: CampaignProblem) -> list[tuple[float, complex]]:
    """Return frequencies (Hz) and moduli (Pa) at which single bursts are explained best nearby, those alike once."""
    found = []
    for measured in problem.data:
        misfits = _misfits(measured, problem.rigs[measured.name])
        for index, f in enumerate(measured.centres.tolist()):
            of_burst = np.mean(misfits[..., measured.burst == index], axis=-1)
            axes = (np.arange(count, dtype=float) for count in _GRID.shape)
            lowest = [tuple(place.astype(int)) for place in lowest_on_grid(of_burst, tuple(axes), _PER_BURST)]
            found += [(float(of_burst[place]), f, complex(_GRID[place])) for place in lowest]
    kept: list[tuple[float, complex]] = []
    for _, f, modulus in sorted(found, key=lambda each: each[0]):
        if all(abs(np.log(abs(modulus / other))) > _ALIKE for _, other in kept):
            kept.append((f, modulus))
    return kept


@dataclass(frozen=True)
class _AtModulus(Problem):
    """Which laws have a modulus, Pa, at a frequency, Hz."""

    material: Material
    frequency: float
    modulus: complex

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        return self.material.law_parameters

    def residual(self, z: RealArray) -> RealArray:
        off = np.log(self.material.modulus(z, np.array([self.frequency])) / self.modulus) / _NEAR
        return np.concatenate([off.real, off.imag], axis=-1)


def _law_through(material: Material, frequency: float, modulus: complex) -> RealArray:
    """Return coordinates of the law nearest to the middle of its space that has a modulus, Pa, at a frequency, Hz."""
    return minimise(
        _AtModulus(material, frequency, modulus), np.zeros(len(material.law_parameters)), tolerance=_ROUGHLY
    ).z


def solve_from_bursts(
    problem: CampaignProblem,
    *,
    seed: int = 0,
    tolerance: float = TIGHT,
    tell: Tell | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima of `solve_joint`, laws through single bursts in place of some drawn from the prior."""
    starts = laws_of_bursts(problem)
    n_best = N_BEST - len(starts)
    return solve_joint(problem, starts, n_best=n_best, seed=seed, tolerance=tolerance, tell=tell, executor=executor)


def solve_joint(
    problem: CampaignProblem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = N_BEST,
    n_followed: int = N_FOLLOWED,
    seed: int = 0,
    tolerance: float = TIGHT,
    tell: Tell | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima of a joint problem, the most probable first.

    The law alone is sought first, from many starts; its best minima are then followed with the nuisances, but for those
    that fit far worse than the best.

    Parameters
    ----------
    problem : CampaignProblem
    starts : sequence of array, shape (n_law,)
        Coordinates of laws to follow besides the `n_best` drawn from the prior.
    n_best, n_followed : int
        How many are followed for the law alone, and with the nuisances.
    seed : int
    tolerance : float
        Relative change of the cost at which a descent has arrived.
    tell : callable, optional
        Called with a short text after each start.
    executor : Executor, optional
        Where the starts are followed; in this process when left out.

    Raises
    ------
    InputError
        Where the rig has no response.
    """
    coarse = search_laws(problem, starts, n_best=n_best, seed=seed, tolerance=tolerance, tell=tell, executor=executor)
    followed = [m.z for m in coarse[:n_followed] if is_competitive(m, coarse)]
    descents = run_all(partial(_descents, problem, tolerance), followed, executor)
    minima = distinct([found for ends in descents for found in ends])
    refuse_none(problem, minima)
    return minima


def refuse_none(problem: CampaignProblem, minima: Sequence[Minimum]) -> None:
    """Refuse a problem that has no minima, as its rig has no response wherever it was asked for.

    Raises
    ------
    InputError
    """
    if minima:
        return
    given = ", ".join(effect.name for effect in problem.given)
    text = "the rig has no response (NaN or infinite) with any modulus that was tried"
    raise InputError(f"{text}; leave out what is given ({given}), or check it" if given else f"{text}; check its sizes")


def search_laws(
    problem: CampaignProblem,
    starts: Sequence[RealArray] = (),
    *,
    n_best: int = N_BEST,
    seed: int = 0,
    tolerance: float = TIGHT,
    tell: Tell | None = None,
    executor: Executor | None = None,
) -> list[Minimum]:
    """Return the distinct minima with a large model error and what is uncertain of the rig as stated, for a start.

    Effects that are given move with the law.

    Parameters, and what it raises, as of `solve_joint`; coordinates are those of the problem.
    """
    law_only = _law_only(problem)
    n, given = len(problem.modulus_parameters), np.zeros(len(problem.given_parameters))
    begin = [np.concatenate([start, given]) for start in starts]
    found = search(
        law_only, begin, n_best=n_best, seed=seed, few=_FEW, tolerance=tolerance, tell=tell, executor=executor
    )
    refuse_none(problem, found)
    rest = np.zeros(len(problem.nuisances.parameters))
    return [replace(minimum, z=np.concatenate([minimum.z[:n], rest, minimum.z[n:]])) for minimum in found]


def _law_only(problem: CampaignProblem) -> CampaignProblem:
    """Return a problem with what is uncertain of the rig as stated, and a large model error."""
    return replace(problem, known=Uncertainty(), model_error=_coarse(problem))


def _coarse(problem: CampaignProblem) -> float:
    return max(problem.model_error, _COARSE)


def _descents(problem: CampaignProblem, tolerance: float, start: RealArray) -> list[Minimum]:
    """Return where least squares end from a start, and if chance does not explain that, by way of a coarse model error.

    Where resonances are sharp, thickness and density must move before the law can: with a large model error they can.
    """
    direct = minimise(problem, start, tolerance=tolerance)
    if direct.converged and direct.cost < exceeded(_IMPROBABLE, direct.residual.size):
        return [direct]
    eased = minimise(replace(problem, model_error=_coarse(problem)), start, tolerance=tolerance)
    return [direct, minimise(problem, eased.z, tolerance=tolerance)]


def settle(problem: CampaignProblem, start: RealArray, tolerance: float = TIGHT) -> tuple[CampaignProblem, Minimum]:
    """Return the minimum reached from a start, and the problem with the ends of its records as they act there."""
    if not any(data.ends for data in problem.data):
        return problem, minimise(problem, start, tolerance=tolerance)
    effect = problem.end_effect_at(start)
    if not effect.is_finite:  # no ring-down of that law ends: it is not the sample's, and stays as it is
        return problem.without_ends(), minimise(problem.without_ends(), start, tolerance=tolerance)
    for _ in range(_MOST_SETTLED):
        near = replace(problem, end_effect=effect)
        minimum = minimise(near, start, tolerance=tolerance)
        there = problem.end_effect_at(minimum.z)
        if not there.is_finite:
            return near, minimum
        apart = [
            experiment.whiten(there.change[experiment.data.name] - effect.at(experiment.data.name, minimum.z))
            for experiment in problem.experiments
            if experiment.data.ends
        ]
        start, effect = minimum.z, there
        if np.linalg.norm(np.concatenate(apart)) < _SETTLED:
            break
    near = replace(problem, end_effect=effect)
    return near, minimise(near, start, tolerance=tolerance)


def settle_all(problem: CampaignProblem, starts: Sequence[RealArray]) -> tuple[CampaignProblem, list[Minimum]]:
    """Return the distinct minima reached from starts, the best first, and the problem as it settles at that."""
    ends = [settle(problem, start) for start in starts]
    near, best = min(ends, key=lambda end: end[1].cost)
    return near, distinct([best, *(minimum for _, minimum in ends)]) or [best]


def with_record_ends(problem: CampaignProblem, found: Minimum, bursts: Sequence[BurstData]) -> CampaignProblem:
    """Return a problem whose model is cut where records end, wherever that changes what a solution shows.

    Of rigs in closed form: finite elements would have to be solved at thousands of frequencies.

    Parameters
    ----------
    problem : CampaignProblem
    found : Minimum
        Says how long the ring-down lasts.
    bursts : sequence of BurstData
        All of the campaign.
    """
    points = problem.points(found.z)
    changed = []
    for experiment in problem.experiments:
        data, ends = experiment.data, dict(experiment.data.ends)
        rig = problem.rigs[data.name]

        for burst in bursts:
            at = np.flatnonzero(data.centres == burst.frequency)
            of_this = burst.configuration == data.name and at.size > 0 and rig.takes_arrays
            if not of_this or int(at[0]) in ends or not rings_at_end(burst):
                continue
            bins, variance = (values[data.burst == at[0]] for values in (data.frequency, data.variance))
            motion = partial(_motion_of, experiment, points, int(at[0]))
            end = RecordEnd.of(burst, bins, rig.reach, period_of(burst, motion, rig.reach))
            share = end.missing(motion(end.frequency)) / motion(bins)
            if np.linalg.norm(np.abs(share) / np.sqrt(variance + problem.model_error**2)) > _SETTLED:
                ends[int(at[0])] = end
        changed.append(replace(data, ends=dict(sorted(ends.items()))))
    return replace(problem, configurations=changed, end_effect=None)


def _motion_of(experiment: RigExperiment, points: Points, burst: int, frequency: RealArray) -> ComplexArray:
    """Return top over base at the first of some points, at frequencies of one burst, shape (n,)."""
    return np.asarray(np.exp(experiment.log_motion(points, frequency, np.full(len(frequency), burst))[0]))


def law_space(law: str, frequency: ArrayLike, modulus: ArrayLike, elements: int | None = None) -> LawSpace:
    """Return the space of a law around a guess of its moduli."""
    f, e = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
    return LawSpace.of(law_template(law, elements, f), {}, {}, f, e)
