"""Results that take long, shared by the processes of a pool: one computes them, the others read them."""

from __future__ import annotations

import pickle
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import wraps
from hashlib import sha256
from pathlib import Path
from tempfile import NamedTemporaryFile, mkdtemp
from typing import ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")

_MOST = 64 * 2**20  # bytes that a process writes: those of one diagnosis, not of hundreds in one run
_written = 0
_folder: Path | None = None


@contextmanager
def sharing() -> Iterator[Path | None]:
    """Give a folder of this user's, which is removed at the end, for this process and those that `join` it.

    None where the system has no place for it: every process computes for itself then.
    """
    try:
        folder = Path(mkdtemp(prefix="multilayer-"))
    except OSError:
        yield None
        return
    before = _folder
    join(folder)
    try:
        yield folder
    finally:
        remove()
        join(before)


def join(folder: Path | None) -> None:
    """Make this process share what it computes in a folder; nothing with None."""
    global _folder, _written
    _folder, _written = folder, 0


def remove() -> None:
    """Remove the folder of this process; another that still reads from it computes for itself."""
    if _folder is not None:
        shutil.rmtree(_folder, ignore_errors=True)


def shared(function: Callable[P, R]) -> Callable[P, R]:
    """Return a function whose results the processes of a pool share.

    The same arguments, as `repr` writes them, must give the same result everywhere, and reading it must be faster than
    computing it. What cannot be read or written is computed.
    """

    @wraps(function)
    def reading(*args: P.args, **kwargs: P.kwargs) -> R:
        if _folder is None:
            return function(*args, **kwargs)
        asked = f"{function.__module__}.{function.__qualname__}{args!r}{kwargs!r}"
        path = _folder / sha256(asked.encode()).hexdigest()
        try:
            result: R = pickle.loads(path.read_bytes())  # of this user's own processes
        except (OSError, EOFError, pickle.UnpicklingError):
            result = function(*args, **kwargs)
            _write(path, pickle.dumps(result))
        return result

    return reading


def _write(path: Path, content: bytes) -> None:
    global _written  # noqa: PLW0603
    if _written + len(content) > _MOST:
        return
    _written += len(content)
    try:
        with NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(content)
        Path(file.name).replace(path)  # whole, or not at all
    except OSError:
        return
