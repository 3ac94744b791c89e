"""``multilayer plugins`` and ``multilayer plugins new``."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from multilayer.cli.options import ListAsJson, finish
from multilayer.cli.plugin_option import takes_plugins

plugins = typer.Typer(name="plugins", rich_markup_mode="markdown")


class Kind(StrEnum):
    """What a skeleton is made for."""

    layer = "layer"
    effect = "effect"
    law = "law"
    method = "method"
    reader = "reader"
    command = "command"


@plugins.callback(invoke_without_command=True)
@takes_plugins
def list_plugins(
    context: typer.Context,
    as_json: ListAsJson = False,
) -> None:
    """List layers, laws, effects, places, methods, readers, plugins' commands: their package, what is broken and why.

    Example: multilayer plugins

    Example: multilayer plugins new my-foam --kind layer
    """
    if context.invoked_subcommand is not None:
        return
    from multilayer.report.plugins import plugins_report

    finish(plugins_report(), as_json=as_json)


@plugins.command()
def new(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Of the package, as my-foam.")],
    kind: Annotated[Kind, typer.Option("--kind", help="What it brings.")],
    out: Annotated[
        Path, typer.Option("--out", metavar="DIR", help="Where the folder NAME is made, which must not exist yet.")
    ] = Path(),
) -> None:
    """Write the skeleton of a plugin: an installable package with a module, its test and a README, which works at once.

    Exit status: 0 done, 2 the name or the folder cannot be used (nothing is written).

    Example: multilayer plugins new my-foam --kind layer
    """
    from multilayer.errors import InputError
    from multilayer.plugins.skeleton import Skeleton
    from multilayer.writing.folders import write_new

    skeleton = Skeleton(name, kind.value)
    folder = out / name
    if folder.exists() or folder.is_symlink():
        raise InputError(f"{folder}: there is such a file or folder already; choose another --out, or remove it first")
    written = write_new(folder, skeleton.files())
    typer.echo(f"written to {folder}: {', '.join(written)}")
    typer.echo(f"test it: python -m pip install pytest, then python -m pytest {folder}")
    typer.echo(f"try it:  multilayer --plugin {folder / skeleton.module}.py plugins")
    typer.echo(f"install: python -m pip install --editable {folder}")
