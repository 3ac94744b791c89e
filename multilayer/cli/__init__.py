"""The command line: one file per command; heavy imports wait until a command runs."""

from __future__ import annotations

import gc
import io
import os
import signal
import sys
import traceback
from itertools import pairwise
from pathlib import Path
from threading import current_thread, main_thread

import typer

from multilayer.cli.check import check
from multilayer.cli.compare import compare
from multilayer.cli.diagnose import diagnose
from multilayer.cli.effects import effects
from multilayer.cli.examples import examples
from multilayer.cli.explore import explore
from multilayer.cli.export import export
from multilayer.cli.fit import fit
from multilayer.cli.import_ import import_campaign
from multilayer.cli.layers import layers
from multilayer.cli.materials import materials
from multilayer.cli.methods import methods
from multilayer.cli.optimise import optimise
from multilayer.cli.plugin_commands import STOPPED, Commands
from multilayer.cli.plugin_option import PluginFiles, takes_plugins
from multilayer.cli.plugins import plugins
from multilayer.cli.rig import rig
from multilayer.cli.schema import schema
from multilayer.cli.shape_factor import shape_factor
from multilayer.cli.simulate import simulate
from multilayer.cli.tube import tube
from multilayer.cli.warned import warnings_as_lines

app = typer.Typer(
    name="multilayer",
    cls=Commands,
    help="Layered panels and samples in vibro-acoustics: simulate them, fit them to measurements, say why they differ.",
    no_args_is_help=True,
    add_completion=True,
    pretty_exceptions_enable=False,
    rich_markup_mode="markdown",
)


@app.callback(invoke_without_command=True)
def _options(
    version: bool = typer.Option(False, "--version", help="Print the version and stop."),
    plugin: PluginFiles = None,  # read in Commands.invoke
) -> None:
    if version:
        from importlib.metadata import version as version_of

        typer.echo(version_of("multilayer"))
        raise typer.Exit


app.command()(takes_plugins(simulate))
app.command()(takes_plugins(optimise))
app.command()(takes_plugins(compare))
app.command()(takes_plugins(explore))
app.command()(takes_plugins(fit))
app.command()(takes_plugins(methods))
app.command()(takes_plugins(diagnose))
app.command()(takes_plugins(effects))
app.command("shape-factor")(takes_plugins(shape_factor))
app.command()(takes_plugins(rig))
app.command()(takes_plugins(export))
app.command("import")(takes_plugins(import_campaign))
app.command()(takes_plugins(tube))
app.command()(takes_plugins(layers))
app.command()(takes_plugins(materials))
app.command()(takes_plugins(examples))
app.command()(takes_plugins(check))
app.command()(takes_plugins(schema))
app.add_typer(plugins)


def main() -> None:
    """Run the command line; every mistake of the user's ends with a message and exit status 2."""
    from multilayer.doors import guarded_streams
    from multilayer.threads import one_thread

    one_thread()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a pipe may lack the Greek letters of a table
    with guarded_streams():
        _run()


def _run() -> None:
    from multilayer.errors import MultilayerError
    from multilayer.limits import require_memory

    is_main = current_thread() is main_thread()  # nobody else may say what signals do
    before = signal.signal(signal.SIGTERM, _stopped) if is_main else None
    try:
        with warnings_as_lines():
            require_memory()
            app(prog_name="multilayer")
    except SystemExit as end:
        if end.code == STOPPED:
            for stream in (sys.stdout, sys.stderr):
                stream.flush()
            os._exit(STOPPED)  # a pool's thread may wait for processes that were killed, and Python for the thread
        raise
    except MultilayerError as error:
        typer.echo(str(error), err=True)
        sys.exit(2)
    except Exception as error:
        if os.environ.get("MULTILAYER_DEBUG"):
            traceback.print_exception(error)  # here, where the streams are guarded: names stand in it
            sys.exit(1)
        from multilayer.cli.failures import failure

        named = tuple(Path(file) for before, file in pairwise(sys.argv) if before == "--plugin")
        text, status = failure(error, named)
        typer.echo(text, err=True)
        sys.exit(status)
    finally:
        if before is not None:
            signal.signal(signal.SIGTERM, before)
        gc.freeze()  # nothing is looked through when the process ends: that takes as long as many a command


def _stopped(number: int, frame: object) -> None:
    """Stop as for Ctrl-C: what is being written is put back, and processes of pools end."""
    raise KeyboardInterrupt(signal.Signals(number).name)
