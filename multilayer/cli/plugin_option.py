"""``--plugin FILE.py``, which every command takes, before its name or after."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Annotated, Any, get_type_hints

import typer

PluginFiles = Annotated[
    list[Path] | None,
    typer.Option(
        "--plugin",
        metavar="FILE.py",
        help="A Python file whose layers, laws, effects, methods, readers or commands shall be known; may be repeated.",
    ),
]


def takes_plugins(command: Callable[..., None]) -> Callable[..., None]:
    """Return a command with the option ``--plugin``; what its files define is registered while it runs."""

    @wraps(command)
    def run(plugin: list[Path] | None = None, **options: Any) -> None:
        if not plugin:
            return command(**options)
        from multilayer.plugins.files import plugin_files

        with plugin_files(plugin):
            return command(**options)

    hints = get_type_hints(command, include_extras=True)
    own = [one.replace(annotation=hints[name]) for name, one in inspect.signature(command).parameters.items()]
    option = inspect.Parameter("plugin", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=PluginFiles)
    run.__annotations__ = {**hints, "plugin": PluginFiles}
    run.__signature__ = inspect.Signature([*own, option])  # type: ignore[attr-defined]  # typer reads it
    return run
