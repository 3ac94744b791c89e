"""``multilayer fit`` of a stack-fit file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import typer

if TYPE_CHECKING:
    from multilayer.fits.stacks.result import StackFitResult


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
    from multilayer.json_text import json_text
    from multilayer.report.files import refuse_unusable, write_files
    from multilayer.report.stack_fit import stack_fit_table

    for option, value in campaign_options.items():
        if value:
            raise InputError(f"{option} is of the fit of a campaign; {source} is a stack-fit file: leave it out")
    method = posterior or LAPLACE
    refuse_method(method)
    file = load_stack_fit(source)
    name = name_of(source)
    folder = out or Path("results") / name
    refuse_unusable(folder)
    with progress_bar("fit", file.search.starts + 1) as advance:
        result = fit_stacks(file, name, advance, method)
    for text in result.warnings:
        typer.echo(f"warning: {' '.join(text.split())}", err=True)
    written = write_files(folder, _files(result, figures))
    if as_json:
        typer.echo(json_text(result.to_dict()), nl=False)
    else:
        stack_fit_table(result)
        typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")
    if not result.converged:
        raise typer.Exit(1)


def _files(result: StackFitResult, figures: bool) -> dict[str, bytes | str]:
    from multilayer.json_text import json_text
    from multilayer.report.files import file_names

    files: dict[str, bytes | str] = {
        "parameters.csv": result.parameters_csv(),
        "curves.csv": result.curves_csv(),
        "fit.json": json_text(result.to_dict()),
    }
    texts = result.stack_files()
    files |= {f"fitted-{name}.yaml": text for name, text in zip(file_names(list(texts)), texts.values(), strict=True)}
    if figures:
        from multilayer.report.stack_fit import stack_fit_figures
        from multilayer.report.stack_fit_html import stack_fit_html

        files["report.html"] = stack_fit_html(result)
        files |= stack_fit_figures(result)
    return files
