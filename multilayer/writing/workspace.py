"""A hidden folder beside what is being written, in which it is made, and whose lock keeps a second run out.

The lock is the system's: that of a process that has died is free. What a dead run has left in the folder is finished or
undone by the next that writes to the same place.
"""

from __future__ import annotations

import json
import os
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from datetime import datetime
from hashlib import sha256
from pathlib import Path

from multilayer.errors import InputError
from multilayer.writing import disk

_LONGEST = 100  # bytes of a name that are kept as they are
_BEYOND = 1 << 30  # place of the locked byte: Windows lets nobody read a locked one
_LOCK = "lock"
_is_junction: Callable[[Path], bool] = getattr(os.path, "isjunction", lambda path: False)  # Windows, Python 3.12
COMMITTED, JOURNAL = "committed", "journal.json"
"""Names in the hidden folder of what the next run has to finish before it clears anything."""


@dataclass
class Workspace:
    """A claimed place.

    Attributes
    ----------
    place : Path
        What is to be written: an absolute path without symbolic links.
    folder : Path
        The hidden folder.
    handle : int
        The open lock.
    parents : list of Path
        Folders made for it, the outermost first.
    """

    place: Path
    folder: Path
    handle: int
    parents: list[Path] = field(default_factory=list)

    @property
    def is_unfinished(self) -> bool:
        """Whether something in it has to be finished first."""
        return any((self.folder / name).exists() for name in (COMMITTED, JOURNAL))

    def clear(self) -> None:
        """Remove all but the lock, unless something has to be finished first."""
        if not self.is_unfinished:
            for entry in list(self.folder.iterdir()):
                if entry.name != _LOCK:
                    disk.remove(entry)

    def release(self) -> None:
        """Remove the folder, unless something in it has to be finished first, and free the lock."""
        try:
            self.clear()
            if os.name == "nt":
                os.close(self.handle)
            if not self.is_unfinished:
                disk.remove(self.folder)
        finally:
            if os.name != "nt":
                os.close(self.handle)  # after its name is gone: who opens that has another file
        for parent in reversed(self.parents):
            try:
                parent.rmdir()
            except OSError:  # it holds a result now
                return


_held: dict[Path, Workspace] = {}
written: list[Path] = []
"""Places that were written to since the outermost `claims` began."""


def resolved(place: Path) -> Path:
    """Return a place as an absolute path without symbolic links."""
    return Path(os.path.realpath(place))


def hidden_folder(place: Path) -> Path:
    """Return where the workspace of a resolved place is: beside it; inside where that cannot be."""
    if place.is_dir() and (os.path.ismount(place) or not os.access(place.parent, os.W_OK | os.X_OK)):
        return place / ".multilayer"
    name = place.name.encode("utf-8", "surrogateescape")
    short = place.name if len(name) <= _LONGEST else sha256(name).hexdigest()[:32]
    return place.parent / f".{short}.multilayer"


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
        nearest = next(place for place in (folder, *folder.absolute().parents) if place.exists())
    except OSError as error:
        raise unusable(folder, error) from None
    if not nearest.is_dir():
        raise unusable(folder, f"{nearest} is a file")
    if not os.access(nearest, os.W_OK | os.X_OK):
        raise unusable(folder, f"you may not write into {nearest}")


def unusable(place: Path, reason: str | OSError) -> InputError:
    """Return the error of a place that cannot be written to."""
    text = (reason.strerror or str(reason)) if isinstance(reason, OSError) else reason
    return InputError(f"{place}: cannot be written to ({text}); choose another folder with --out")


@contextmanager
def claims() -> Iterator[None]:
    """Give up at the end what was claimed inside by `claim`."""
    before = set(_held)
    if not before:
        written.clear()
    try:
        yield
    finally:
        for place in [place for place in _held if place not in before]:
            give_up(place)


def held() -> list[Path]:
    """Return the places that this process has claimed."""
    return list(_held)


def give_up(place: Path) -> None:
    """Release a claimed place; what cannot be removed is left to the next run."""
    space = _held.pop(resolved(place), None)
    if space is not None:
        try:
            space.release()
        except OSError:
            return


