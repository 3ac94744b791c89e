"""``multilayer fit`` with several campaigns: on processes or a cluster, resumed where it stopped, one summary table."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer

from multilayer.cli.options import finish

if TYPE_CHECKING:
    from multilayer.report.fit_outcome import FitTask


def fit_many(
    task: FitTask,
    sources: Sequence[Path],
    out: Path,
    *,
    jobs: int,
    cluster: str | None,
    resume: bool,
    as_json: bool = False,
) -> bool:
    """Fit several campaigns, write each as soon as it is done, then a summary; tell whether all are accepted."""
    from multilayer.cli.progress import progress_bar
    from multilayer.errors import InputError
    from multilayer.executors import as_done, executor_for
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.report.fit_outcome import done_before, fit_elsewhere, summary_of
    from multilayer.report.fits import fits_report

    tasks = [replace(task, source=source) for source in sources]
    read = [one.read() for one in tasks]  # every mistake before anything is computed
    names = [job.campaign.folder.resolve().name for job in read]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InputError(f"{', '.join(twice)}: there twice; results would overwrite each other, so rename one folder")
    refuse_unusable(out)
    rows: dict[str, dict[str, Any]] = {}
    left: list[tuple[str, FitTask]] = []
    for name, one, job in zip(names, tasks, read, strict=True):
        if resume and done_before(one, job, out / name):
            rows[name] = summary_of(one, out / name)
        else:
            left.append((name, one))
    try:
        with executor_for(jobs, cluster) as executor, progress_bar("fit", len(left)) as advance:
            for index, found in as_done(fit_elsewhere, [one for _, one in left], executor):
                name = left[index][0]
                write_files(out / name, found.files)
                rows[name] = found.summary
                advance(name)
    except KeyboardInterrupt:
        typer.echo(f"stopped: {len(rows)} of {len(names)} are in {out}; --resume goes on from there", err=True)
        raise typer.Exit(130) from None
    in_order = [rows[name] for name in names]
    write_files(out, {"summary.csv": _csv(in_order)})
    finish(fits_report(in_order), as_json=as_json)
    if not as_json:
        typer.echo(f"written to {out}: summary.csv and a folder for each campaign")
    return all(row["accepted"] == row["of"] and not row["remark"] for row in in_order)


def _csv(rows: Sequence[dict[str, Any]]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return text.getvalue()
