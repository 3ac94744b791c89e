"""``multilayer preload``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli.options import AsJson, Figure, Model, finish, folder_for


def preload(
    sources: Annotated[
        list[Path],
        typer.Argument(
            metavar="CAMPAIGN_OR_FIT_FILE",
            help="Campaigns or fit files on one material under several top plates.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/NAME-preload when left out."),
    ] = None,
    as_json: AsJson = False,
    model: Model = None,
    figures: Figure = True,
) -> None:
    """Find what the static weight of the top plate does to the modulus, and the modulus without any.

    Every burst is fitted by itself; E1 and loss factor of a specimen under several top plates give their slopes over
    the static stress, with the errors that the bursts share, and the values at zero stress. Writes preload.csv,
    preload.json and preload.png. Exit status: 0 done, whatever is found, 2 the input cannot be used (nothing is
    written).

    Example: multilayer preload campaigns/light campaigns/heavy --out results/preload
    """
    from multilayer.cli.progress import progress_bar
    from multilayer_campaigns.multi_campaign import fit_several, read_several, refuse_other_material, steps_of_several
    from multilayer_campaigns.preload import fit_preload, refuse_one_stress
    from multilayer_campaigns.preload_report import preload_report

    jobs = read_several(sources, model)
    refuse_other_material(jobs)
    refuse_one_stress([job.campaign for job in jobs], jobs[0].settings.sensor_mass)
    folder = folder_for(out, f"{jobs[0].name}-preload")
    with progress_bar("preload", steps_of_several(jobs)) as advance:
        fitted = fit_several(jobs, advance)
    result = fit_preload(fitted.names, fitted.points, fitted.remarks)
    finish(preload_report(result), folder, as_json=as_json, figures=figures)
