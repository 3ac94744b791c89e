"""``multilayer effects``."""

from __future__ import annotations

from typing import Annotated

import typer

from multilayer.cli import completion


def effects(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[EFFECT]...", help="All when left out.", autocompletion=completion.effects),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the list as JSON.")] = False,
) -> None:
    """List the effects that a diagnosis knows, with their laws and what separates them.

    Example: multilayer effects
    """
    from multilayer.json_text import json_text
    from multilayer.report.effect_table import describe_effects, effect_table

    described = describe_effects(names)
    if as_json:
        typer.echo(json_text(described), nl=False)
    else:
        effect_table(described)
