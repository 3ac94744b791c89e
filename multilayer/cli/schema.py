"""``multilayer schema``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli import completion


def schema(
    kind: Annotated[
        str | None,
        typer.Argument(
            metavar="[KIND]",
            help="stack, simulation, fit, ...; all are listed without.",
            autocompletion=completion.kinds,
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="DIR", help="Write KIND.json there, of every kind without KIND.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print the list of kinds as JSON.")] = False,
) -> None:
    """Print the JSON Schema of a kind of file, by which editors complete and check it; plugins included.

    An editor with a YAML language server takes it from the first line of a file, a comment:
    `# yaml-language-server: $schema=schemas/stack.json`

    Example: multilayer schema stack

    Example: multilayer schema --out schemas
    """
    from multilayer.json_text import json_text
    from multilayer.kinds import KINDS, kind_named
    from multilayer.writing.folders import write_file
    from multilayer.writing.workspace import refuse_unusable

    chosen = list(KINDS.values()) if kind is None else [kind_named(kind)]
    if out is not None:
        texts = {f"{one.name}.json": json_text(one.schema()) for one in chosen}
        refuse_unusable(out)
        for name, text in texts.items():
            write_file(out / name, text)
        typer.echo(f"written to {out}: {', '.join(texts)}")
    elif kind is not None:
        typer.echo(json_text(chosen[0].schema()), nl=False)
    elif as_json:
        typer.echo(json_text([{"kind": one.name, "title": one.title} for one in chosen]), nl=False)
    else:
        for one in chosen:
            typer.echo(f"{one.name:14}{one.title}")
