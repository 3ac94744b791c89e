"""``multilayer explore``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from multilayer.explore.questions import Questions

Measured = Annotated[
    list[Path] | None,
    typer.Option("--measured", metavar="FILE", help="Measured spectra to show beside, as compare reads them; repeat."),
]

_REDIRECTION = """\
<!DOCTYPE html>
<meta charset="utf-8">
<meta name="referrer" content="no-referrer">
<meta http-equiv="refresh" content="0; url={url}">
<title>multilayer explore</title>
<a href="{url}">multilayer explore</a>
"""


def explore(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A stack or simulation file; or a campaign (folder, campaign.yaml, fit file), or stacks with their "
            "measurements as diagnose reads them; or what diagnose wrote (folder, diagnosis.json).",
        ),
    ],
    measured: Measured = None,
    port: Annotated[int, typer.Option(help="Of the loopback address; any that is free when left out.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open the page in the browser.")] = True,
) -> None:
    """Open a page on which a stack, or a model beside its measurements, is changed by sliders while curves follow.

    Of a campaign, and of stacks with their measurements, the page shows data and model: unknowns are turned by hand,
    effects that the model lacks are added, and what is not held is fitted. Of a diagnosis it begins with the effects
    that were named, the nominal model beside.

    The page is served to this machine only, at an address with a token, until Ctrl-C; it needs no network. It writes
    nothing but the stack and simulation files that are saved there. Exit status: 0 ended, 2 the input cannot be used.

    Example: multilayer explore examples/foam_absorption.yaml

    Example: multilayer explore examples/foam_tube

    Example: multilayer explore results/foam_b-diagnosis
    """
    from multilayer.cli.loudness import LOUDNESS
    from multilayer.explore.server import Server

    explorer = _explorer(file, measured or [])
    with Server(explorer, port) as server:
        typer.echo(server.url)
        if LOUDNESS.warnings:
            typer.echo("Ctrl-C ends it; what is not saved is lost.", err=True)
        with _opened(server.url) if browser else nullcontext():
            try:
                server.serve_forever(poll_interval=0.2)
            except KeyboardInterrupt:
                typer.echo("ended", err=True)


def _explorer(file: Path, measured: list[Path]) -> Questions:
    """Return what answers the page of a file: a stack's, or that of a model beside its measurements."""
    from multilayer.explore.diagnosed import is_diagnosis, open_diagnosis
    from multilayer.fits.sources import open_source

    diagnosis = open_diagnosis(file) if is_diagnosis(file) else None
    source = diagnosis.source if diagnosis else open_source(file)
    if not source.is_measured:
        from multilayer.explore.explorer import Explorer
        from multilayer.simulation.measured import read_measured

        return Explorer(file, [read_measured(path) for path in measured])
    from multilayer.config.validate import placed_in
    from multilayer.errors import InputError
    from multilayer.explore.model import ModelExplorer

    if measured:
        raise InputError(f"--measured: {file} has measurements of its own; leave the option out")
    for name in diagnosis.changed if diagnosis else []:
        typer.echo(f"remark: {name} has changed since this diagnosis was made", err=True)
    typer.echo("fitting the nominal model", err=True)
    with placed_in(file):
        return ModelExplorer(source, diagnosis.effects if diagnosis else None)


@contextmanager
def _opened(url: str) -> Iterator[None]:
    """Open a page where there is a screen: without one, a browser of the terminal would take the terminal.

    The browser is told a file that leads there, which nobody else can read, until the block ends: what it is told
    itself stands in the list of processes, and the address holds the token.
    """
    import os
    import sys
    import webbrowser
    from tempfile import mkstemp

    if not (sys.platform in ("win32", "darwin") or os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")):
        yield
        return
    descriptor, name = mkstemp(prefix="multilayer-", suffix=".html")  # of mode 0600
    with os.fdopen(descriptor, "w", encoding="utf-8") as stream:
        stream.write(_REDIRECTION.format(url=url))
    try:
        webbrowser.open(Path(name).as_uri())
        yield
    finally:
        Path(name).unlink(missing_ok=True)
