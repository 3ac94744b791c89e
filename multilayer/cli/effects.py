"""``multilayer effects``."""

from __future__ import annotations

import json
from typing import Annotated

import typer


def effects(as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False) -> None:
    """List the effects that a diagnosis knows, with their laws and what separates them.

    Example: multilayer effects
    """
    from multilayer.report.effect_table import describe_effects, effect_table

    described = describe_effects()
    if as_json:
        typer.echo(json.dumps(described, indent=1, default=str))
    else:
        effect_table(described)
