"""``multilayer diagnose``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def diagnose(
    source: Annotated[
        Path, typer.Argument(metavar="CAMPAIGN", help="A campaign folder, its campaign.yaml, or a fit file.")
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME-diagnosis when left out."),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print diagnosis.json in place of the tables.")] = False,
    without: Annotated[
        list[str] | None, typer.Option("--without", metavar="EFFECT", help="Leave an effect out; may be repeated.")
    ] = None,
    law: Annotated[str, typer.Option(help="The modulus law of the nominal model.")] = "fractional_zener",
    seed: Annotated[int, typer.Option(help="Of the search's starting points.")] = 0,
    figures: Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures and the HTML report.")] = True,
) -> None:
    """Say where model and measurement disagree, which effect causes it, how far it shrinks.

    Writes diagnosis.json, figures and report.html. Exit status: 0 no gap, 1 a gap (whether its cause is known or not),
    2 the input cannot be used (nothing is written).

    Example: multilayer diagnose examples/foam_b --out results/why
    """
    from multilayer.cli.progress import progress_bar
    from multilayer.diagnosis.diagnose import N_STEPS, chosen_effects, diagnose_campaign
    from multilayer.errors import InputError, suggest
    from multilayer.inverse.sources import read_fit
    from multilayer.media.laws import LAWS
    from multilayer.report.diagnosis_files import diagnosis_files
    from multilayer.report.diagnosis_table import diagnosis_table
    from multilayer.report.files import refuse_unusable, write_files

    effects = chosen_effects(None, without or [])
    if law not in LAWS:
        raise InputError(f"--law: there is no law '{law}'; {suggest(law, LAWS.names())}")
    job = read_fit(source)
    folder = out or Path("results") / f"{job.campaign.folder.resolve().name}-diagnosis"
    refuse_unusable(folder)
    with progress_bar("diagnose", N_STEPS) as advance:
        result = diagnose_campaign(
            job.campaign, job.recordings, effects, law=law, calibration=job.calibration, seed=seed, progress=advance
        )
    written = write_files(folder, diagnosis_files(result, figures=figures))
    if as_json:
        typer.echo(result.to_json(), nl=False)
    else:
        diagnosis_table(result)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")
    if result.verdict != "no_gap":
        raise typer.Exit(1)
