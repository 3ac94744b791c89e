"""What readers of other people's formats share: libraries that may be missing, files that are damaged."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from multilayer.errors import InputError, MultilayerError, Problem


def library(module: str, file: Path, to_be: str = "read") -> Any:
    """Return an optional library that a file needs, to be read or written.

    Raises
    ------
    InputError
        When it is not installed, with the command that does.
    """
    try:
        return import_module(module)
    except ImportError:
        message = f"needs the package '{module}' to be {to_be}; install it with: pip install 'multilayer[formats]'"
        raise InputError(Problem(message, file=file)) from None


@contextmanager
def reads(file: Path, kind: str) -> Iterator[None]:
    """Turn whatever a library raises at a damaged file, and its warnings, into one message.

    Parameters
    ----------
    file : Path
    kind : str
        The format that the suffix stands for, as ``a TDMS file``.

    Raises
    ------
    InputError
    """
    if file.stat().st_size == 0:
        raise damaged(file, kind, "it is empty")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", DeprecationWarning)  # libraries warn of each other
            yield
    except MultilayerError:
        raise
    except Exception as error:  # damaged files fail in many ways
        raise damaged(file, kind, " ".join(str(error).split())) from None


def damaged(file: Path, kind: str, reason: str) -> InputError:
    """Return the error of a file that is cut short, or not of its kind."""
    message = f"cannot be read as {kind} ({reason}): cut short, or not what its suffix says; export it again"
    return InputError(Problem(message, file=file))
