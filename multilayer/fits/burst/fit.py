"""Fitting a campaign: every burst by itself, then the choice between branches, then how sure each result is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.experiments.two_plate.burst import BurstData, BurstProblem
from multilayer.experiments.two_plate.plane_waves import PlaneWaveRig
from multilayer.fits.burst.acceptance import Criteria, discrepancies_in_band, excess_in_band
from multilayer.fits.burst.branches import Candidates, Choice
from multilayer.fits.burst.free_rim import Progress, search, search_bounds, with_free_rim
from multilayer.fits.burst.nelder_mead import minimise_envelope_cost
from multilayer.fits.burst.region import Region, explore
from multilayer.fits.burst.uncertainty import ErrorParts, error_parts, pseudo_inverse
from multilayer.fits.methods import BURST_BY_BURST, LEAST_SQUARES, NELDER_MEAD, CampaignMethod, Compared
from multilayer.fits.result import BurstFit, FitResult, Solution
from multilayer.fits.settings import FitSettings
from multilayer.inference.problem import Minimum
from multilayer.log import logged
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.signals.calibration import Calibration
from multilayer.signals.envelope import envelope
from multilayer.signals.recording import Recording
from multilayer.signals.spectra import noise_level
from multilayer.units import DB_PER_NEPER

if TYPE_CHECKING:
    from multilayer.fits.sources import FitJob

_SIGMAS = 2.0  # a uniform ellipse of this radius has the standard deviations of the normal law it is cut from
_WEAK = 0.03
_MOVES_ALIKE, _UNBOUNDED = 0.1, 0.35  # top over base - 1; std of E1 over E1, beyond which it has no upper end
_ONE_SIDED = 1.645  # standard deviations to the end of a one-sided 95 % interval
_POOR = 0.05
_HEAD_START = 0.05
_BETTER = 0.5  # misfits: a minimum as much lower fits better beyond doubt
_FAR = 3.0  # standard deviations


def fit_bursts(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """Find the complex modulus of a campaign's specimen at every burst.

    Parameters
    ----------
    campaign : Campaign
    recordings : mapping
        Signals by (configuration name, frequency); see `measurements.campaign.load_recordings`.
    settings : FitSettings, optional
    calibration : Calibration, optional
        Removed from the top channel.
    progress : callable, optional
        Called with a short text after every step, two steps per burst.

    Returns
    -------
    FitResult

    Raises
    ------
    InputError
        When the settings name a method that is none of these.

    Notes
    -----
    Bonfiglio & Pompoli 2015 with ``method: nelder-mead``; ``docs/inverse.md`` says what the default does otherwise.
    """
    settings = settings or FitSettings()
    if settings.method not in BURST_BY_BURST:
        text = f"method: '{settings.method}' does not fit every burst by itself; take {' or '.join(BURST_BY_BURST)}"
        raise InputError(text)
    tell = logged(progress)
    problems = burst_problems(campaign, recordings, settings, calibration)
    bounds = [search_bounds(settings)] * len(problems)
    candidates, choices = search(problems, bounds, tell)
    if settings.model == "finite":
        problems, bounds, candidates, choices = with_free_rim(campaign, problems, choices, settings, tell)
    known = campaign.uncertainty if campaign.uncertainty != Uncertainty() else None
    bursts: dict[int, BurstFit] = {}
    accepted: dict[str, RealArray] = {}  # by configuration, the solution of the last burst that has one
    for i in sorted(range(len(problems)), key=lambda i: problems[i].data.frequency):
        data = problems[i].data
        last = accepted.get(data.configuration) if settings.start == "neighbour" else None
        finish = _Finish(problems[i], candidates[i], choices[i], settings, known, bounds[i], last)
        best, bursts[i] = finish.fit()
        if bursts[i].accepted:
            accepted[data.configuration] = best
        tell(f"{data.configuration} {data.frequency:g} Hz: solved")
    return FitResult(
        campaign.folder.resolve().name,
        settings.method,
        settings.model_dump(mode="json", exclude_none=True),
        [bursts[i] for i in range(len(problems))],
    )


def number_of_steps(campaign: Campaign, settings: FitSettings) -> int:
    """Return how often `fit_bursts` reports progress."""
    n_bursts = sum(len(configuration.bursts) for configuration in campaign.configurations)
    return 2 * n_bursts if settings.model == "plane_wave" else 3 * n_bursts + len(campaign.configurations)


def burst_problems(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    settings: FitSettings,
    calibration: Calibration | None,
) -> list[BurstProblem]:
    """Return the inverse problem of every burst, in the order of the campaign."""
    rigs = {
        configuration.name: PlaneWaveRig.of(
            campaign, configuration, settings.air_above, settings.ambient, settings.pores,
            open_rim=settings.open_rim, sensor_mass=settings.sensor_mass,
        )
        for configuration in campaign.configurations
    }  # fmt: skip
    measured = burst_data(campaign, recordings, calibration)
    return [BurstProblem(data, rigs[data.configuration], settings.dispersive) for data in measured]


def burst_data(
    campaign: Campaign, recordings: Mapping[tuple[str, float], Recording], calibration: Calibration | None
) -> list[BurstData]:
    """Return the signals of every burst, averaged over repeats and calibrated, in the order of the campaign."""
    return [
        _burst_data(
            configuration.name, burst.frequency, recordings[configuration.name, burst.frequency], calibration,
            campaign.burst.cycles,
        )
        for configuration in campaign.configurations
        for burst in configuration.bursts
    ]  # fmt: skip


def _burst_data(
    configuration: str, frequency: float, recording: Recording, calibration: Calibration | None, cycles: float
) -> BurstData:
    base, top = recording.mean()
    std, noise = 0.0, noise_level(recording, of_mean=True)
    if calibration is not None:
        top, std = calibration.correct(top, recording.sampling_rate, frequency), calibration.std_at(frequency)
        noise = noise._replace(top=noise.top / calibration.at(frequency)[0])
    return BurstData(configuration, frequency, recording.sampling_rate, base, top, noise, cycles, std)


@dataclass(frozen=True)
class _Finish:
    """From the chosen branch of one burst to its result."""

    problem: BurstProblem
    found: Candidates
    choice: Choice
    settings: FitSettings
    known: Uncertainty | None
    bounds: tuple[RealArray, RealArray]
    neighbour: RealArray | None = None  # where Nelder-Mead starts, in place of what the settings say

    @property
    def criteria(self) -> Criteria:
        given = self.settings.acceptance
        interval = 1 / self.problem.data.sampling_rate
        return Criteria(given.time_of_flight or interval, given.level_db)

    @property
    def literal(self) -> bool:
        return self.settings.method == NELDER_MEAD

    def fit(self) -> tuple[RealArray, BurstFit]:
        """Return the solution, (ln E1, E2/E1), and what is told of it."""
        problem, data = self.problem, self.problem.data
        best = self._minimise()
        differences = discrepancies_in_band(problem, best.z, whole_samples=self.literal)
        delta_tof, delta_level = (float(difference) for difference in differences)
        errors = error_parts(problem, best.z, self.known)
        mean, std = self._region(best.z, errors).moments(_moduli)
        reasons = self._reason(best, delta_tof, delta_level), self._missed(best, mean, std)
        reason = ", ".join(text for text in reasons if text)
        if bound := self._bound(mean, std):
            mean, std, reason = np.full(3, np.nan), np.full(3, np.nan), bound
        f = np.array([data.frequency])
        return best.z, BurstFit(
            configuration=data.configuration,
            frequency=data.frequency,
            storage_modulus=float(mean[0]), storage_modulus_std=float(std[0]),
            loss_modulus=float(mean[1]), loss_modulus_std=float(std[1]),
            loss_factor=float(mean[2]), loss_factor_std=float(std[2]),
            solution=_solution(best.z, float(problem.misfit(best.z))),
            delta_tof=delta_tof, delta_level_db=delta_level,
            accepted=not reason, reason=reason, notes=self._notes(best, mean, std),
            alternatives=self._alternatives(best), errors=errors,
            history=_history(best),
            measured_transmissibility=data.transmissibility,
            modelled_transmissibility=complex(problem.rig.transmissibility(f, problem.modulus(best.z, f))[0]),
            time=np.arange(data.n_samples) / data.sampling_rate,
            measured_envelope=data.envelope, modelled_envelope=envelope(problem.signal(best.z)),
        )  # fmt: skip

    def _minimise(self) -> Minimum:
        if not self.literal:
            return self.choice.minimum
        start = self.choice.minimum.z
        if self.neighbour is not None:
            start = self.neighbour
        elif (given := self.settings.quasi_static) is not None:
            start = np.array([np.log(given.storage_modulus), given.loss_modulus / given.storage_modulus])
        return minimise_envelope_cost(self.problem, start, *self.bounds)

    def _region(self, x: RealArray, errors: ErrorParts) -> Region:
        """Return the accepted region: eq. (10) to the letter, or what noise and stated uncertainties leave open."""
        low, high = self.bounds
        response = pseudo_inverse(self.problem.jacobian(x))
        if self.literal or self.known is None:
            shape = response @ self._tolerances()
            return explore(self._excess, x, shape, low, high)
        covariance = errors.covariance
        here, metric = self.problem.residual(x), np.linalg.inv(covariance)

        def gauge(points: RealArray) -> RealArray:
            apparent = (self.problem.residual(points) - here) @ response.T
            return np.asarray(np.sqrt(np.einsum("...i,ij,...j->...", apparent, metric, apparent)) / _SIGMAS)

        return explore(gauge, x, np.asarray(_SIGMAS * np.linalg.cholesky(covariance)), low, high)

    def _excess(self, points: RealArray) -> RealArray:
        return excess_in_band(self.problem, points, self.criteria, whole_samples=self.literal)

    def _tolerances(self) -> RealArray:
        """Return what the tolerances of eq. (10) do to the residual, shape (2 n_bins, 2)."""
        f, _, top = self.problem.data.local
        level = self.criteria.level_db / DB_PER_NEPER * top
        delay: ComplexArray = -2j * np.pi * f * self.criteria.time_of_flight * top
        return np.stack([self.problem.as_real(level), self.problem.as_real(delay)], axis=-1)

    def _reason(self, best: Minimum, delta_tof: float, delta_level: float) -> str:
        if self.choice.unresolved:
            return "several solutions fit alike and no other burst can decide: see the alternatives"
        if best.at_bound:
            e1, loss = np.exp(best.z[0]), best.z[1]
            return f"the best solution lies on a bound of the search (E1 = {e1:.4g} Pa, loss factor = {loss:.3g})"
        return self.criteria.reason(delta_tof, delta_level)

    def _missed(self, best: Minimum, mean: RealArray, std: RealArray) -> str:
        """Say so when Nelder-Mead ended where the signal is far from explained, and another minimum is known.

        Eq. (10) compares two numbers: it holds at points, too, where the signals are nothing alike.
        """
        lowest = self.found.minima[0]
        if not self.literal or lowest.norm >= _BETTER * float(self.problem.misfit(best.z)):
            return ""
        beyond = np.abs(_moduli(lowest.z) - mean)[:2] > _FAR * std[:2]
        e1 = np.exp(lowest.z[0])
        return f"E1 = {e1:.4g} Pa fits better: Nelder-Mead ended in another minimum" if beyond.any() else ""

    def _bound(self, mean: RealArray, std: RealArray) -> str:
        """Return what is known of a sample so stiff that the top plate moves as the base does; empty of others.

        That motion differs from the base's in proportion to the sample's compliance 1/E, whose error is normal and may
        exceed it: then there is no largest E.
        """
        apart = abs(self.problem.data.transmissibility - 1)
        if apart > _MOVES_ALIKE or std[0] < _UNBOUNDED * mean[0]:
            return ""
        least = mean[0] / (1 + _ONE_SIDED * std[0] / mean[0])
        return (
            f"E1 is at least {least:.2g} Pa (95 %), no more is known: top and base differ by {100 * apart:.2g} % only"
        )

    def _notes(self, best: Minimum, mean: RealArray, std: RealArray) -> list[str]:
        notes = []
        if self.choice.by_neighbours:
            notes.append("several solutions fit alike; the other bursts decided")
        size = abs(self.problem.data.transmissibility)
        if std[0] > _WEAK * mean[0]:
            why = "the top plate barely amplifies, transmissibility" if 0.8 < size < 1.25 else "transmissibility"
            notes.append(f"weak: E1 known to {100 * std[0] / mean[0]:.0f} % only ({why} {size:.2f})")
        misfit = float(self.problem.misfit(best.z))
        if misfit > _POOR:
            notes.append(f"the model leaves {100 * misfit:.0f} % of the signal unexplained")
        if self.problem.data.cut_short:
            notes.append("the ring-down goes on after the record's end (the model is cut there too): record longer")
        if self.problem.data.head_start > _HEAD_START:
            share = f"{100 * self.problem.data.head_start:.0f} %"
            notes.append(f"the top plate moves ({share} of its maximum) before the base does: leave it time to rest")
        return notes

    def _alternatives(self, best: Minimum) -> list[Solution]:
        """Return the other minima that meet eq. (10)."""
        others = [m for m in self.found.minima if np.any(np.abs(m.z - best.z) > (0.05, 0.1)) and not m.at_bound]
        if not others:
            return []
        excess = self._excess(np.array([m.z for m in others]))
        return [_solution(m.z, m.norm) for m, e in zip(others, excess, strict=True) if e <= 1]


def _moduli(x: RealArray) -> RealArray:
    e1 = np.exp(x[..., 0])
    return np.stack([e1, e1 * x[..., 1], x[..., 1]], axis=-1)


def _solution(x: RealArray, misfit: float) -> Solution:
    e1, e2, _ = _moduli(x)
    return Solution(float(e1), float(e2), misfit)


def _history(minimum: Minimum) -> RealArray:
    rows = [(*_moduli(x)[:2], cost) for x, cost in minimum.history]
    return np.array(rows, dtype=float).reshape(-1, 3)


class LeastSquares(CampaignMethod):
    """Every burst by itself: the spectrum in the band of the burst, all minima, the region that is left open."""

    name = LEAST_SQUARES
    title = "least squares, burst by burst"
    summary = "E1 and E2 at every burst, from the spectrum of the top plate in the band of the burst"
    of_settings: ClassVar[tuple[str, ...]] = ("model",)

    def number_of_steps(self, job: FitJob) -> int:
        """Return how often `run` reports progress."""
        return number_of_steps(job.campaign, job.settings)

    def run(self, job: FitJob, tell: Progress) -> FitResult:
        """Return the modulus at every burst."""
        settings = job.settings if job.settings.method == self.name else job.settings.changed(method=self.name)
        return fit_bursts(job.campaign, job.recordings, settings, job.calibration, tell)

    def compared(self, job: FitJob) -> Mapping[str, Compared]:
        """Return the fits with both models, and that with the region of eq. (10)."""
        plane = replace(job, settings=job.settings.changed(method=self.name, model="plane_wave"))
        # the finite model has no air above
        finite = replace(job, settings=job.settings.changed(method=self.name, model="finite", termination=None))
        known, title = "", "the same, mean and deviation over the solutions that eq. (10) accepts"
        if job.campaign.uncertainty == Uncertainty():
            known = "the campaign states no uncertainties, so that plane-wave has the region of eq. (10) itself"
        # without stated uncertainties a fit takes the region that eq. (10) accepts
        unstated = replace(plane, campaign=job.campaign.model_copy(update={"uncertainty": Uncertainty()}))
        return {
            "plane-wave": Compared("least squares, plane-wave model", plane),
            "eq-10": Compared(title, None if known else unstated, known),
            "finite": Compared("least squares, finite elements with the free rim", finite),
        }


class NelderMead(LeastSquares):
    """The method of Bonfiglio & Pompoli 2015 to the letter."""

    name = NELDER_MEAD
    title = "the 2015 paper to the letter"
    summary = "E1 and E2 at every burst, from the envelope of the top plate, eq. (9) of the 2015 paper"
    slow = True

    def compared(self, job: FitJob) -> Mapping[str, Compared]:
        """Return the fit with the paper's model."""
        settings = job.settings.changed(method=self.name, model="plane_wave")
        return {self.name: Compared(self.title, replace(job, settings=settings))}
