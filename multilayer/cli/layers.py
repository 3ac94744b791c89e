"""``multilayer layers``."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def layers(
    as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """List the layer types a stack file may use, with their fields, units and defaults.

    Example: multilayer layers
    """
    from multilayer.report.layer_table import describe_layers, layer_table

    described = describe_layers()
    if as_json:
        typer.echo(json.dumps(described, indent=1, default=str))
    else:
        layer_table(described)
