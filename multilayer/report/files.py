"""Writing results: all or nothing."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Mapping, Sequence
from itertools import chain, count
from pathlib import Path

from multilayer.errors import InputError

_LONGEST_FILE_NAME = 80


def refuse_unusable(folder: Path) -> None:
    """Refuse a folder that cannot be written to, before anything is computed for it.

    Parameters
    ----------
    folder : Path
        May be missing, and its parents too.

    Raises
    ------
    InputError
    """
    try:
        nearest = next(place for place in (folder, *folder.parents) if place.exists())
    except OSError as error:
        raise _unusable(folder, error.strerror or str(error)) from None
    if not nearest.is_dir():
        raise _unusable(folder, f"{nearest} is a file")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise _unusable(folder, f"you may not write into {nearest}")


def _unusable(folder: Path, reason: str) -> InputError:
    return InputError(f"{folder}: cannot be written to ({reason}); choose another folder with --out")


def write_files(folder: Path, files: Mapping[str, bytes | str]) -> list[Path]:
    """Write several files into a folder, each under a temporary name first.

    The files are renamed to their own names only after every one of them is complete on disk.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    files : mapping
        Contents by file name.

    Returns
    -------
    list of Path
        In the order of `files`.

    Raises
    ------
    InputError
        When the folder cannot be written to.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".partial-") as partial:
            for name, content in files.items():
                data = content.encode() if isinstance(content, str) else content
                (Path(partial) / name).write_bytes(data)
            for name in files:
                os.replace(Path(partial) / name, folder / name)  # noqa: PTH105 (atomic, over an existing file)
    except OSError as error:
        raise _unusable(folder, error.strerror or str(error)) from None
    return [folder / name for name in files]


def write_folder(folder: Path, files: Mapping[str, str]) -> list[str]:
    """Write a new folder with all its files, or nothing.

    Parameters
    ----------
    folder : Path
        Must not exist; its parents are made.
    files : mapping
        Texts by path inside the folder.

    Returns
    -------
    list of str
        The paths, in the order of `files`.

    Raises
    ------
    InputError
        When the folder exists or cannot be written to.
    """
    if folder.exists() or folder.is_symlink():
        raise InputError(f"{folder}: there is such a file or folder already; choose another place, or remove it first")
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent, prefix=".partial-") as partial:
            whole = Path(partial) / folder.name
            for name, text in files.items():
                (whole / name).parent.mkdir(parents=True, exist_ok=True)
                (whole / name).write_text(text, encoding="utf-8")
            whole.rename(folder)
    except OSError as error:
        raise _unusable(folder, error.strerror or str(error)) from None
    return list(files)


def file_names(names: Sequence[str]) -> list[str]:
    """Return a file name for each name, different ones also where a file system does not tell case apart."""
    found: dict[str, str] = {}
    for name in names:
        stem = "".join(c if c.isalnum() or c in "-_." else "_" for c in name)[:_LONGEST_FILE_NAME]
        numbered = (f"{stem}-{n}" for n in count(2))
        new = next(one for one in chain([stem], numbered) if one.casefold() not in found)
        found[new.casefold()] = new
    return list(found.values())
