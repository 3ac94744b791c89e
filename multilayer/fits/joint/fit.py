"""Fitting one modulus law to a whole campaign, and what comes of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.chi2 import exceeding
from multilayer.csv_table import csv_table
from multilayer.errors import InputError, MultilayerError
from multilayer.experiments.two_plate.burst import BurstData, BurstProblem
from multilayer.experiments.two_plate.campaign import CampaignProblem
from multilayer.experiments.two_plate.finite_elements import REACH, Fineness, FiniteRig, ModulusRange, finite_rigs
from multilayer.experiments.two_plate.plane_waves import Rig
from multilayer.experiments.two_plate.ratios import configuration_data
from multilayer.fits.burst.acceptance import Criteria
from multilayer.fits.burst.fit import burst_problems
from multilayer.fits.burst.result import CSV_COLUMNS, modulus_frame
from multilayer.fits.joint.laws import AUTO, LAWS_COMPARED, Candidate, LawMixture, with_deviations
from multilayer.fits.joint.search import (
    N_BEST,
    N_FOLLOWED,
    first_guess,
    law_space,
    settle,
    solve_joint,
    with_record_ends,
)
from multilayer.fits.settings import FitSettings
from multilayer.frames import Frame, Tabular
from multilayer.inference.derivative import central
from multilayer.inference.least_squares import distinct, is_competitive
from multilayer.inference.priors import Parameter
from multilayer.inference.problem import Minimum
from multilayer.inference.pulls import Pull, largest_pulls, nuisance_p_value
from multilayer.inference.summary import PosteriorSummary
from multilayer.measurements.description import Campaign
from multilayer.media.laws import ModulusLaw
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

JOINT = "joint"
Progress = Callable[[str], None]
Solved = tuple[str, CampaignProblem, list[Minimum]]
_SIGNIFICANT = 0.01
_DECIDED = 0.9  # of the probability
_WORTH_TELLING = 0.01
_MOST_REMADE = 4
_MOST_CUT = 3


@dataclass(frozen=True, repr=False)
class JointFit(Tabular):
    """One law for all bursts of a campaign.

    Attributes
    ----------
    campaign : str
    settings : dict
    law : ModulusLaw
        The most probable one.
    problem : CampaignProblem
    minima : list of Minimum
        The distinct solutions, the most probable first.
    criteria : Criteria
        Of eq. (10), for `accepted`.
    summary : PosteriorSummary, optional
        Intervals, and what the data determine; see `joint_posterior.with_posterior`.
    candidates : tuple of Candidate
        The laws compared, with deviations of all sizes; moduli are means over them. The law by itself when empty.
    """

    campaign: str
    settings: dict[str, Any]
    law: ModulusLaw
    problem: CampaignProblem = field(repr=False)
    minima: list[Minimum] = field(repr=False)
    criteria: Criteria
    summary: PosteriorSummary | None = field(default=None, repr=False)
    candidates: tuple[Candidate, ...] = field(default=(), repr=False)

    @cached_property
    def laws(self) -> LawMixture:
        """The laws compared, by their evidence."""
        return LawMixture(self.candidates or (Candidate(self.law.law, self.problem, self.minima),))

    @property
    def frame(self) -> Frame:
        """The columns of ``moduli.csv`` at the frequencies of the bursts."""
        facts = {"campaign": self.campaign, "law": self.law.law, "p_value": self.p_value}
        return modulus_frame([tuple(row.values()) for row in self.rows()], facts)

    @property
    def best(self) -> Minimum:
        """The most probable solution."""
        return self.minima[0]

    @property
    def n_data(self) -> int:
        """Number of real data."""
        return len(self.best.residual)

    @property
    def p_value(self) -> float:
        """Probability of a misfit as large as this if law, rig and stated uncertainties are right."""
        return exceeding(self.best.cost, self.n_data)

    def moduli(self, frequency: RealArray) -> tuple[ComplexArray, RealArray]:
        """Return E1 + i E2 at frequencies (n,), Hz, and the covariance of (E1, E2), shape (n, 2, 2), Pa.

        Mean and covariance over the laws compared and over deviations from them, by their evidence.
        """
        return self.laws.moments(np.asarray(frequency, dtype=float))

    @property
    def parameters(self) -> dict[str, tuple[float, float]]:
        """Value and standard deviation of the law's parameters (SI), and of the nuisances, by name."""
        space, n = self.problem.space, len(self.problem.law_parameters)
        z, covariance = self.best.z, self.best.covariance
        logs, slopes = central(lambda points: space.logs(self.problem.law_coordinates(points)), z)
        spread = np.sqrt(np.einsum("ki,ij,kj->k", slopes, covariance, slopes))
        found = {name: (float(v), float(v * s)) for name, v, s in zip(space.names, np.exp(logs), spread, strict=True)}
        for i, parameter in enumerate(self.problem.nuisances.parameters, start=n):
            size = parameter.prior.normal[1] if parameter.prior.normal else 1.0
            found[parameter.name] = (size * float(z[i]), size * float(np.sqrt(covariance[i, i])))
        return found

    def discrepancies(self) -> dict[str, tuple[RealArray, RealArray, RealArray]]:
        """Return frequency (Hz), time of flight (s) and level (dB), measured minus modelled, by configuration."""
        logs = self.problem.differences(self.best.z)
        return {
            data.name: (
                data.frequency,
                difference.imag / (2 * np.pi * data.frequency),
                -20 / np.log(10) * difference.real,
            )
            for data, difference in zip(self.problem.data, logs, strict=True)
        }

    def rows(self) -> list[dict[str, Any]]:
        """Return the rows of ``moduli.csv``: one per frequency of the campaign, configuration ``joint``.

        Differences are the largest among the configurations, each a mean over its burst.
        """
        at = sorted({float(f) for data in self.problem.data for f in data.centres})
        moduli, covariance = self.moduli(np.array(at))
        delays, levels = self._worst()
        found = []
        for f, e, c in zip(at, moduli, covariance, strict=True):
            slope = np.array([-e.imag / e.real**2, 1 / e.real])
            values = (
                JOINT, f, e.real, c[0, 0] ** 0.5, e.imag, c[1, 1] ** 0.5, e.imag / e.real, (slope @ c @ slope) ** 0.5,
                delays[f], levels[f], not self.criteria.reason(delays[f], levels[f]),
            )  # fmt: skip
            found.append(
                {k: float(v) if isinstance(v, np.floating) else v for k, v in zip(CSV_COLUMNS, values, strict=True)}
            )
        return found

    def _worst(self) -> tuple[dict[float, float], dict[float, float]]:
        delays: dict[float, float] = {}
        levels: dict[float, float] = {}
        found = self.discrepancies()
        for data in self.problem.data:
            _, delay, level = found[data.name]
            for index, f in enumerate(data.centres):
                own = data.burst == index
                for worst, values in ((delays, delay), (levels, level)):
                    mean = float(np.mean(values[own]))
                    worst[float(f)] = max(worst.get(float(f), 0.0), mean, key=abs)
        return delays, levels

    @property
    def explained(self) -> bool:
        """Whether chance explains the misfit, whatever becomes of what is stated."""
        return self.p_value > _SIGNIFICANT

    @cached_property
    def _statements(self) -> tuple[tuple[Parameter, ...], RealArray]:
        """What is stated, and its coordinates in the most probable solution of all, deviations from a law included.

        A law by itself may drag them along for no other reason than that it is not quite the material's.
        """
        likely = self.laws.likeliest
        return likely.problem.nuisances.parameters, likely.minima[0].z[len(likely.problem.modulus_parameters) :]

    @property
    def stated_p_value(self) -> float:
        """Probability that what the laboratory states is as far off, all of it together, as the solution takes it."""
        return nuisance_p_value(*self._statements)

    @property
    def all_accepted(self) -> bool:
        """Whether all meet eq. (10), and neither the misfit nor what is taken for stated wrongly is beyond chance."""
        chance = min(self.p_value, self.stated_p_value)
        return chance > _SIGNIFICANT and all(row["accepted"] for row in self.rows())

    @property
    def remark(self) -> str:
        """What a reader should know, in sentences; empty when one law explains all."""
        return "; ".join(text for text in (self._of_misfit(), self._of_statements()) if text)

    @property
    def remark_on_laws(self) -> str:
        """What the moduli's bands hold besides the law's own; empty where there is nothing to say."""
        said = []
        rows = self.laws.rows()
        if len(rows) > 1 and rows[0].probability < _DECIDED:
            told = ", ".join(f"{row.law} {row.probability:.2g}" for row in rows if row.probability > _WORTH_TELLING)
            said.append(f"the data do not decide between the laws ({told}); the bands hold what they leave open")
        if self.laws.departs() > _DECIDED and self.laws.widening == 1:
            other = "" if len(rows) > 1 else ", or find a better one with --law auto"
            said.append(
                f"the material departs from {rows[0].law}, its loss factor by about {100 * rows[0].deviation:.2g} %: "
                f"the bands of the moduli hold that, the law's parameters do not; take the moduli{other}"
            )
        if self.laws.widening > 1:
            said.append(
                f"deviations and bands of the moduli are {self.laws.widening:.2g} times as wide as noise and what is "
                "stated make them: by the root of chi-square per datum that no departure from a law explains"
            )
        return "; ".join(said)

    def _of_misfit(self) -> str:
        if self.explained:
            return ""
        likely, law = self.laws.likeliest, ""
        if likely.share and likely.p_value > _SIGNIFICANT:
            other = "" if len(self.laws.rows()) > 1 else " (find a better law with --law auto)"
            law = f"a loss factor {100 * likely.share:.2g} % off that of {likely.name} would{other}, or "
        return (
            f"one law does not explain all bursts within what is stated: chi-square {self.best.cost:.4g} for "
            f"{self.n_data} data; {law}something acts that this model lacks"
        )

    def _of_statements(self) -> str:
        if self.stated_p_value > _SIGNIFICANT:
            return ""
        off = "; ".join(_told(pull) for pull in largest_pulls(*self._statements))
        return (
            "this takes what the laboratory states for wrong, which has the probability "
            f"{self.stated_p_value:.1g}: {off}. Correct the statement, or find the cause: "
            f"multilayer diagnose {self.campaign}"
        )

    def to_csv(self) -> str:
        """Return ``moduli.csv``."""
        return csv_table(CSV_COLUMNS, (row.values() for row in self.rows()))

    def to_dict(self) -> dict[str, Any]:
        """Return plain data for JSON."""
        return {
            "version": 1,
            "campaign": self.campaign,
            "settings": self.settings,
            "law": self.law.model_dump(mode="json"),
            "parameters": {name: {"value": v, "std": s} for name, (v, s) in self.parameters.items()},
            "chi_square": self.best.cost,
            "n_data": self.n_data,
            "p_value": self.p_value,
            "stated_p_value": self.stated_p_value,
            "stated_deviations": {parameter.name: float(off) for parameter, off in zip(*self._statements, strict=True)},
            "remark": self.remark,
            "laws": self.laws.to_dict(),
            "remark_on_laws": self.remark_on_laws,
            "moduli": self.rows(),
            "minima": [
                {"chi_square": m.cost, "log_evidence": m.log_evidence, "law": self._law_of(m).model_dump(mode="json")}
                for m in self.minima
            ],
            **({} if self.summary is None else self.summary.to_dict()),
        }

    def _law_of(self, minimum: Minimum) -> ModulusLaw:
        return self.problem.space.law(self.problem.law_coordinates(minimum.z))