def claim(place: Path, recover: Callable[[Workspace], None] | None = None) -> Workspace:
    """Claim a place for this process, until `give_up` or the end of `claims`.

    Parameters
    ----------
    place : Path
        May be missing, and its parents too.
    recover : callable, optional
        Finishes or undoes what a dead run has left; `Workspace.clear` follows.

    Raises
    ------
    InputError
        When another run has claimed it, or it cannot be written to.
    """
    path = resolved(place)
    if path in _held:
        return _held[path]
    try:
        missing = [parent for parent in reversed(path.parents) if not parent.exists()]
        path.parent.mkdir(parents=True, exist_ok=True)
        folder = hidden_folder(path)
        space = Workspace(path, folder, _locked(place, folder), missing)
    except OSError as error:
        raise unusable(place, error) from None
    _held[path] = space
    try:
        if recover is not None:
            recover(space)
        space.clear()
    except BaseException as error:
        give_up(place)
        if isinstance(error, OSError):
            raise unusable(place, error) from None
        raise
    return space


@contextmanager
def workspace(place: Path, recover: Callable[[Workspace], None] | None = None) -> Iterator[Workspace]:
    """Give the workspace of a place, claimed for the time being where it is not already.

    Raises
    ------
    InputError
        As `claim`; for errors of the system inside.
    """
    is_held = resolved(place) in _held
    space = claim(place, recover)
    try:
        yield space
    except OSError as error:
        raise unusable(place, error) from None
    finally:
        if is_held:
            _try(space.clear)
        else:
            give_up(place)


def _try(step: Callable[[], None]) -> None:
    try:
        step()
    except OSError:
        return


def is_claimed(place: Path) -> bool:
    """Tell whether a living process has claimed a place."""
    path = resolved(place)
    if path in _held:
        return True
    try:
        handle = os.open(hidden_folder(path) / _LOCK, os.O_RDWR)
    except OSError:
        return False
    try:
        return not _lock(handle)
    finally:
        os.close(handle)


def _locked(place: Path, folder: Path) -> int:
    """Return the open and locked lock of a hidden folder, which is made."""
    while True:
        _refuse_link(folder)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            for entry in folder.iterdir():
                _refuse_link(entry)
            handle = os.open(folder / _LOCK, os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0), 0o666)
        except FileNotFoundError:  # the run before has removed the folder in between
            continue
        if not _lock(handle):
            owner = _owner(handle)
            os.close(handle)
            raise InputError(f"{place}: {owner} is writing there; wait for it, or choose another place")
        if _is_at(handle, folder / _LOCK):
            break
        os.close(handle)  # it has removed the lock in between
    os.ftruncate(handle, 0)
    os.write(handle, json.dumps(_myself()).encode())
    return handle


def _refuse_link(path: Path) -> None:
    """Refuse a symbolic link where runs leave files and folders: it may lead to anything, which would be cleared away.

    Raises
    ------
    InputError
    """
    if path.is_symlink() or _is_junction(path):
        raise InputError(f"{path}: is a link, which no run of multilayer leaves; somebody else made it, remove it")


def _is_at(handle: int, path: Path) -> bool:
    try:
        return os.path.samestat(os.fstat(handle), path.stat())
    except FileNotFoundError:
        return False


def _lock(handle: int) -> bool:
    """Lock an open file; False when another process has. A process that this one forks does not share the lock."""
    try:
        if sys.platform == "win32":
            import msvcrt

            os.lseek(handle, _BEYOND, os.SEEK_SET)
            msvcrt.locking(handle, msvcrt.LK_NBLCK, 1)
            os.lseek(handle, 0, os.SEEK_SET)
        else:
            import fcntl

            fcntl.lockf(handle, fcntl.LOCK_EX | fcntl.LOCK_NB, 1, _BEYOND)
    except OSError as error:
        return disk.is_unsupported(error)  # without locks there is no owner to respect
    return True


def _myself() -> dict[str, str | int]:
    since = datetime.now().astimezone().isoformat(timespec="seconds")
    return {"process": os.getpid(), "host": socket.gethostname(), "since": since}


def _owner(handle: int) -> str:
    try:
        owner = json.loads(os.read(handle, 1000))
        return f"process {int(owner['process'])} on {owner['host']} (since {owner['since']})"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"
