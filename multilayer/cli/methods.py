"""``multilayer methods``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import AsJson, Figure, Out, finish, folder_for
from multilayer.errors import InputError


def methods(
    source: Annotated[
        Path | None,
        typer.Argument(
            metavar="[CAMPAIGN_OR_FIT_FILE]",
            help="A campaign folder, its campaign.yaml, or a fit file; without one, the methods are listed.",
        ),
    ] = None,
    out: Out = None,
    as_json: AsJson = False,
    everything: Annotated[
        bool, typer.Option("--all", help="With slow methods, as the paper's Nelder-Mead: some seconds per burst.")
    ] = False,
    lateral: Annotated[
        str,
        typer.Option(
            metavar="KIND",
            help="What the rod of the transfer function is: bonded (glued disc, static shape factor), slender, or held "
            "(cannot widen).",
            autocompletion=completion.laterals,
        ),
    ] = "bonded",
    adhesive: Annotated[
        bool,
        typer.Option(
            "--adhesive",
            help="Check the adhesive alone: the campaign (rig: calibration) has the two plates glued together.",
        ),
    ] = False,
    calibration: Annotated[
        Path | None,
        typer.Option("--calibration", metavar="CAMPAIGN", help="With --adhesive: both accelerometers at one spot."),
    ] = None,
    figures: Figure = True,
) -> None:
    """Find the complex modulus of a sample by every method, and put them side by side.

    Burst-by-burst least squares (plane waves, and finite elements with the free rim), the acceptance region of eq.
    (10), the transfer function of a rod, the quasi-static method, with --all the paper's Nelder-Mead, and whatever
    plugins bring. Writes methods.csv, methods.json and methods.png. Exit status: 0 done, whatever the methods say, 2
    the input cannot be used (nothing is written).

    Without a campaign, lists all inverse methods by the names that `multilayer fit --method` takes.

    With --adhesive, the paper's check of the glue: whether the transmissibility of two plates glued together without a
    sample is 1 within the noise, and up to which frequency (adhesive.csv, adhesive.json, adhesive.png).

    Example: multilayer methods examples/foam_b --out results/foam_b

    Example: multilayer methods glued_plates --adhesive --calibration one_spot
    """
    if source is None:
        return _list(as_json)
    if adhesive:
        return _adhesive(source, calibration, out, as_json, figures)
    if calibration is not None:
        raise InputError("--calibration is of --adhesive; a fit file names the calibration of a campaign")
    from multilayer.cli.progress import progress_bar
    from multilayer.fits.classical.compare import compare_methods, number_of_steps_of_all
    from multilayer.fits.sources import read_fit
    from multilayer.report.methods import methods_report

    job = read_fit(source)
    folder = folder_for(out, job.name)
    with progress_bar("methods", number_of_steps_of_all(job.campaign, job.settings, slow=everything)) as advance:
        comparison = compare_methods(
            job.campaign, job.recordings, job.settings, job.calibration,
            slow=everything, lateral=lateral, progress=advance,
        )  # fmt: skip
    return finish(methods_report(comparison), folder, as_json=as_json, figures=figures)


def _adhesive(source: Path, calibration: Path | None, out: Path | None, as_json: bool, figures: bool) -> None:
    """Check an adhesive, write and print."""
    from multilayer.measurements.campaign import load_calibration
    from multilayer.report.adhesive import adhesive_report
    from multilayer.signals.adhesive import check_adhesive

    name = (source if source.is_dir() else source.parent).resolve().name
    folder = folder_for(out, name)
    glued = load_calibration(source)
    check = check_adhesive(name, glued, None if calibration is None else load_calibration(calibration))
    finish(adhesive_report(check), folder, as_json=as_json, figures=figures)


def _list(as_json: bool) -> None:
    """List the registered methods."""
    from multilayer.config.kinds import TITLES
    from multilayer.fits.methods import METHODS
    from multilayer.json_text import json_text

    listed = [
        {
            "method": name,
            "summary": kind.summary,
            "reads": kind.reads,
            "options": [kind.written(option) for option in kind.options()],
        }
        for name, kind in METHODS.working()
    ]
    if as_json:
        typer.echo(json_text(listed), nl=False)
        return
    for entry in listed:
        typer.echo(f"{entry['method']:20}{entry['summary']}")
        typer.echo(f"{'':20}of a {TITLES[str(entry['reads'])]}; {', '.join(entry['options']) or 'no options'}")