def _told(pull: Pull) -> str:
    """Return by how much a stated quantity is off, with its unit."""
    parameter, off = pull
    spread = parameter.prior.normal[1] if parameter.prior.normal else 1.0
    unit, factor = {"s": ("us", 1e6), "m": ("mm", 1e3)}.get(parameter.unit, ("%", 100.0))
    value, size = (f"{factor * amount:.3g} {unit}" for amount in (off * spread, spread))
    return f"{parameter.name} by {abs(off):.3g} standard deviations ({value}, stated {size})"


def fit_joint(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    law: str = "fractional_zener",
    *,
    elements: int | None = None,
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
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
    of both channels and the model's own error. What the laboratory states of itself are unknowns with normal priors.
    """
    settings = settings or FitSettings()
    tell = progress or (lambda text: None)
    problems = burst_problems(campaign, recordings, settings, calibration)
    solved: list[Solved] = []
    for name, branches in _laws(law, elements):
        problem = plane_wave_problem(campaign, problems, name, branches)
        label = name if branches is None else f"{name}, {branches} branches"
        solved.append((label, problem, solve_joint(problem, seed=seed, tell=tell)))
    if settings.model == "finite":
        solved = _all_with_free_rim(campaign, solved, tell, settings)
    solved = _cut(solved, [problem.data for problem in problems])
    best_minima = [part[2][0] for part in solved]
    candidates = []
    for part in solved:  # what no departure of a few per cent can save is told all the same
        candidates += with_deviations(*part) if is_competitive(part[2][0], best_minima) else [Candidate(*part)]
    best = LawMixture(candidates).best
    criteria = Criteria(settings.acceptance.time_of_flight or 1 / campaign.sampling_rate, settings.acceptance.level_db)
    plain = settings.model_dump(mode="json", exclude_none=True) | {"joint": True, "law": law}
    found = best.problem.space.law(best.problem.law_coordinates(best.minima[0].z))
    name = campaign.folder.resolve().name
    return JointFit(name, plain, found, best.problem, list(best.minima), criteria, candidates=tuple(candidates))


def _laws(law: str, elements: int | None) -> tuple[tuple[str, int | None], ...]:
    if law != AUTO:
        return ((law, elements),)
    if elements is not None:
        raise InputError("--elements: --law auto compares several numbers of them; name a law, or leave it out")
    return LAWS_COMPARED


def _cut(solved: list[Solved], bursts: Sequence[BurstData]) -> list[Solved]:
    """Return laws solved with the model cut where the records end, if that matters; hopeless ones as they are."""
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
            ends = [settle(same, m.z) for m in found[:N_FOLLOWED] if is_competitive(m, found)]
            near, best = min(ends, key=lambda end: end[1].cost)
            done.append((label, near, distinct([best, *(m for _, m in ends)])))
        solved = done
    return solved


def _all_with_free_rim(campaign: Campaign, solved: list[Solved], tell: Progress, settings: FitSettings) -> list[Solved]:
    """Return laws solved with finite elements, made for the most probable law, and for all that fit nearly as well.

    The rim changes the modulus that a law shows, hardly which law it is.
    """
    solved = sorted(solved, key=lambda part: -max(minimum.log_evidence for minimum in part[2]))
    (label, plane_waves, minima), *others = solved
    problem, found = with_free_rim(campaign, plane_waves, minima, tell, settings)
    done: list[Solved] = [(label, problem, found)]
    for other, flat, starts in others:
        if is_competitive(starts[0], minima):
            bent = replace(flat, rigs=problem.rigs)
            n = len(flat.law_parameters)
            done.append((other, bent, solve_joint(bent, [m.z[:n] for m in starts], n_best=N_FOLLOWED, tell=tell)))
    return done


def number_of_steps(campaign: Campaign, settings: FitSettings, law: str = "") -> int:
    """Return how often `fit_joint` reports progress, if the finite elements need to be made once only."""
    laws = len(LAWS_COMPARED) if law == AUTO else 1
    plane_wave = N_BEST * laws
    if settings.model == "plane_wave":
        return plane_wave
    return plane_wave + len(campaign.configurations) + 2 * N_FOLLOWED * laws


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
