"""``multilayer effects``."""

from __future__ import annotations

from typing import Annotated

import typer

from multilayer.cli import completion
from multilayer.cli.options import ListAsJson, finish


def effects(
    names: Annotated[
        list[str] | None,
        typer.Argument(metavar="[EFFECT]...", help="All when left out.", autocompletion=completion.effects),
    ] = None,
    as_json: ListAsJson = False,
) -> None:
    """List the effects that a diagnosis knows, with their laws and what separates them.

    Example: multilayer effects
    """
    from multilayer.report.effects import effects_report

    finish(effects_report(names), as_json=as_json)
