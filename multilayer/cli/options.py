"""Options that many commands take, and how each of them ends."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.warned import tell, told

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from multilayer.report.report import Report

Out = Annotated[Path | None, typer.Option("--out", metavar="DIR", help="Where results go; results/NAME when left out.")]
AsJson = Annotated[bool, typer.Option("--json", help="Print the results as JSON in place of the table.")]
ListAsJson = Annotated[bool, typer.Option("--json", help="Print the list as JSON.")]
Figures = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw figures and the HTML report.")]
Figure = Annotated[bool, typer.Option("--figures/--no-figures", help="Draw the figure.")]
Model = Annotated[
    str | None,
    typer.Option(
        help="plane_wave (default), or finite: finite elements of the disc with its free rim.",
        autocompletion=completion.models,
    ),
]
Jobs = Annotated[int, typer.Option("--jobs", metavar="N", help="Processes of this machine to compute with.")]
Cluster = Annotated[
    str | None,
    typer.Option(
        "--cluster", metavar="ADDRESS", help="A Dask scheduler whose workers compute, as tcp://10.0.0.1:8786."
    ),
]


def quantities(option: str, text: str, unit: str) -> tuple[float, ...]:
    """Return the values of an option, several with commas, in a unit; those with a unit must be above 0.

    Raises
    ------
    InputError
    """
    from multilayer.errors import InputError
    from multilayer.units import parse_quantity

    try:
        values = tuple(parse_quantity(part, unit) for part in text.split(","))
    except ValueError as error:
        raise InputError(f"{option}: {error}") from None
    if unit and not all(0 < value < float("inf") for value in values):
        raise InputError(f"{option}: {text} is not allowed; it must be above 0")
    return values


def quantity(option: str, text: str | None, unit: str) -> float:
    """Return the value of an option that is needed.

    Raises
    ------
    InputError
    """
    from multilayer.errors import InputError

    if text is None:
        raise InputError(f"{option}: is missing; it is needed here, as {option} '1 {unit}'")
    values = quantities(option, text, unit)
    if len(values) != 1:
        raise InputError(f"{option}: one value is wanted, not {len(values)}")
    return values[0]


def folder_for(out: Path | None, name: str) -> Path:
    """Return where results go, claimed for this run, or refused before anything is computed.

    Raises
    ------
    InputError
    """
    from multilayer.errors import InputError
    from multilayer.writing.folders import claim_folder

    if out is None and name in (".", ".."):  # of files such as '...yaml'
        raise InputError(f"results/{name} is no folder of its own; say --out DIR, or rename the file")
    folder = out or Path("results") / name
    claim_folder(folder)
    return folder


def finish(
    report: Report,
    folder: Path | None = None,
    *,
    as_json: bool = False,
    figures: bool = True,
    executor: Executor | None = None,
) -> None:
    """Write a report's files, print it or its record as JSON, and say where the files are.

    What the command has warned of goes into the record and onto the page.

    Parameters
    ----------
    report : Report
    folder : Path, optional
        For the files; none are written when left out.
    as_json, figures : bool
    executor : Executor, optional
        Where figures are drawn; in this process when left out.

    Raises
    ------
    Exit
        With status 1 where the report does not accept the result.
    """
    from multilayer.report.console import show

    tell(report.warnings)
    if report.record_file:  # what a folder holds says what to mind, also when the terminal is gone
        report = replace(report, warnings=told() or report.warnings)
    written = _written(report, folder, figures=figures, executor=executor) if folder else []
    if as_json:
        typer.echo(report.json, nl=False)
    else:
        show(report)
        if written:
            typer.echo(f"written to {folder}: {', '.join(path.name for path in written)}")
    if not report.accepted:
        raise typer.Exit(1)


def _written(report: Report, folder: Path, *, figures: bool, executor: Executor | None) -> list[Path]:
    from multilayer.writing.folders import write_files
    from multilayer.writing.manifest import running

    return write_files(folder, report.files(figures=figures, executor=executor), made_by=running())
