"""The command line: one file per command; heavy imports wait until a command runs."""

from __future__ import annotations

import io
import os
import sys

import typer

from multilayer.cli.anisotropy import anisotropy
from multilayer.cli.blind_check import blind_check
from multilayer.cli.check import check
from multilayer.cli.compare import compare
from multilayer.cli.diagnose import diagnose
from multilayer.cli.effects import effects
from multilayer.cli.fit import fit
from multilayer.cli.import_ import import_campaign
from multilayer.cli.layers import layers
from multilayer.cli.methods import methods
from multilayer.cli.preload import preload
from multilayer.cli.rig import rig
from multilayer.cli.schema import schema
from multilayer.cli.shape_factor import shape_factor
from multilayer.cli.simulate import simulate
from multilayer.cli.tube import tube

app = typer.Typer(
    name="multilayer",
    help="Layered panels and samples in vibro-acoustics: simulate them, fit them to measurements, say why they differ.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


@app.callback(invoke_without_command=True)
def _options(version: bool = typer.Option(False, "--version", help="Print the version and stop.")) -> None:
    if version:
        from importlib.metadata import version as version_of

        typer.echo(version_of("multilayer"))
        raise typer.Exit


app.command()(simulate)
app.command()(compare)
app.command()(fit)
app.command()(methods)
app.command()(preload)
app.command()(anisotropy)
app.command()(diagnose)
app.command()(effects)
app.command("blind-check")(blind_check)
app.command("shape-factor")(shape_factor)
app.command()(rig)
app.command("import")(import_campaign)
app.command()(tube)
app.command()(layers)
app.command()(check)
app.command()(schema)


def main() -> None:
    """Run the command line; every mistake of the user's ends with a message and exit status 2."""
    from multilayer.errors import MultilayerError

    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a pipe may lack the Greek letters of a table
    try:
        app(prog_name="multilayer")
    except MultilayerError as error:
        typer.echo(str(error), err=True)
        sys.exit(2)
    except Exception as error:
        if os.environ.get("MULTILAYER_DEBUG"):
            raise
        name = type(error).__name__
        typer.echo(
            f"multilayer failed on something it should have foreseen ({name}: {error}). This is a bug: please "
            "report it, with what MULTILAYER_DEBUG=1 in the environment makes this command print.",
            err=True,
        )
        sys.exit(70)
