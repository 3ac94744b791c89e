"""``multilayer fit``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from multilayer.inverse.result import FitResult
    from multilayer.inverse.settings import FitSettings
    from multilayer.measurements.campaign import Campaign


def fit(
    source: Annotated[
        Path,
        typer.Argument(metavar="FILE_OR_CAMPAIGN", help="A campaign folder, its campaign.yaml, or a fit file."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME when left out."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the results as JSON in place of the table.")] = False,
    method: Annotated[
        str | None,
        typer.Option(help="least-squares (default) or nelder-mead (the 2015 paper to the letter)."),
    ] = None,
    model: Annotated[
        str | None,
        typer.Option(help="plane_wave (default), or finite: finite elements of the disc with its free rim."),
    ] = None,
    joint: Annotated[bool, typer.Option("--joint", help="Fit one modulus law to all bursts at once.")] = False,
    law: Annotated[str, typer.Option(help="The law of a joint fit.")] = "fractional_zener",
    elements: Annotated[int | None, typer.Option(help="Branches of laws that have them, as maxwell.")] = None,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figures.")] = True,
) -> None:
    """Find the complex modulus E1 + i E2 of a sample on the two-plate rig, burst by burst, or one law for all of them.

    Writes moduli.csv, fit.json and figures. Exit status: 0 all bursts accepted, 1 some have no accepted solution
    (everything is written all the same), 2 the input cannot be used (nothing is written).

    Example: multilayer fit examples/foam_b --out results/foam_b

    Example: multilayer fit examples/foam_b --joint --law fractional_zener --model finite
    """
    from multilayer.cli.progress import progress_bar
    from multilayer.inverse.fit import fit_campaign, number_of_steps
    from multilayer.inverse.sources import read_fit
    from multilayer.report.files import refuse_unusable
    from multilayer.report.fit_table import fit_table

    job = read_fit(source, method, model)
    if joint:
        from multilayer.cli.joint_fit import fit_one_law

        fit_one_law(job, law, elements, out, as_json, figures)
        return
    refuse_unusable(out or Path("results"))
    with progress_bar("fit", number_of_steps(job.campaign, job.settings)) as advance:
        result = fit_campaign(job.campaign, job.recordings, job.settings, job.calibration, advance)
    folder = out or Path("results") / result.campaign
    written = _write(folder, result, job.campaign, job.settings, figures)
    if as_json:
        typer.echo(json.dumps(result.to_dict(), indent=1))
    else:
        fit_table(result)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")
    if not result.all_accepted:
        raise typer.Exit(1)


def _write(folder: Path, result: FitResult, campaign: Campaign, settings: FitSettings, figures: bool) -> list[Path]:
    from multilayer.report.files import write_files

    files: dict[str, bytes | str] = {
        "moduli.csv": result.to_csv(),
        "fit.json": json.dumps(result.to_dict(), indent=1) + "\n",
    }
    if figures:
        from multilayer.report.fit_figures import fit_figures

        files.update(fit_figures(result, campaign, settings))
    return write_files(folder, files)
