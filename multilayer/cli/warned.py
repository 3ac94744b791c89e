"""Warnings of a command: a line each on standard error, once, and kept for the results that it writes."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import Any

import typer

from multilayer.cli.loudness import LOUDNESS

_texts: ContextVar[dict[str, None]] = ContextVar("texts")


@contextmanager
def warnings_as_lines() -> Iterator[None]:
    """Tell each warning of the package as `tell` does, while a command runs."""
    from multilayer.errors import MultilayerWarning

    token = _texts.set({})
    with warnings.catch_warnings():
        warnings.simplefilter("always", MultilayerWarning)
        show = warnings.showwarning

        def show_line(message: Warning | str, category: type[Warning], *place: Any, **options: Any) -> None:
            # whatever changes filters in between makes Python forget what it has shown: `tell` does not
            if issubclass(category, MultilayerWarning):
                tell([str(message)])
            else:
                show(message, category, *place, **options)

        warnings.showwarning = show_line
        try:
            yield
        finally:
            _texts.reset(token)


def tell(texts: Iterable[str]) -> None:
    """Tell each text that this command has not told yet, in a line on standard error; not with ``--quiet``."""
    from multilayer.doors import for_terminal

    before = _texts.get({})
    for text in dict.fromkeys(" ".join(text.split()) for text in texts):
        if text not in before:
            before[text] = None
            if LOUDNESS.warnings:
                typer.echo(for_terminal(f"warning: {text}"), err=True)


def told() -> tuple[str, ...]:
    """Return what this command has warned of so far, shown or not."""
    return tuple(_texts.get({}))
