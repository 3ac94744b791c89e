"""What the system allows this process, and what it needs: told before anything waits for it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from multilayer.errors import InputError

_STATM = Path("/proc/self/statm")
LEAST_ADDRESS_SPACE = 1_000_000_000  # bytes; with half of it OpenBLAS asks for its buffers for ever


def require_memory() -> None:
    """Refuse to start where the system allows too little address space.

    Raises
    ------
    InputError
    """
    if sys.platform == "win32":
        return
    import resource

    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if allowed not in (resource.RLIM_INFINITY, -1) and allowed < LEAST_ADDRESS_SPACE:
        raise InputError(
            f"this process may use {allowed / 1e6:.0f} MB of address space, and needs "
            f"{LEAST_ADDRESS_SPACE / 1e6:.0f} MB; allow more, as with: ulimit -v {LEAST_ADDRESS_SPACE // 1000}"
        )


@contextmanager
def memory_bounded(more: int) -> Iterator[None]:
    """Let a block take no more memory than this beside what the process has; where Linux tells that, else any.

    A library that believes a damaged file then fails instead of filling the memory.

    Parameters
    ----------
    more : int
        Bytes.
    """
    if not _STATM.exists():
        yield
        return
    import resource

    taken = int(_STATM.read_text().split()[0]) * resource.getpagesize()
    before, most = resource.getrlimit(resource.RLIMIT_AS)
    bounds = [bound for bound in (before, most, taken + more) if bound != resource.RLIM_INFINITY]
    resource.setrlimit(resource.RLIMIT_AS, (min(bounds), most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (before, most))


def require_files(number: int, what: str) -> None:
    """See that this process may open so many files, within what the system lets it allow itself.

    Parameters
    ----------
    number : int
    what : str
        What needs them.

    Raises
    ------
    InputError
    """
    if sys.platform == "win32":
        return
    import resource

    allowed, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    if allowed in (resource.RLIM_INFINITY, -1) or allowed >= number:
        return
    if most not in (resource.RLIM_INFINITY, -1) and most < number:
        text = f"{what} needs {number} open files, and the system allows {most}"
        raise InputError(f"{text}; allow more, as with: ulimit -n {number}")
    resource.setrlimit(resource.RLIMIT_NOFILE, (number, most))
