"""``multilayer materials``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import ListAsJson, finish


def materials(
    names: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[NAME]...",
            help="Names, or parts of names; all when left out.",
            autocompletion=completion.materials,
        ),
    ] = None,
    library: Annotated[
        Path | None,
        typer.Option("--library", metavar="FILE", help="A library of your own, in place of the built-in one."),
    ] = None,
    as_json: ListAsJson = False,
) -> None:
    """List the materials that stack files may name, with the layer type and the source of their values.

    Of those named all values are shown, as they stand in the library.

    Example: multilayer materials

    Example: multilayer materials glass_wool
    """
    from multilayer.report.materials import materials_report

    finish(materials_report(names, library), as_json=as_json)
