"""Where tables are printed."""

from __future__ import annotations

import shutil

from rich.console import Console

_WIDTH_IN_A_FILE = 150


def console() -> Console:
    """Return the console of standard output; wide enough for the tables when it is a file or a pipe."""
    plain = Console()
    if plain.is_terminal:
        return plain
    return Console(width=max(_WIDTH_IN_A_FILE, shutil.get_terminal_size().columns))
