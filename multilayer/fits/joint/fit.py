"""Fitting one modulus law to a whole campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar
from warnings import warn

import numpy as np

from multilayer.arrays import RealArray
from multilayer.errors import InputError, MultilayerError, PlausibilityWarning, suggest
from multilayer.experiments.hypothesis import parameters_of
from multilayer.experiments.two_plate.burst import BurstData, BurstProblem
from multilayer.experiments.two_plate.campaign import Acting, CampaignProblem
from multilayer.experiments.two_plate.finite_elements import REACH, Fineness, FiniteRig, ModulusRange, finite_rigs
from multilayer.experiments.two_plate.nuisances import with_usual_uncertainty
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.ratios import bursts_left_out, configuration_data
from multilayer.fits.burst.acceptance import Criteria
from multilayer.fits.burst.fit import burst_problems
from multilayer.fits.joint.laws import AUTO, LAWS_COMPARED, Candidate, LawMixture, with_deviations
from multilayer.fits.joint.posterior import with_posterior
from multilayer.fits.joint.result import JointFit
from multilayer.fits.joint.samples import elements_of_samples, fit_samples, leaves_sample_open
from multilayer.fits.joint.search import (
    N_BEST,
    N_FOLLOWED,
    first_guess,
    law_space,
    refuse_none,
    settle_all,
    solve_from_bursts,
    solve_joint,
    with_record_ends,
)
from multilayer.fits.methods import JOINT, CampaignMethod, Compared, Progress
from multilayer.fits.settings import DEFAULT_LAW, FitSettings
from multilayer.inference.least_squares import distinct, is_competitive, minimise
from multilayer.inference.problem import Minimum
from multilayer.inference.summary import LAPLACE, refuse_unusable
from multilayer.log import logged
from multilayer.measurements.description import Campaign
from multilayer.media.laws import LAWS
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

if TYPE_CHECKING:
    from multilayer.fits.sources import FitJob

Solved = tuple[str, CampaignProblem, list[Minimum]]
_MOST_REMADE = 4
_MOST_CUT = 3


def fit_joint(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    law: str = DEFAULT_LAW,
    *,
    elements: int | None = None,
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
    given: Sequence[Acting] = (),
    seed: int = 0,
    progress: Progress | None = None,
) -> JointFit:
    """Find the modulus law of a campaign's specimen from all bursts at once.

    Parameters
    ----------
    campaign : Campaign
    recordings : mapping
        Signals by (configuration name, frequency).
    law : str
        Name of a registered modulus law, or ``auto``: the most probable of `LAWS_COMPARED`.
    elements : int, optional
        Of laws with lists of branches.
    settings : FitSettings, optional
        Its `model`, `termination`, `ambient`, `pores` and `sensor_mass` count here.
    calibration : Calibration, optional
    given : sequence of Effect
        Unmodelled effects that act besides, whose parameters are fitted with the law's. With one that needs finite
        elements, the model of `settings` must be finite.
    seed : int
        Of the points where the search starts.
    progress : callable, optional
        Called with a short text after every step.

    Raises
    ------
    InputError
        For unknown laws, or records that end before the ring-down.

    Notes
    -----
    Data are the ratios of the spectra of top and base in the main lobe of every burst; their covariance holds the noise
    of both channels and the model's own error. What the laboratory states of itself are unknowns with normal priors;
    where it states nothing at all they are as usual of a careful laboratory, with a warning.
    """
    settings = settings or FitSettings()
    tell = logged(progress)
    nothing_stated = not campaign.uncertainty.model_fields_set
    campaign, warnings = with_usual_uncertainty(campaign) if nothing_stated else (campaign, [])
    problems = burst_problems(campaign, recordings, settings, calibration)
    rims = tuple(effect for effect in given if effect.needs_finite_elements)
    others = tuple(effect for effect in given if effect not in rims)
    if rims and settings.model != "finite":
        raise InputError(f"given: '{rims[0].name}' needs finite elements; fit with model: finite")
    solved: list[Solved] = []
    for name, branches in _laws(law, elements):
        problem = replace(plane_wave_problem(campaign, problems, name, branches), given=others)
        label = name if branches is None else f"{name}, {branches} branches"
        solved.append((label, problem, solve_from_bursts(problem, seed=seed, tell=tell)))
    if settings.model == "finite":
        solved = _all_with_free_rim(campaign, solved, tell, settings, rims)
    solved = cut_where_records_end(solved, [problem.data for problem in problems])
    best_minima = [part[2][0] for part in solved]
    candidates = []
    for part in solved:  # what no departure of a few per cent can save is told all the same
        candidates += with_deviations(*part) if is_competitive(part[2][0], best_minima) else [Candidate(*part)]
    best = LawMixture(candidates).best
    result = JointFit(
        name=campaign.folder.resolve().name,
        method=JOINT,
        settings=settings.model_dump(mode="json", exclude_none=True) | {"joint": True, "law": law},
        law=best.problem.space.law(best.problem.law_coordinates(best.minima[0].z)),
        problem=best.problem,
        minima=list(best.minima),
        criteria=Criteria(
            settings.acceptance.time_of_flight or 1 / campaign.sampling_rate, settings.acceptance.level_db
        ),
        candidates=tuple(candidates),
        warnings=[*warnings, *bursts_left_out(campaign, best.problem.data)],
    )
    return replace(result, bursts=result.at_bursts())


def _laws(law: str, elements: int | None) -> tuple[tuple[str, int | None], ...]:
    if law != AUTO:
        return ((law, elements),)
    if elements is not None:
        raise InputError("--elements: --law auto compares several numbers of them; name a law, or leave it out")
    return LAWS_COMPARED


def cut_where_records_end(solved: list[Solved], bursts: Sequence[BurstData]) -> list[Solved]:
    """Return laws solved with the model cut where the records end, if that matters; hopeless ones as they are.

    Parameters
    ----------
    solved : list of (str, CampaignProblem, list of Minimum)
        Labels, problems, and their solutions, the best first.
    bursts : sequence of BurstData
        All of the campaign.
    """
    for _ in range(_MOST_CUT):
        _, problem, minima = max(solved, key=lambda part: part[2][0].log_evidence)
        cut = with_record_ends(problem, minima[0], bursts)
        if [set(data.ends) for data in cut.data] == [set(data.ends) for data in problem.data]:
            break
        done: list[Solved] = []
        for label, other, found in solved:
            if not is_competitive(found[0], minima):
                done.append((label, other, found))
                continue
            same = replace(other, configurations=cut.data, end_effect=None)
            starts = [m.z for m in found[:N_FOLLOWED] if is_competitive(m, found)]
            done.append((label, *settle_all(same, starts)))
        solved = done
    return solved


def _all_with_free_rim(
    campaign: Campaign, solved: list[Solved], tell: Progress, settings: FitSettings, rims: tuple[Acting, ...]
) -> list[Solved]:
    """Return laws solved with finite elements, made for the most probable law, and for all that fit nearly as well.

    The rim changes the modulus that a law shows, hardly which law it is. `rims` are the given effects that need finite
    elements.
    """
    solved = sorted(solved, key=lambda part: -max(minimum.log_evidence for minimum in part[2]))
    (label, plane_waves, minima), *others = solved
    problem, found = with_free_rim(campaign, plane_waves, minima, tell, settings)
    if rims:
        problem, found = _with_rims(problem, found, rims, tell)
    done: list[Solved] = [(label, problem, found)]
    for other, flat, starts in others:
        if is_competitive(starts[0], minima):
            bent = replace(flat, rigs=problem.rigs, finite=problem.finite, given=problem.given)
            n = len(flat.law_parameters)
            done.append((other, bent, solve_joint(bent, [m.z[:n] for m in starts], n_best=N_FOLLOWED, tell=tell)))
    return done


def _with_rims(
    problem: CampaignProblem, minima: Sequence[Minimum], rims: tuple[Acting, ...], tell: Progress
) -> tuple[CampaignProblem, list[Minimum]]:
    """Return a problem with a free rim and its solutions, with given effects that need finite elements.

    Of a sample whose Poisson's ratio and stiffness along the radius are unknown, with elements about the one that
    explains the data best.
    """
    problem = replace(problem, finite=problem.rigs, given=(*problem.given, *rims))
    n, starts = len(parameters_of(rims)), [minimum.z for minimum in minima if is_competitive(minimum, minima)]
    sizes = np.zeros(n)
    if leaves_sample_open(rims):
        begun, made = minimise(problem, np.concatenate([starts[0], sizes])), {}
        for name, task in elements_of_samples(problem, begun.z).items():
            if (rig := task()) is None:
                raise MultilayerError(f"{name}: there are no finite elements of other samples with moduli like these")
            made[name] = rig
            tell(f"{name}: finite elements of other samples")
        problem, nearest = fit_samples(problem, begun.z, made, _solved, lambda solved: solved[1].z)
        sizes = nearest.z[-n:]
        tell("sample")
    found = distinct([minimise(problem, np.concatenate([start, sizes])) for start in starts])
    refuse_none(problem, found)
    return problem, found


def _solved(problem: CampaignProblem, start: RealArray) -> tuple[CampaignProblem, Minimum]:
    return problem, minimise(problem, start)


def number_of_steps(campaign: Campaign, settings: FitSettings, law: str = "", given: Sequence[Acting] = ()) -> int:
    """Return how often `fit_joint` reports progress, if the finite elements need to be made once only."""
    laws = len(LAWS_COMPARED) if law == AUTO else 1
    plane_wave, count = N_BEST * laws, len(campaign.configurations)
    if settings.model == "plane_wave":
        return plane_wave
    of_samples = count + 1 if leaves_sample_open(given) else 0
    return plane_wave + count + 2 * N_FOLLOWED * laws + of_samples


@dataclass(frozen=True)
class Joint(CampaignMethod):
    """One modulus law for all bursts of a campaign.

    Attributes
    ----------
    law : str
        Name of a registered modulus law, or ``auto``.
    elements : int, optional
        Of laws with lists of branches.
    posterior : {'laplace', 'profile', 'nested'}
        How intervals are found.
    given : tuple of Effect
        Unmodelled effects that act besides.
    """

    name = JOINT
    title = "one modulus law for all bursts"
    summary = "the parameters of a modulus law from all bursts and configurations at once, with a posterior"
    gives = JointFit
    of_settings: ClassVar[tuple[str, ...]] = ("model",)
    suffix = "-joint"

    law: str = DEFAULT_LAW
    elements: int | None = None
    posterior: str = LAPLACE
    given: tuple[Acting, ...] = ()

    def __post_init__(self) -> None:
        refuse_unusable(self.posterior)
        if self.law != AUTO and self.law not in LAWS:
            raise InputError(f"--law: there is no law '{self.law}'; {suggest(self.law, [AUTO, *LAWS.names()])}")

    def number_of_steps(self, job: FitJob) -> int:
        """Return how often `run` reports progress."""
        return number_of_steps(job.campaign, job.settings, self.law, self.given)

    def run(self, job: FitJob, tell: Progress) -> JointFit:
        """Return the law, with intervals of its parameters.

        Warns
        -----
        PlausibilityWarning
            Where the moduli leave the bounds of the settings, within which bursts are fitted one by one.
        """
        fit = fit_joint(
            job.campaign, job.recordings, self.law, elements=self.elements, settings=job.settings,
            calibration=job.calibration, given=self.given, progress=tell,
        )  # fmt: skip
        for name, unit in (("storage_modulus", " Pa"), ("loss_factor", "")):
            low, high = getattr(job.settings.bounds, name)
            values = [getattr(burst, name) for burst in fit.bursts]
            if min(values) < low or max(values) > high:
                text = f"bounds: {name} of the law runs from {min(values):.3g} to {max(values):.3g}{unit}, out of the "
                text += f"bounds {low:g} to {high:g}{unit}; they limit fits burst by burst, not those of one law"
                warn(text, PlausibilityWarning, stacklevel=2)
        return with_posterior(fit, self.posterior, tell)

    def compared(self, job: FitJob) -> Mapping[str, Compared]:
        """Return nothing: no burst has a modulus of its own."""
        return {}


def plane_wave_problem(
    campaign: Campaign, problems: list[BurstProblem], law: str, elements: int | None
) -> CampaignProblem:
    """Return the joint problem of the bursts with plane-wave rigs."""
    data = configuration_data(campaign, [problem.data for problem in problems])
    rigs: dict[str, Rig] = {problem.data.configuration: problem.rig for problem in problems}
    space = law_space(law, *first_guess(data, rigs), elements=elements)
    return CampaignProblem(campaign, data, rigs, space, campaign.uncertainty)


def with_free_rim(
    campaign: Campaign,
    problem: CampaignProblem,
    minima: list[Minimum],
    tell: Progress,
    settings: FitSettings,
    fineness: Fineness | None = None,
    solve: Callable[[CampaignProblem, Sequence[RealArray]], list[Minimum]] | None = None,
) -> tuple[CampaignProblem, list[Minimum]]:
    """Return problem and solutions with finite elements, made anew where the solution leaves their range.

    Parameters
    ----------
    campaign, problem, minima, settings
        The problem of plane waves, and its solutions.
    tell : callable
        Called with a short text after every step.
    fineness : Fineness, optional
    solve : callable, optional
        Gives the minima of a problem from points of laws, the best first; `solve_joint` when left out.
    """
    n = len(problem.law_parameters)
    for _ in range(_MOST_REMADE):
        rigs = rigs_around(campaign, problem, minima[0], tell, settings, fineness)
        problem = replace(problem, rigs=rigs)
        starts = [minimum.z[:n] for minimum in minima]
        minima = (solve or partial(solve_joint, n_best=N_FOLLOWED, tell=tell))(problem, starts)
        law = problem.law_coordinates(minima[0].z)
        if all(rigs[data.name].holds(problem.space.modulus(law, data.frequency)) for data in problem.data):
            return problem, minima
    raise MultilayerError("the finite elements' range of moduli does not settle; fit with --model plane_wave first")


def rigs_around(
    campaign: Campaign,
    problem: CampaignProblem,
    found: Minimum,
    tell: Progress,
    settings: FitSettings | None = None,
    fineness: Fineness | None = None,
) -> dict[str, FiniteRig]:
    """Return reduced finite-element rigs around a law."""
    ranges, air = {}, settings is not None and settings.pores is not None
    for data in problem.data:
        low, high = float(REACH[0] * data.centres.min()), float(REACH[1] * data.centres.max())
        e = problem.space.modulus(problem.law_coordinates(found.z), np.geomspace(low, high, 9))
        points = [np.array([np.log(m.real), m.imag / m.real]) for m in e]
        ranges[data.name] = ModulusRange.around(points, campaign.specimen.poisson_ratio, 2.0, air=air)
    rigs = finite_rigs(campaign, ranges, tell, settings, fineness)
    return {name: replace(rig, extrapolate=True) for name, rig in rigs.items()}
