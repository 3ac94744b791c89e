"""``multilayer fit`` of a stack-fit file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import typer

from multilayer.cli.options import finish, folder_for


def fit_stack_file(
    source: Path,
    out: Path | None,
    as_json: bool,
    figures: bool,
    campaign_options: Mapping[str, object],
    posterior: str | None = None,
) -> None:
    """Fit fields of stacks to measurements of them; see ``docs/stack-fit.md``.

    Parameters
    ----------
    source : Path
    out : Path or None
    as_json, figures : bool
    campaign_options : mapping
        Options that a campaign's fit has and this one has not, by name; None where not given.
    posterior : str or None
        Where intervals come from; one of `summary.METHODS`, of which the first where None.

    Raises
    ------
    Exit
        With status 1 when no minimum was reached.
    """
    from multilayer.cli.progress import progress_bar
    from multilayer.errors import InputError
    from multilayer.experiments.stacks.file import load_stack_fit, name_of
    from multilayer.fits.stacks.fit import fit_stacks
    from multilayer.inference.summary import LAPLACE
    from multilayer.inference.summary import refuse_unusable as refuse_method
    from multilayer.report.stack_fit import stack_fit_report

    for option, value in campaign_options.items():
        if value:
            raise InputError(f"{option} is of the fit of a campaign; {source} is a stack-fit file: leave it out")
    method = posterior or LAPLACE
    refuse_method(method)
    file = load_stack_fit(source)
    name = name_of(source)
    folder = folder_for(out, name)
    with progress_bar("fit", file.search.starts + 1) as advance:
        result = fit_stacks(file, name, advance, method)
    for text in result.warnings:
        typer.echo(f"warning: {' '.join(text.split())}", err=True)
    finish(stack_fit_report(result), folder, as_json=as_json, figures=figures)
