"""A progress bar on standard error, shown where a person looks."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def progress_bar(title: str, total: int) -> Iterator[Callable[[str], None]]:
    """Give a function that advances the bar by one step and says what was done.

    Steps beyond the total, of searches that nobody knows the length of, make the total unknown: the bar pulses.
    """
    from multilayer.cli.loudness import LOUDNESS

    if not LOUDNESS.bars:
        yield lambda text: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

    from multilayer.doors import for_log

    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: None  # old versions of rich end even a disabled bar with an empty line
        return
    columns = (
        TextColumn("{task.description}", markup=False), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn(),
        TextColumn("{task.fields[last]}", markup=False),
    )  # fmt: skip
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(for_log(title), total=total, last="")

        def advance(text: str) -> None:
            bar.update(task, advance=1, last=for_log(text))
            if bar.tasks[task].completed > total:
                bar.update(task, total=None)

        yield advance
