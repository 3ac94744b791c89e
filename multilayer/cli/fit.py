"""``multilayer fit``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import AsJson, Figures, Model, Out, finish, folder_for

if TYPE_CHECKING:
    from multilayer.experiments.two_plate.campaign import Acting
    from multilayer.fits.run import FitTask


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
            help="least-squares (default), nelder-mead (the 2015 paper to the letter), or any other that "
            "`multilayer methods` lists.",
            autocompletion=completion.methods,
        ),
    ] = None,
    model: Model = None,
    joint: Annotated[bool, typer.Option("--joint", help="Fit one modulus law to all bursts at once.")] = False,
    law: Annotated[
        str | None,
        typer.Option(
            help="The law of a joint fit, fractional_zener by default, or auto: the most probable of several, which "
            "are compared.",
            autocompletion=completion.fitted_laws,
        ),
    ] = None,
    elements: Annotated[
        int | None, typer.Option(min=1, help="Branches of maxwell, frequencies of free_form, at least 1.")
    ] = None,
    posterior: Annotated[
        str | None,
        typer.Option(
            metavar="METHOD",
            help="Of joint and stack fits: laplace (default), profile, or nested (slow, needs dynesty).",
            autocompletion=completion.posteriors,
        ),
    ] = None,
    lateral: Annotated[
        str | None,
        typer.Option(
            metavar="KIND",
            help="What the rod of the transfer-function method is: bonded (default), slender, or held.",
            autocompletion=completion.laterals,
        ),
    ] = None,
    known: Annotated[
        list[str] | None,
        typer.Option(
            "--with",
            metavar="EFFECT_OR_FILE",
            help="An unmodelled effect that acts besides, by name, or the file of `diagnose --save-law`, or a "
            "diagnosis.json; its size is fitted with one law for all bursts (--joint). May be repeated.",
            autocompletion=completion.effects,
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

    Or, of a stack-fit file, fields of stacks from tube, transmission, vibration and modulus data.

    Writes moduli.csv, fit.json (joint.json), report.html and figures. Of several campaigns, a mistake in the input of
    one is told and nothing is fitted; then each is written into a folder of its own, as soon as it is done, and a
    summary, which has those whose fit failed, too, with the reason. Exit status: 0 all accepted, 1 some have no
    accepted solution or cannot be fitted (everything else is written all the same), 2 the input cannot be used (nothing
    is written), 130 stopped by Ctrl-C (what is done stays).

    Example: multilayer fit examples/foam_b --out results/foam_b

    Example: multilayer fit examples/foam_tube --out results/foam_tube

    Example: multilayer fit examples/foam_b --joint --law fractional_zener --model finite

    Example: multilayer fit examples/foam_b --joint --model finite --law auto

    Example: multilayer fit examples/foam_b --joint --model finite --posterior profile

    Example: multilayer fit examples/foam_b --method transfer-function

    Example: multilayer fit examples/foam_b --with sensor_mass

    Example: multilayer fit campaigns/* --out results --jobs 4 --resume
    """
    from multilayer.fits.run import FitTask

    given = _known(known) if known else None
    task = FitTask(sources[0], method, joint, model, law, elements, posterior, lateral, given)
    if len(sources) == 1:
        accepted = _fit_one(task, out, cluster, as_json=as_json, resume=resume, figures=figures)
    else:
        from multilayer.cli.fit_many import fit_many

        accepted = fit_many(
            task, sources, out or Path("results"), jobs, cluster, as_json=as_json, resume=resume, figures=figures
        )
    if not accepted:
        raise typer.Exit(1)


def _known(names: list[str]) -> tuple[Acting, ...]:
    from multilayer.diagnosis.saved_law import known_effects

    return tuple(effect for name in names for effect in known_effects(name))


def _fit_one(
    task: FitTask, out: Path | None, cluster: str | None, *, as_json: bool, resume: bool, figures: bool
) -> bool:
    """Fit what one file or folder says, write and print; tell whether all is accepted."""
    from multilayer.cli.progress import progress_bar
    from multilayer.config.validate import placed_in
    from multilayer.errors import InputError
    from multilayer.fits.run import is_accepted
    from multilayer.report.fits import fit_report

    with placed_in(task.source):
        fit = task.read()
    if fit.method.reads == "stack-fit" and (cluster or resume):
        option = "--cluster" if cluster else "--resume"
        raise InputError(f"{option} is of the fit of a campaign; {task.source} is a stack-fit file: leave it out")
    folder = folder_for(out, fit.folder_name)
    if resume and fit.done_in(folder):
        if as_json:
            typer.echo((folder / fit.record_name).read_text(encoding="utf-8"), nl=False)
        typer.echo(f"{folder} holds the result of the same input: nothing to do", err=as_json)
        return is_accepted(fit.summary_in(folder))
    with placed_in(task.source), progress_bar("fit", fit.number_of_steps) as advance:
        result = fit.run(advance)
    finish(fit_report(result, fit.job, fit.inputs), folder, as_json=as_json, figures=figures)
    return True
