"""``--verbose`` and ``--quiet``, which every command takes."""

from __future__ import annotations

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Annotated

import typer

Verbose = Annotated[
    bool, typer.Option("--verbose", help="Log every step with its time, on standard error, in place of a progress bar.")
]
Quiet = Annotated[bool, typer.Option("--quiet", help="No progress bar and no warnings: errors and results only.")]


class _Loudness:
    """How loud the command is that runs."""

    bars = True
    warnings = True


LOUDNESS = _Loudness()


@contextmanager
def loudness(*, verbose: bool, quiet: bool) -> Iterator[None]:
    """Set what is told while a command runs.

    Raises
    ------
    InputError
        For both at once.
    """
    from multilayer.errors import InputError

    if verbose and quiet:
        raise InputError("--verbose and --quiet contradict each other; give one of them")
    if not (verbose or quiet):
        yield
        return
    logger, handler = logging.getLogger("multilayer"), logging.StreamHandler()
    handler.setFormatter(logging.Formatter("{asctime} {message}", style="{"))
    before = LOUDNESS.bars, LOUDNESS.warnings, logger.level
    LOUDNESS.bars, LOUDNESS.warnings = False, not quiet
    if verbose:
        logger.addHandler(handler)
        logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.removeHandler(handler)
        LOUDNESS.bars, LOUDNESS.warnings = before[:2]
        logger.setLevel(before[2])
