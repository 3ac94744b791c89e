"""The report of any fit, and of several."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from multilayer.fits.joint.result import JointFit
from multilayer.fits.result import FitResult
from multilayer.fits.sources import FitJob, StackJob
from multilayer.fits.stacks.result import StackFitResult
from multilayer.report.fit import burst_report
from multilayer.report.joint import joint_report
from multilayer.report.listing import Listing, listing_of
from multilayer.report.report import Report, Section
from multilayer.report.stack_fit import stack_fit_report


def fit_report(result: FitResult, job: FitJob | StackJob, inputs: Mapping[str, Any]) -> Report:
    """Return the report of a fit of any kind.

    Parameters
    ----------
    result : FitResult
    job : FitJob or StackJob
        What was fitted.
    inputs : mapping
        What tells the fit apart from others, as its fingerprint.
    """
    # that of a plugin may bring less than `FitResult` has
    return replace(_report(result, job, inputs), warnings=tuple(getattr(result, "warnings", ())))


def _report(result: FitResult, job: FitJob | StackJob, inputs: Mapping[str, Any]) -> Report:
    match result:
        case JointFit():
            return joint_report(result, inputs)
        case StackFitResult():
            return stack_fit_report(result)
    if isinstance(job, FitJob) and result.bursts:
        return burst_report(result, job.campaign, job.settings, inputs)
    return plain_report(result, inputs)


def plain_report(result: FitResult, inputs: Mapping[str, Any]) -> Report:
    """Return the report of a fit of which nothing else is known: its tables and remarks."""
    accepted = result.all_accepted
    return Report(
        name=result.name,
        kind=f"fit by {result.method}",
        label="Accepted" if accepted else "Not accepted",
        tone="good" if accepted else "mind",
        sentence=f"The fit of {result.name} by {result.method} is {'accepted' if accepted else 'not accepted'}.",
        sections=(
            Section("Results", listings=tuple(listing_of(text, name) for name, text in result.tables.items())),
            *([Section("What to mind", remarks=tuple(result.remarks))] if result.remarks else []),
        ),
        inputs={**result.settings, **inputs},
        tables=result.tables,
        record={**result.to_dict(), **({"inputs": inputs} if inputs else {})},
        record_file=result.record_name,
        page="report.html",
        accepted=accepted,
    )


def fits_report(rows: Sequence[Mapping[str, Any]]) -> Report:
    """Return the report of several fits, a row for each campaign; moduli are medians over its frequencies."""
    columns: dict[str, Callable[[Mapping[str, Any]], str]] = {
        "campaign": lambda row: row["campaign"],
        "fit": lambda row: row["fit"],
        ">median E1 / Pa": lambda row: f"{row['E1_pa']:.4g}",
        ">median E2 / Pa": lambda row: f"{row['E2_pa']:.4g}",
        ">accepted": lambda row: f"{row['accepted']} of {row['of']}",
        "remark": lambda row: row["remark"],
    }
    listing = Listing.of(rows, columns)
    return Report(sections=(Section("", listings=(listing,)),), record={"version": 1, "campaigns": list(rows)})
