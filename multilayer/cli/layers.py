"""``multilayer layers``."""

from __future__ import annotations

from typing import Annotated

import typer

from multilayer.cli import completion


def layers(
    types: Annotated[
        list[str] | None,
        typer.Argument(metavar="[TYPE]...", help="All when left out.", autocompletion=completion.layers),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """List the layer types a stack file may use, with their fields, units and defaults.

    Example: multilayer layers

    Example: multilayer layers poroelastic screen
    """
    from multilayer.json_text import json_text
    from multilayer.report.layer_table import describe_layers, layer_table

    described = describe_layers(types)
    if as_json:
        typer.echo(json_text(described), nl=False)
    else:
        layer_table(described)
