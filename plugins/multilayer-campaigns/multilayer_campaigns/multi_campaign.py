"""Several campaigns that are compared with each other: read together, fitted alike."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from multilayer.errors import InputError
from multilayer.fits.burst.fit import fit_bursts, number_of_steps
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import FitJob, read_fit
from multilayer.measurements.description import Uncertainty
from multilayer_campaigns.modulus_points import ModulusPoint, points_of

_OWN = {"campaign", "calibration", "bounds", "acceptance", "quasi_static"}  # what fits that are compared may differ in

SAME_RIG = frozenset({"channel_gain", "channel_delay", "top_plate_mass"})
_SIGMAS = 3.0
_ROUNDED = 1e-3


@dataclass(frozen=True)
class FittedCampaigns:
    """What several campaigns say, burst by burst.

    Attributes
    ----------
    names : list of str
        Folders of the campaigns.
    points : list of ModulusPoint
        Of all accepted bursts.
    remarks : list of str
        What a reader should know besides.
    """

    names: list[str]
    points: list[ModulusPoint]
    remarks: list[str]


def read_several(sources: Sequence[Path], model: str | None = None) -> list[FitJob]:
    """Read fit files, campaign folders or campaign files that are to be compared.

    Parameters
    ----------
    sources : sequence of Path
    model : str, optional
        In place of that in the fit files.

    Raises
    ------
    InputError
        With every mistake found; also when a campaign is there twice, or two would be fitted by other models.
    """
    jobs, problems = [], []
    for source in sources:
        try:
            jobs.append(read_fit(source, model=model))
        except InputError as error:
            problems += error.problems
    if problems:
        raise InputError(problems)
    files = [job.campaign.file.resolve() for job in jobs]
    if twice := sorted({str(file.parent) for file in files if files.count(file) > 1}):
        raise InputError(f"{', '.join(twice)}: there twice; name every campaign once")
    _refuse_unlike(jobs)
    return jobs


def _refuse_unlike(jobs: Sequence[FitJob]) -> None:
    first, *others = ((job, job.settings.model_dump(exclude=_OWN)) for job in jobs)
    for job, settings in others:
        unlike = [name for name, value in settings.items() if value != first[1][name]]
        if unlike:
            raise InputError(
                f"{job.campaign.folder}: another {' and '.join(unlike)} than {first[0].campaign.folder}; what is to be "
                "compared must be fitted alike"
            )


def refuse_other_material(jobs: Sequence[FitJob]) -> None:
    """Refuse campaigns that cannot be about one specimen: density or Poisson's ratio differ.

    Raises
    ------
    InputError
    """
    first = jobs[0].campaign
    for job in jobs[1:]:
        one, other = first.specimen, job.campaign.specimen
        known = math.hypot(first.uncertainty.density, job.campaign.uncertainty.density)
        if abs(other.density / one.density - 1) > max(_SIGMAS * known, _ROUNDED):
            unlike = f"a density of {other.density:g} kg/m3, not {one.density:g}"
        elif other.poisson_ratio != one.poisson_ratio:
            unlike = f"a Poisson's ratio of {other.poisson_ratio:g}, not {one.poisson_ratio:g}"
        else:
            continue
        raise InputError(f"{job.campaign.file}: {unlike} as in {first.folder}; this cannot be the same specimen")


def common_errors(jobs: Sequence[FitJob]) -> frozenset[str]:
    """Return the stated errors that campaigns on one rig share; that of the density where they state one density."""
    same_piece = len({job.campaign.specimen.density for job in jobs}) == 1
    return SAME_RIG | {"density"} if same_piece else SAME_RIG


def steps_of_several(jobs: Sequence[FitJob]) -> int:
    """Return how often `fit_several` reports progress."""
    return sum(number_of_steps(job.campaign, job.settings) for job in jobs)


def fit_several(jobs: Sequence[FitJob], progress: Callable[[str], None] | None = None) -> FittedCampaigns:
    """Fit campaigns burst by burst.

    Raises
    ------
    InputError
        When a campaign has no accepted burst.
    """
    names = [job.campaign.folder.resolve().name for job in jobs]
    points, remarks = [], []
    for index, (name, job) in enumerate(zip(names, jobs, strict=True)):
        result = fit_bursts(job.campaign, job.recordings, job.settings, job.calibration, progress)
        points += points_of(index, job.campaign, result, job.settings.sensor_mass)
        if left := sum(not burst.accepted for burst in result.bursts):
            remarks.append(f"{name}: {left} of {len(result.bursts)} bursts have no accepted solution and are left out")
        if job.campaign.uncertainty == Uncertainty():
            remarks.append(f"{name}: states no uncertainty; gain, delay, sizes and masses are taken as exact")
        remarks += _of_poisson(name, job.campaign.specimen.poisson_ratio, job.settings)
    return FittedCampaigns(names, points, remarks)


def _of_poisson(name: str, poisson_ratio: float, settings: FitSettings) -> list[str]:
    if not poisson_ratio or settings.model == "finite":
        return []
    return [f"{name}: Poisson's ratio is {poisson_ratio:g}, and plane waves lack the free rim; see --model finite"]
