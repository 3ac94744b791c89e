"""A fit from what a user asks for to its result: a task that runs anywhere, and knows whether it was done before."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from multilayer.errors import InputError
from multilayer.experiments.places import LawAtPlace
from multilayer.experiments.two_plate.campaign import Acting
from multilayer.fits.methods import BURST_BY_BURST, JOINT, METHODS, STACKS, Method, Progress
from multilayer.fits.result import FitResult
from multilayer.fits.settings import DEFAULT_LAW, FitSettings
from multilayer.fits.sources import FitJob, Source, StackJob, open_source, read_fit
from multilayer.measurements.campaign import load_recordings
from multilayer.measurements.description import Campaign
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording
from multilayer.writing.folders import is_unfinished
from multilayer.writing.manifest import differences, listed, read_manifest

SUMMARY_COLUMNS = ("campaign", "fit", "E1_pa", "E2_pa", "accepted", "of", "remark")


@dataclass(frozen=True)
class FitTask:
    """What to fit and how, as the command line says it; None for what it leaves out.

    Attributes
    ----------
    source : Path
        See `multilayer.fits.sources.open_source`.
    method : str, optional
        One of `METHODS`.
    joint : bool
        The same as the method ``joint``; `method` then only says what lies above the top plate.
    model, law, elements, posterior, lateral
        Options of methods.
    given : tuple of Effect, optional
        Unmodelled effects that act besides (``--with``): of joint fits.
    """

    source: Path
    method: str | None = None
    joint: bool = False
    model: str | None = None
    law: str | None = None
    elements: int | None = None
    posterior: str | None = None
    lateral: str | None = None
    given: tuple[Acting, ...] | None = None

    @property
    def options(self) -> dict[str, Any]:
        """The options of methods that are given."""
        named = (field.name for field in fields(self) if field.name not in ("source", "method", "joint"))
        return {name: value for name in named if (value := getattr(self, name)) is not None}

    def read(self) -> FitRun:
        """Open the source and read all input.

        Raises
        ------
        InputError
            With every mistake found.
        """
        source = open_source(self.source)
        if source.of_stacks:
            return FitRun(self, self._of_stacks(source), source.stack_job())
        if self.joint and self.method not in (None, JOINT, *BURST_BY_BURST):
            raise InputError(f"--joint and --method {self.method} are two methods; leave one of them out")
        joint = self.joint or self.method == JOINT or bool(self.given and self.method is None)
        settings = source.settings({"method": None if self.method == JOINT else self.method, "model": self._model})
        method = self._of_campaign(METHODS[JOINT if joint else settings.method])
        return FitRun(self, method, source.campaign_job(settings))

    @property
    def _model(self) -> str | None:
        """The rig model asked for; where nothing is said, the one that the given effects need."""
        needs_rim = any(effect.needs_finite_elements for effect in self.given or ())
        return self.model or ("finite" if needs_rim else None)

    def _of_stacks(self, source: Source) -> Method[StackJob]:
        """Return the method for a file about stacks, with its options."""
        name = self.method or STACKS
        fits_stacks = name in METHODS and METHODS[name].reads == "stack-fit"
        kind = METHODS[name if fits_stacks else STACKS]
        wrong = [*([] if fits_stacks else ["method"]), *(["joint"] if self.joint else [])]
        wrong += [option for option in self.options if option not in kind.options()]
        if wrong:
            text = f"--{wrong[0]} is of the fit of a campaign; {source.path} is a stack-fit file: leave it out"
            raise InputError(text)
        return kind.with_options(self.options)

    def _of_campaign(self, kind: type[Method[Any]]) -> Method[FitJob]:
        """Return a method for a campaign, with its options."""
        for name in self.options:
            if name not in kind.options():
                takers = [other for other, method in METHODS.working() if name in method.options()]
                remedy = "add --joint" if set(takers) <= {JOINT, STACKS} else "choose another --method"
                text = f"{kind.written(name)} is of {' and '.join(takers)}, not of {kind.name}"
                raise InputError(f"{text}; {remedy}, or leave it out")
        return kind.with_options(self.options)


@dataclass(frozen=True)
class FitRun:
    """A task whose input has been read.

    Attributes
    ----------
    task : FitTask
    method : Method
    job : FitJob or StackJob
    """

    task: FitTask
    method: Method[Any]
    job: FitJob | StackJob

    @property
    def name(self) -> str:
        """What is fitted: the name of the campaign, or of the file of stacks."""
        return self.job.name

    @property
    def folder_name(self) -> str:
        """What a folder of results is called."""
        return f"{self.name}{self.method.suffix}"

    @property
    def number_of_steps(self) -> int:
        """How often `run` reports progress."""
        return self.method.number_of_steps(self.job)

    def run(self, tell: Progress | None = None) -> FitResult:
        """Return the result."""
        with np.errstate(all="ignore"):  # trials leave the range of numbers; no minimum lies there
            return self.method.run(self.job, tell or (lambda text: None))

    @property
    def record_name(self) -> str:
        """Name of the file that holds everything of the result."""
        return self.method.gives.record_name

    @cached_property
    def inputs(self) -> dict[str, Any]:
        """What tells the fit of a campaign apart from others: the hash of everything that its result depends on."""
        return {"sha256": self._fingerprint(self.job)} if isinstance(self.job, FitJob) else {}

    def done_in(self, folder: Path) -> bool:
        """Tell whether a folder holds the whole result of the same input, options and version, which can be read."""
        manifest = read_manifest(folder)
        if manifest is None or self.record_name not in listed(manifest):
            return False
        if is_unfinished(folder) or differences(folder, manifest):
            return False
        try:
            record = json.loads((folder / self.record_name).read_text(encoding="utf-8"))
            return bool(record["inputs"]["sha256"] == self.inputs["sha256"] and summary_row(record))
        except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError):
            return False

    def summary_in(self, folder: Path) -> dict[str, Any]:
        """Return the row of a result that was written before."""
        return summary_row(json.loads((folder / self.record_name).read_text(encoding="utf-8")))

    def _fingerprint(self, job: FitJob) -> str:
        task = self.task
        options = {
            "method": None if task.method == JOINT else task.method, "model": task.model,
            "joint": self.method.name == JOINT, "law": task.law or DEFAULT_LAW, "elements": task.elements,
            "posterior": task.posterior,
            **({"lateral": task.lateral} if task.lateral else {}),
            **({"with": [_told(effect) for effect in task.given]} if task.given else {}),
        }  # fmt: skip
        settings = job.settings.model_dump(mode="json", exclude={"campaign", "calibration"})
        digest = hashlib.sha256(json.dumps([version("multilayer"), options, settings]).encode())
        files = {"configurations": {"__all__": {"bursts": {"__all__": {"file"}}}}}
        digest.update(job.campaign.model_dump_json(exclude=files).encode())
        for recording in job.recordings.values():
            for channel in (recording.base, recording.top):
                digest.update(np.ascontiguousarray(channel).tobytes())
        if job.calibration is not None:
            digest.update(json.dumps(job.calibration.to_dict()).encode())
        return digest.hexdigest()


def fit_campaign(
    source: Path | str | Campaign,
    recordings: Mapping[tuple[str, float], Recording] | None = None,
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """Find the complex modulus of a sample, as `multilayer fit` does.

    Parameters
    ----------
    source : path, str or Campaign
        A campaign folder, its ``campaign.yaml`` or a fit file; or a campaign that was read.
    recordings : mapping, optional
        Signals by (configuration name, frequency); read from the campaign's files when left out.
    settings : FitSettings, optional
        In place of those of a fit file.
    calibration : Calibration, optional
        Removed from the top channel; that of a fit file when left out.
    progress : callable, optional
        Called with a short text after every step.

    Raises
    ------
    InputError
        With every mistake found.
    """
    if not isinstance(source, Campaign):
        job = read_fit(Path(source))
        source, recordings = job.campaign, recordings or job.recordings
        settings, calibration = settings or job.settings, calibration or job.calibration
    elif recordings is None:
        recordings = load_recordings(source)
    settings = settings or FitSettings()
    job = FitJob(source, recordings, settings, calibration)
    return METHODS[settings.method].with_options({}).run(job, progress or (lambda text: None))


def _told(effect: Acting) -> list[Any]:
    """Return what a fit with an effect depends on."""
    priors = [parameter.model_dump(mode="json") for parameter in effect.parameters]
    return [effect.name, repr(effect) if isinstance(effect, LawAtPlace) else "", priors]


def summary_row(record: dict[str, Any]) -> dict[str, Any]:
    """Return the values of `SUMMARY_COLUMNS` from the record of the fit of a campaign; moduli are medians."""
    rows = record["bursts"] if "bursts" in record else record["moduli"]
    known = {name: [row[name] for row in rows if row[name] is not None] for name in ("E1_pa", "E2_pa")}
    e1, e2 = (float(np.median(values)) if values else float("nan") for values in known.values())
    kind = str(record["method"]) if "method" in record else f"{JOINT} {record['settings']['law']}"
    accepted = sum(bool(row["accepted"]) for row in rows)
    remark = record.get("remark", "") or next((str(row["reason"]) for row in rows if row.get("reason")), "")
    return dict(zip(SUMMARY_COLUMNS, (record["campaign"], kind, e1, e2, accepted, len(rows), remark), strict=True))


def row_without_fit(campaign: str, method: str, reason: str) -> dict[str, Any]:
    """Return the values of `SUMMARY_COLUMNS` of a campaign that could not be fitted."""
    values = (campaign, method, float("nan"), float("nan"), 0, 0, f"not fitted: {' '.join(reason.split())}")
    return dict(zip(SUMMARY_COLUMNS, values, strict=True))


def is_accepted(row: Mapping[str, Any]) -> bool:
    """Tell from the row of a result whether all of it is accepted."""
    return bool(row["accepted"] == row["of"] and not row["remark"])
