"""``multilayer examples``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import ListAsJson, finish


def examples(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[NAME]...", help="Which to copy.", autocompletion=completion.examples),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="DIR", help="Folder for the copies, 'examples' by default; alone: all of them."),
    ] = None,
    as_json: ListAsJson = False,
) -> None:
    """List the examples that every help text names, or copy them to a folder.

    Example: multilayer examples

    Example: multilayer examples foam_b double_wall --out examples
    """
    from multilayer.examples import copy_examples
    from multilayer.report.examples import examples_report

    is_copied = bool(names) or out is not None
    if is_copied:
        for place in copy_examples(names or [], out or Path("examples")):
            typer.echo(f"written to {place}", err=as_json)
    if as_json or not is_copied:
        finish(examples_report(names or []), as_json=as_json)
