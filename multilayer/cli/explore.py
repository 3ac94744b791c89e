"""``multilayer explore``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Measured = Annotated[
    list[Path] | None,
    typer.Option("--measured", metavar="FILE", help="Measured spectra to show beside, as compare reads them; repeat."),
]


def explore(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A stack file, or a simulation file.")],
    measured: Measured = None,
    port: Annotated[int, typer.Option(help="Of the loopback address; any that is free when left out.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Open a page on which a stack is changed by sliders, while its curves and ratings follow.

    The page is served to this machine only, at an address with a token, until Ctrl-C; it needs no network. It writes
    nothing but the stack and simulation files that are saved there. Exit status: 0 ended, 2 the input cannot be used.

    Example: multilayer explore examples/foam_absorption.yaml
    """
    from multilayer.cli.loudness import LOUDNESS
    from multilayer.explore.explorer import Explorer
    from multilayer.explore.server import Server
    from multilayer.simulation.measured import read_measured

    explorer = Explorer(file, [read_measured(path) for path in measured or ()])
    with Server(explorer, port) as server:
        typer.echo(server.url)
        if LOUDNESS.warnings:
            typer.echo("Ctrl-C ends it; what is not saved is lost.", err=True)
        if browser:
            _open(server.url)
        try:
            server.serve_forever(poll_interval=0.2)
        except KeyboardInterrupt:
            typer.echo("ended", err=True)


def _open(url: str) -> None:
    """Open a page where there is a screen: without one, a browser of the terminal would take the terminal."""
    import os
    import sys
    import webbrowser

    if sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"):
        webbrowser.open(url)
