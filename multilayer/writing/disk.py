"""Steps of writing, each of which a system does at once or not at all."""

from __future__ import annotations

import ctypes
import errno
import os
import sys
from functools import lru_cache
from pathlib import Path
from typing import Any

_EXCHANGE, _SWAP = 2, 2  # RENAME_EXCHANGE of Linux, RENAME_SWAP of macOS
_HERE = -100  # AT_FDCWD
_NOT_SUPPORTED = {
    errno.ENOSYS, errno.EINVAL, errno.ENOTSUP, errno.EOPNOTSUPP, errno.EXDEV, errno.EBUSY, errno.EPERM, errno.EMLINK,
}  # fmt: skip


def is_unsupported(error: OSError) -> bool:
    """Tell whether an error says that this file system, or this place in it, lacks a step."""
    return error.errno in _NOT_SUPPORTED


def write(path: Path, data: bytes) -> None:
    """Write a new file, and wait until it is on the disk."""
    handle = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0), 0o666)
    try:
        left = memoryview(data)
        while left:
            left = left[os.write(handle, left) :]
        os.fsync(handle)
    finally:
        os.close(handle)


def sync(folder: Path) -> None:
    """Wait until the names in a folder are on the disk; Windows has no such wait."""
    if os.name == "nt":
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if not is_unsupported(error):
            raise
    finally:
        os.close(handle)


def exchange(first: Path, second: Path) -> bool:
    """Exchange two folders in one step; False where the system cannot, with nothing changed.

    Raises
    ------
    OSError
    """
    function = _exchange()
    if function is None:
        return False
    try:
        function(os.fsencode(first), os.fsencode(second))
    except OSError as error:
        if is_unsupported(error):
            return False
        raise
    return True


@lru_cache(maxsize=1)
def _exchange() -> Any:
    """Return a function that exchanges two paths, or None where there is none."""
    if sys.platform not in ("linux", "darwin"):
        return None
    libc = ctypes.CDLL(None, use_errno=True)
    name = "renameat2" if sys.platform == "linux" else "renamex_np"
    call = getattr(libc, name, None)
    if call is None:
        return None

    def exchanged(first: bytes, second: bytes) -> None:
        arguments = (_HERE, first, _HERE, second, _EXCHANGE) if sys.platform == "linux" else (first, second, _SWAP)
        if call(*arguments) != 0:
            number = ctypes.get_errno()
            raise OSError(number, os.strerror(number), os.fsdecode(first))

    return exchanged


def remove(path: Path) -> None:
    """Remove a file, or a folder with all that is in it; nothing where there is none."""
    try:
        if path.is_dir() and not path.is_symlink():
            for entry in list(path.iterdir()):
                remove(entry)
            os.rmdir(path)  # noqa: PTH106 (each step of this module is one of the system's)
        else:
            os.unlink(path)  # noqa: PTH108
    except FileNotFoundError:
        return
