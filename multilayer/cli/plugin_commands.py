"""Commands of plugins beside the built-in ones: found by name, imported when they are run or help is asked for."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import typer
from typer.core import TyperGroup

from multilayer.cli.plugin_option import takes_plugins
from multilayer.doors import cut, for_terminal

_LONGEST = 1000  # characters of what typer says
_USAGE_ERROR: Any = typer.BadParameter.__base__  # which typer gives no public name
STOPPED = 130  # exit status after Ctrl-C
OF_THIS_PROJECT = {
    "preload": ("multilayer-campaigns", "plugins/multilayer-campaigns"),
    "anisotropy": ("multilayer-campaigns", "plugins/multilayer-campaigns"),
    "blind-check": ("multilayer-validation", "validation"),
}
"""Commands of other packages in this project's repository: the package, and its folder."""


@contextmanager
def _harmless_mistakes() -> Iterator[None]:
    """Show control characters as escapes in what typer is to say of arguments and options."""
    try:
        yield
    except _USAGE_ERROR as error:
        error.message = for_terminal(cut(error.message, _LONGEST))
        raise


@contextmanager
def _told_of_the_end() -> Iterator[None]:
    """Tell in a line, where a command is stopped, what it has written."""
    try:
        yield
    except (KeyboardInterrupt, ImportError) as error:
        # an extension module whose import Ctrl-C interrupts tells that it could not be initialised
        stop: BaseException | None = error
        while stop is not None and not isinstance(stop, KeyboardInterrupt):
            stop = stop.__cause__ or stop.__context__
        if stop is None:
            raise
        from multilayer.writing.workspace import written

        by = str(stop) or "Ctrl-C"
        what = f"{', '.join(map(str, dict.fromkeys(written)))} was written before" if written else "nothing was written"
        typer.echo(f"stopped by {by}: {what}", err=True)
        raise typer.Exit(STOPPED) from None


class Commands(TyperGroup):
    """The built-in commands, and those in `multilayer.plugins.commands.COMMANDS`; a broken one is told and left out."""

    def list_commands(self, ctx: Any) -> list[str]:
        """Return all names; while a shell completes a line no plugin is imported."""
        from multilayer.plugins.commands import COMMANDS

        names = COMMANDS.names() if ctx.resilient_parsing else [name for name, _ in COMMANDS.working()]
        return [*self.commands, *(name for name in names if name not in self.commands)]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """Return a command, or nothing where there is none that works."""
        if cmd_name in self.commands:
            return self.commands[cmd_name]
        from typer.main import get_command

        from multilayer.plugins.commands import COMMANDS, application
        from multilayer.registry import RegistryError

        try:
            return get_command(application(cmd_name, takes_plugins(COMMANDS[cmd_name])))
        except RegistryError:
            return None

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """Return name, command and arguments left.

        Raises
        ------
        MultilayerError
            For a command of a broken plugin, or of a known package that is not installed.
        click's UsageError
            For a name that nobody knows, with the nearest.
        """
        name = args[0]
        if name not in self.commands and not name.startswith("-") and not ctx.resilient_parsing:
            from multilayer.plugins.commands import COMMANDS

            if name in COMMANDS:
                _ = COMMANDS[name]  # which says why it cannot be used
            else:
                self._refuse_unknown(ctx, name, [*self.commands, *COMMANDS, *OF_THIS_PROJECT])
        return super().resolve_command(ctx, args)

    @staticmethod
    def _refuse_unknown(ctx: Any, name: str, known: Iterable[str]) -> None:
        if name in OF_THIS_PROJECT:
            from multilayer.errors import InputError

            package, folder = OF_THIS_PROJECT[name]
            raise InputError(
                f"'{name}' is a command of the package {package}, which is not installed; "
                f"in a copy of multilayer's repository: python -m pip install ./{folder}"
            )
        near = ", ".join(f"'{other}'" for other in get_close_matches(name, dict.fromkeys(known)))
        ctx.fail(f"No such command '{name}'" + (f". Did you mean {near}?" if near else "."))

    def make_context(self, *args: Any, **options: Any) -> Any:
        """Return the context of the command line."""
        with _told_of_the_end(), _harmless_mistakes():
            return super().make_context(*args, **options)

    def invoke(self, ctx: Any) -> Any:
        """Run a command, which may be that of a file named by ``--plugin`` before it."""
        if files := ctx.params["plugin"]:
            from multilayer.plugins.files import plugin_files

            ctx.with_resource(plugin_files([Path(file) for file in files]))  # old versions of typer have texts here
        with _told_of_the_end(), _harmless_mistakes():
            return super().invoke(ctx)
