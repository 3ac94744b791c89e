"""One fit from its source to the files it writes: a task that runs anywhere, and knows whether it was done before."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.errors import InputError, suggest

if TYPE_CHECKING:
    from multilayer.fits.burst.result import FitResult
    from multilayer.fits.joint.fit import JointFit
    from multilayer.fits.sources import FitJob
    from multilayer.report.report import Report

Progress = Callable[[str], None]
SUMMARY_COLUMNS = ("campaign", "fit", "E1_pa", "E2_pa", "accepted", "of", "remark")


@dataclass(frozen=True)
class FitTask:
    """What to fit and how, as the command line says it.

    Attributes
    ----------
    source : Path
    method, model : str or None
    joint : bool
    law : str
    elements : int or None
    figures : bool
    posterior : str or None
        How a joint fit's intervals are found; one of `summary.METHODS`, of which the first where None.
    """

    source: Path
    method: str | None = None
    model: str | None = None
    joint: bool = False
    law: str = "fractional_zener"
    elements: int | None = None
    figures: bool = True
    posterior: str | None = None

    @property
    def record(self) -> str:
        """Name of the file that holds everything of a result."""
        return "joint.json" if self.joint else "fit.json"

    def read(self) -> FitJob:
        """Read all input.

        Raises
        ------
        InputError
            With every mistake found.
        """
        from multilayer.fits.sources import read_fit

        if self.posterior is not None:
            from multilayer.inference.summary import refuse_unusable

            if not self.joint:
                raise InputError("--posterior is of joint fits and of fits of stacks; add --joint, or leave it out")
            refuse_unusable(self.posterior)
        if self.joint:
            from multilayer.fits.joint.laws import AUTO
            from multilayer.media.laws import LAWS

            if self.law != AUTO and self.law not in LAWS:
                raise InputError(f"--law: there is no law '{self.law}'; {suggest(self.law, [AUTO, *LAWS.names()])}")
        return read_fit(self.source, self.method, self.model)


@dataclass(frozen=True)
class FitOutcome:
    """A result ready to be written.

    Attributes
    ----------
    campaign : str
    files : dict
        Contents by file name.
    accepted : bool
        Whether all of it is.
    summary : dict
        One row of `SUMMARY_COLUMNS`.
    """

    campaign: str
    files: dict[str, bytes | str]
    accepted: bool
    summary: dict[str, Any]


def number_of_steps(task: FitTask, job: FitJob) -> int:
    """Return how often a fit reports progress."""
    if task.joint:
        from multilayer.fits.joint import fit as joint_fit

        return joint_fit.number_of_steps(job.campaign, job.settings, task.law)
    from multilayer.fits.burst import fit

    return fit.number_of_steps(job.campaign, job.settings)


def run_fit(task: FitTask, job: FitJob, progress: Progress | None = None) -> FitResult | JointFit:
    """Return the result of a task whose input has been read."""
    if task.joint:
        from multilayer.fits.joint.fit import fit_joint
        from multilayer.fits.joint.posterior import with_posterior
        from multilayer.inference.summary import LAPLACE

        found = fit_joint(
            job.campaign, job.recordings, task.law, elements=task.elements, settings=job.settings,
            calibration=job.calibration, progress=progress,
        )  # fmt: skip
        return with_posterior(found, task.posterior or LAPLACE, progress)
    from multilayer.fits.burst.fit import fit_campaign

    return fit_campaign(job.campaign, job.recordings, job.settings, job.calibration, progress)


def report_of(task: FitTask, job: FitJob, result: Any) -> Report:
    """Return the report of a result."""
    from multilayer.report.fits import fit_report

    return fit_report(result, job, {"sha256": fingerprint(task, job)})


def outcome(task: FitTask, job: FitJob, result: Any) -> FitOutcome:
    """Return a result with its files."""
    report = report_of(task, job, result)
    files = report.files(figures=task.figures)
    return FitOutcome(result.campaign, files, result.all_accepted, _summary(task, report.record))


def fit_elsewhere(task: FitTask) -> FitOutcome:
    """Read, fit and prepare the files of a task: what a worker does."""
    job = task.read()
    return outcome(task, job, run_fit(task, job))


def _summary(task: FitTask, record: dict[str, Any]) -> dict[str, Any]:
    rows = record["moduli" if task.joint else "bursts"]
    e1, e2 = (float(np.median([row[name] for row in rows])) for name in ("E1_pa", "E2_pa"))
    kind = f"joint {task.law}" if task.joint else str(record["method"])
    accepted = sum(bool(row["accepted"]) for row in rows)
    remark = record.get("remark", "") or next((str(row["reason"]) for row in rows if row.get("reason")), "")
    return dict(zip(SUMMARY_COLUMNS, (record["campaign"], kind, e1, e2, accepted, len(rows), remark), strict=True))


def summary_of(task: FitTask, folder: Path) -> dict[str, Any]:
    """Return the row of a result that was written before."""
    return _summary(task, json.loads((folder / task.record).read_text(encoding="utf-8")))


def done_before(task: FitTask, job: FitJob, folder: Path) -> bool:
    """Tell whether a folder holds the result of the same input, options and version."""
    try:
        record = json.loads((folder / task.record).read_text(encoding="utf-8"))
        return bool(record["inputs"]["sha256"] == fingerprint(task, job))
    except (OSError, ValueError, KeyError, TypeError):
        return False


def fingerprint(task: FitTask, job: FitJob) -> str:
    """Return a hash of everything a result depends on."""
    options = {name: value for name, value in asdict(task).items() if name not in ("source", "figures")}
    settings = job.settings.model_dump(mode="json", exclude={"campaign", "calibration"})
    found = hashlib.sha256(json.dumps([version("multilayer"), options, settings]).encode())
    named = {"configurations": {"__all__": {"bursts": {"__all__": {"file"}}}}}
    found.update(job.campaign.model_dump_json(exclude=named).encode())
    for recording in job.recordings.values():
        for channel in (recording.base, recording.top):
            found.update(np.ascontiguousarray(channel).tobytes())
    if job.calibration is not None:
        found.update(json.dumps(job.calibration.to_dict()).encode())
    return found.hexdigest()
