"""Whether there is a file: a name that no file can have is none, rather than an error of the system."""

from __future__ import annotations

from pathlib import Path


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


def is_endless(path: Path) -> bool:
    """Tell whether there is something else than a file or a folder: a pipe or a device, which may have no end."""
    return exists(path) and not (is_file(path) or path.is_dir())
