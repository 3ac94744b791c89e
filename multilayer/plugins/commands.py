"""Commands that plugins bring to the command line."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping
from types import FunctionType
from typing import TYPE_CHECKING, Any

from multilayer.registry import Registry

if TYPE_CHECKING:
    import typer

BUILT_IN = frozenset({
    "simulate", "optimise", "compare", "explore", "fit", "methods", "diagnose", "effects", "shape-factor", "rig",
    "import", "export", "tube", "layers", "materials", "examples", "check", "schema", "plugins",
})  # fmt: skip
"""Names that no plugin may take; these commands start without importing any plugin."""
_OF_EVERY_COMMAND = {"plugin", "verbose", "quiet"}
_NAMED = (inspect.Parameter.POSITIONAL_OR_KEYWORD, inspect.Parameter.KEYWORD_ONLY)


def application(name: str, function: Callable[..., None]) -> typer.Typer:
    """Return an application of a single command.

    Parameters
    ----------
    name : str
    function : callable
        Its annotated parameters are arguments and options, its docstring is the help.
    """
    import typer

    made = typer.Typer(add_completion=False, pretty_exceptions_enable=False, rich_markup_mode="markdown")
    made.command(name, rich_help_panel="Commands of plugins")(function)
    return made


def _fault(name: str, item: Any) -> str:
    if name in BUILT_IN:
        return "a built-in command has this name; choose another one"
    if not isinstance(item, FunctionType):
        return f"it is {item!r}, not a function"
    if fault := _parameters_fault(inspect.signature(item).parameters):
        return fault
    from typer.main import get_command

    try:
        get_command(application(name, item))
    except Exception as error:  # typer raises many kinds for annotations that it cannot read
        return f"its parameters make no command: {type(error).__name__}: {' '.join(str(error).split())}"
    return ""


def _parameters_fault(parameters: Mapping[str, inspect.Parameter]) -> str:
    if taken := _OF_EVERY_COMMAND & set(parameters):
        return f"it has a parameter '{min(taken)}', an option that every command has; choose another name"
    if any(parameter.kind not in _NAMED for parameter in parameters.values()):
        return "it has parameters that cannot be given by name, as *args; name every one"
    bare = [one.name for one in parameters.values() if one.annotation is one.empty]
    if bare:
        return f"its parameter '{bare[0]}' has no annotation; write the type that it is read as, as '{bare[0]}: float'"
    return ""


COMMANDS: Registry[Callable[..., None]] = Registry("multilayer.commands", "command", _fault)
