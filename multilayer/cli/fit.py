"""``multilayer fit``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import AsJson, Figures, Out, finish, folder_for

if TYPE_CHECKING:
    from multilayer.report.fit_outcome import FitTask


def fit(
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="FILE_OR_CAMPAIGN", help="Campaign folders, their campaign.yaml, or fit files."),
    ],
    out: Out = None,
    as_json: AsJson = False,
    method: Annotated[
        str | None,
        typer.Option(
            help="least-squares (default) or nelder-mead (the 2015 paper to the letter).",
            autocompletion=completion.methods,
        ),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(
            help="plane_wave (default), or finite: finite elements of the disc with its free rim.",
            autocompletion=completion.models,
        ),
    ] = None,
    joint: Annotated[bool, typer.Option("--joint", help="Fit one modulus law to all bursts at once.")] = False,
    law: Annotated[
        str,
        typer.Option(
            help="The law of a joint fit, or auto: the most probable of several, which are compared.",
            autocompletion=completion.fitted_laws,
        ),
    ] = "fractional_zener",
    elements: Annotated[int | None, typer.Option(help="Branches of laws that have them, as maxwell.")] = None,
    posterior: Annotated[
        str | None,
        typer.Option(
            metavar="METHOD",
            help="Of joint and stack fits: laplace (default), profile, or nested (slow, needs dynesty).",
            autocompletion=completion.posteriors,
        ),
    ] = None,
    jobs: Annotated[int, typer.Option("--jobs", metavar="N", help="Processes for several campaigns.")] = 1,
    cluster: Annotated[
        str | None, typer.Option("--cluster", metavar="ADDRESS", help="A Dask scheduler, for several campaigns.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Leave out what was done with the same input.")] = False,
    figures: Figures = True,
) -> None:
    """Find the complex modulus E1 + i E2 of a sample on the two-plate rig, burst by burst, or one law for all of them.

    Or, of a stack-fit file, fields of stacks from tube, transmission, vibration and modulus data (docs/stack-fit.md).

    Writes moduli.csv, fit.json (joint.json), report.html and figures; of several campaigns each into a folder of its
    own, as soon as it is done, and a summary. Exit status: 0 all accepted, 1 some have no accepted solution (everything
    is written all the same), 2 the input cannot be used (nothing is written), 130 stopped by Ctrl-C (what is done
    stays).

    Example: multilayer fit examples/foam_b --out results/foam_b

    Example: multilayer fit examples/foam_tube --out results/foam_tube

    Example: multilayer fit examples/foam_b --joint --law fractional_zener --model finite

    Example: multilayer fit examples/foam_b --joint --model finite --law auto

    Example: multilayer fit examples/foam_b --joint --model finite --posterior profile

    Example: multilayer fit campaigns/* --out results --jobs 4 --resume
    """
    from multilayer.fits.sources import is_stack_fit
    from multilayer.report.fit_outcome import FitTask

    if len(sources) == 1 and is_stack_fit(sources[0]):
        from multilayer.cli.stack_fit import fit_stack_file

        others = {"--method": method, "--model": model, "--joint": joint, "--elements": elements}
        others |= {"--cluster": cluster, "--resume": resume}
        return fit_stack_file(sources[0], out, as_json, figures, others, posterior)
    task = FitTask(sources[0], method, model, joint, law, elements, figures, posterior)
    if len(sources) == 1:
        accepted = _fit_one(task, out, as_json, resume)
    else:
        from multilayer.cli.fit_many import fit_many

        accepted = fit_many(
            task, sources, out or Path("results"), jobs=jobs, cluster=cluster, resume=resume, as_json=as_json
        )
    if not accepted:
        raise typer.Exit(1)
    return None


def _fit_one(task: FitTask, out: Path | None, as_json: bool, resume: bool) -> bool:
    """Fit one campaign, write and print; tell whether all is accepted."""
    from multilayer.cli.progress import progress_bar
    from multilayer.report.fit_outcome import done_before, number_of_steps, report_of, run_fit, summary_of

    job = task.read()
    name = job.campaign.folder.resolve().name
    folder = folder_for(out, f"{name}-joint" if task.joint else name)
    if resume and done_before(task, job, folder):
        row = summary_of(task, folder)
        if as_json:
            typer.echo((folder / task.record).read_text(encoding="utf-8"), nl=False)
        typer.echo(f"{folder} holds the result of the same input: nothing to do", err=as_json)
        return bool(row["accepted"] == row["of"] and not row["remark"])
    with progress_bar("fit", number_of_steps(task, job)) as advance:
        result = run_fit(task, job, advance)
    finish(report_of(task, job, result), folder, as_json=as_json, figures=task.figures)
    return True
