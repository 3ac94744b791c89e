"""``multilayer check``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer


def check(
    files: Annotated[list[Path], typer.Argument(metavar="FILE...", help="Stack, campaign or fit files, or folders.")],
) -> None:
    """Read files without running anything, and report every mistake with its line and column.

    Signals of campaigns are read and checked as well. Exit status 2 when anything is wrong.

    Example: multilayer check examples/three_layers.yaml examples/foam_b
    """
    from multilayer.errors import InputError, Problem
    from multilayer.inverse.sources import read_any

    problems: list[str | Problem] = []
    for file in files:
        try:
            kind = read_any(file)
        except InputError as error:
            problems += error.problems
        else:
            typer.echo(f"{file}: a {kind} without mistakes")
    if problems:
        raise InputError(problems)
