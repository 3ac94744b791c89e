"""``multilayer layers``."""

from __future__ import annotations

from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import ListAsJson, finish


def layers(
    types: Annotated[
        list[str] | None,
        typer.Argument(metavar="[TYPE]...", help="All when left out.", autocompletion=completion.layers),
    ] = None,
    as_json: ListAsJson = False,
) -> None:
    """List the layer types a stack file may use, with their fields, units and defaults.

    Example: multilayer layers

    Example: multilayer layers poroelastic screen
    """
    from multilayer.report.layers import layers_report

    finish(layers_report(types), as_json=as_json)
