"""Options that every command takes: ``--plugin FILE.py`` (before its name, too), ``--verbose`` and ``--quiet``."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

from multilayer.cli.loudness import Quiet, Verbose, loudness

PluginFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE.py",
        help="A Python file whose layers, laws, effects, methods, readers or commands shall be known; may be repeated.",
    ),
]


def takes_plugins(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the options that all have.

    What the files of ``--plugin`` define is registered while it runs.
    """
    name = command.__name__.replace("_", "-")

    @wraps(command)
    def run(plugin: list[Path] | None = None, verbose: bool = False, quiet: bool = False, **options: Any) -> None:
        from multilayer.writing.manifest import inputs_noted
        from multilayer.writing.workspace import claims

        with loudness(verbose=verbose, quiet=quiet), claims(), inputs_noted(name):
            if not plugin:
                return command(**options)
            from multilayer.plugins.files import plugin_files

            with plugin_files(plugin):
                return command(**options)

    hints = get_type_hints(command, include_extras=True)
    own = [one.replace(annotation=hints[name]) for name, one in inspect.signature(command).parameters.items()]
    common: dict[str, tuple[Any, Any]] = {
        "plugin": (None, PluginFiles),
        "verbose": (False, Verbose),
        "quiet": (False, Quiet),
    }
    keyword = inspect.Parameter.KEYWORD_ONLY
    added = [inspect.Parameter(name, keyword, default=value, annotation=kind) for name, (value, kind) in common.items()]
    run.__annotations__ = {**hints, **{name: kind for name, (_, kind) in common.items()}}
    run.__signature__ = inspect.Signature([*own, *added])  # type: ignore[attr-defined]  # typer reads it
    return run
