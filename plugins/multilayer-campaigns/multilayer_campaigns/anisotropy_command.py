"""``multilayer anisotropy``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli.options import AsJson, Figure, Model, finish, folder_for

if TYPE_CHECKING:
    from multilayer.measurements.description import Campaign


def anisotropy(
    sources: Annotated[
        list[Path],
        typer.Argument(metavar="CAMPAIGN_X CAMPAIGN_Y CAMPAIGN_Z", help="Campaigns or fit files, one for each axis."),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Where results go; results/anisotropy when left out."),
    ] = None,
    as_json: AsJson = False,
    model: Model = None,
    scatter: Annotated[
        float,
        typer.Option(help="Relative scatter of moduli from piece to piece, as 0.05; 0 where one cube was turned."),
    ] = 0.0,
    separate: Annotated[
        bool, typer.Option("--separate", help="Other channels or plates for each axis: none of their errors cancels.")
    ] = False,
    figures: Figure = True,
) -> None:
    """Compare the complex modulus along three axes: a cube that is turned, or three discs cut along x, y and z.

    Writes anisotropy.csv, anisotropy.json and anisotropy.png: E1 and E2 by axis and frequency, their ratios to the mean
    of the axes, in which the common errors of one rig cancel, and a test of isotropy. Exit status: 0 done, whatever is
    found, 2 the input cannot be used (nothing is written).

    Example: multilayer anisotropy campaigns/along-x campaigns/along-y campaigns/along-z --out results/anisotropy
    """
    from multilayer.cli.progress import progress_bar
    from multilayer_campaigns.anisotropy import compare_axes, of_all_axes
    from multilayer_campaigns.anisotropy_report import anisotropy_report
    from multilayer_campaigns.multi_campaign import common_errors, fit_several, read_several, steps_of_several

    _refuse(sources, scatter)
    jobs = read_several(sources, model)
    of_all_axes([job.campaign.folder.name for job in jobs], [_frequencies(job.campaign) for job in jobs])
    folder = folder_for(out, "anisotropy")
    with progress_bar("anisotropy", steps_of_several(jobs)) as advance:
        fitted = fit_several(jobs, advance)
    common = frozenset[str]() if separate else common_errors(jobs)
    result = compare_axes(fitted.names, fitted.points, common=common, scatter=scatter, remarks=fitted.remarks)
    finish(anisotropy_report(result), folder, as_json=as_json, figures=figures)


def _refuse(sources: list[Path], scatter: float) -> None:
    from multilayer.errors import InputError

    if len(sources) != 3:
        text = "anisotropy needs three campaigns, measured along x, y and z in this order"
        raise InputError(f"{text}; {len(sources)} {'is' if len(sources) == 1 else 'are'} named")
    if not 0 <= scatter <= 1:
        raise InputError(f"--scatter: {scatter:g} is not allowed; a relative standard deviation from 0 to 1")


def _frequencies(campaign: Campaign) -> set[float]:
    return {burst.frequency for one in campaign.configurations for burst in one.bursts}
