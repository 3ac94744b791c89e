"""``multilayer fit`` with several campaigns: on processes or a cluster, resumed where it stopped, one summary table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import typer

from multilayer.cli.options import finish

if TYPE_CHECKING:
    from multilayer.fits.run import FitTask


class _Fitted(NamedTuple):
    """What comes back of a campaign: files and the row of the summary, or the reason why there are none."""

    files: dict[str, bytes | str]
    row: dict[str, Any]
    reason: str
    warnings: tuple[str, ...]


def fit_many(
    task: FitTask,
    sources: Sequence[Path],
    out: Path,
    jobs: int,
    cluster: str | None,
    *,
    as_json: bool,
    resume: bool,
    figures: bool,
) -> bool:
    """Fit several campaigns, write each as soon as it is done, then a summary; tell whether all are accepted."""
    from multilayer.cli.progress import progress_bar
    from multilayer.cli.warned import tell
    from multilayer.config.kinds import fit_file
    from multilayer.csv_table import csv_table
    from multilayer.errors import InputError
    from multilayer.executors import as_done, executor_for
    from multilayer.fits.run import SUMMARY_COLUMNS, is_accepted, row_without_fit
    from multilayer.report.fits import fits_report
    from multilayer.writing.folders import claim_folder, write_file, write_files
    from multilayer.writing.manifest import inputs_noted

    # every mistake before anything is computed
    fits, inputs = [], {}
    for source in sources:
        with inputs_noted() as noted:
            fits.append(replace(task, source=source).read())
            inputs[fits[-1].name] = noted
    if stacks := [fit_file(fit.task.source) for fit in fits if fit.method.reads == "stack-fit"]:
        raise InputError(f"{stacks[0]}: this is a stack-fit file; fit it by itself, without campaigns beside it")
    names = [fit.name for fit in fits]
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise InputError(f"{', '.join(twice)}: there twice; results would overwrite each other, so rename one folder")
    claim_folder(out)
    done = [fit for fit in fits if resume and fit.done_in(out / fit.folder_name)]
    rows = {fit.name: fit.summary_in(out / fit.folder_name) for fit in done}
    left, n_written = [fit for fit in fits if fit.name not in rows], len(rows)
    try:
        with executor_for(jobs, cluster) as executor, progress_bar("fit", len(left)) as advance:
            tasks = [replace(fit.task, source=fit.task.source.resolve()) if cluster else fit.task for fit in left]
            for index, fitted in as_done(partial(_fit_elsewhere, figures=figures), tasks, executor):
                fit = left[index]
                tell(fitted.warnings)
                folder = out / fit.folder_name
                if fitted.reason:
                    older = "; its folder holds an older fit" if folder.exists() else ""
                    rows[fit.name] = row_without_fit(fit.name, fit.method.name, fitted.reason + older)
                else:
                    n_written += 1
                    write_files(folder, fitted.files, inputs=inputs[fit.name], made_by="fit")
                    rows[fit.name] = fitted.row
                advance(fit.name)
    except KeyboardInterrupt:
        typer.echo(f"stopped: {n_written} of {len(names)} are in {out}; --resume goes on from there", err=True)
        raise typer.Exit(130) from None
    in_order = [rows[name] for name in names]
    write_file(out / "summary.csv", csv_table(SUMMARY_COLUMNS, (row.values() for row in in_order)))
    finish(fits_report(in_order), as_json=as_json)
    if not as_json:
        typer.echo(f"written to {out}: summary.csv and a folder for each campaign that was fitted")
    return all(map(is_accepted, in_order))


def _fit_elsewhere(task: FitTask, *, figures: bool) -> _Fitted:
    """Read and fit a task: what a worker does."""
    from multilayer.errors import MultilayerError, MultilayerWarning
    from multilayer.fits.run import summary_row
    from multilayer.report.fits import fit_report
    from multilayer.simulation.warned import collected_warnings

    with collected_warnings(MultilayerWarning) as texts:
        try:
            fit = task.read()
            report = fit_report(fit.run(), fit.job, fit.inputs)
            report = replace(report, warnings=_each_once([*texts, *report.warnings]))
            return _Fitted(report.files(figures=figures), summary_row(report.record), "", report.warnings)
        except MultilayerError as error:
            reason = str(error)
        except Exception as error:  # of one campaign: it is told, and does not end the others
            reason = f"{type(error).__name__}: {error}"
    return _Fitted({}, {}, reason, _each_once(texts))


def _each_once(texts: Sequence[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(" ".join(text.split()) for text in texts))
