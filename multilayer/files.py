"""Whether there is a file: a name that no file can have is none, rather than an error of the system."""

from __future__ import annotations

import re
from pathlib import Path

from multilayer.errors import InputError, Problem


def is_file(path: Path) -> bool:
    """Tell whether there is such a file."""
    try:
        return path.is_file()
    except OSError:  # longer than the system allows
        return False


def exists(path: Path) -> bool:
    """Tell whether there is such a file or folder."""
    try:
        return path.exists()
    except OSError:
        return False


ENDLESS = "is a pipe or a device, which may have no end; a file is wanted"
_GIVEN = re.compile(r"/dev/(stdin|fd/\d+)|/proc/(self|\d+)/fd/\d+")


def is_endless(path: Path) -> bool:
    """Tell whether there is a pipe or a device, which may have no end.

    What the shell gives a command, as by ``multilayer check <(...)``, is as good as a file.
    """
    return exists(path) and not (is_file(path) or path.is_dir()) and not _GIVEN.fullmatch(str(path))


def refuse_endless(path: Path) -> None:
    """Refuse a pipe or a device, see `is_endless`.

    Raises
    ------
    InputError
    """
    if is_endless(path):
        raise InputError(Problem(ENDLESS, file=path))
