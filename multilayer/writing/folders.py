"""Folders of results and single files, replaced as a whole.

A folder is made in a hidden `workspace` beside the old one, with second names of the files of other results, waited for
until it is on the disk, and exchanged with the old one in one step of the system. Where that holds what is the user's,
who may be writing there, or this process stands in it, where the system has no such step, or files cannot have second
names, the new files are moved in one by one once all of them are on the disk; a run that dies meanwhile is finished by
the next one, before anything else.

A file beside the folder that belongs to it (a campaign's truth) cannot be exchanged in the same step: the old one is
taken away before and the new one put there after, so that never the one stands beside the other's folder. A run that
dies between is finished or undone by the next one.
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from multilayer.bounds import YAML_BYTES
from multilayer.errors import InputError
from multilayer.files import is_endless
from multilayer.writing import disk
from multilayer.writing.manifest import MANIFEST, digest_of, listed, manifest_text, noted_inputs, read_manifest
from multilayer.writing.workspace import (
    COMMITTED,
    JOURNAL,
    Workspace,
    claim,
    hidden_folder,
    refuse_unusable,
    resolved,
    workspace,
    written,
)

_NEW, _OLD, _BESIDE = "new", "old", "beside"


def claim_folder(folder: Path) -> None:
    """Claim a folder of results for this run: another run is refused until it ends.

    Raises
    ------
    InputError
        When another run writes there, or nobody can.
    """
    refuse_unusable(folder)
    claim(folder, _recover)


def claim_file(file: Path) -> None:
    """Claim a single file for this run, before what takes long to be written into it is computed.

    Raises
    ------
    InputError
        When it is a folder, another run writes it, or nobody can.
    """
    if file.is_dir():
        raise InputError(f"{file}: is a folder; name a file")
    claim(file)


def write_files(
    folder: Path,
    files: Mapping[str, bytes | str],
    *,
    made_by: str,
    inputs: Mapping[Path, str] | None = None,
    beside: Mapping[Path, bytes] | None = None,
    gone: Iterable[Path] = (),
) -> list[Path]:
    """Write a folder of results with its manifest, in place of an older result in it; other files in it stay.

    Parameters
    ----------
    folder : Path
        Made if it does not exist.
    files : mapping
        Contents by path inside the folder.
    made_by : str
        The command: results of others in the same folder stay, too.
    inputs : mapping, optional
        What the result was made from, SHA-256 by path; all that was noted when left out.
    beside : mapping, optional
        Contents of files that belong to the folder, by absolute path: beside it, or in a hidden folder there.
    gone : iterable of Path
        Such files of the old result that the new one does not have.

    Returns
    -------
    list of Path
        In the order of `files`.

    Raises
    ------
    InputError
        When the folder cannot be written to, or another run writes there.
    """
    data = {name: content.encode() if isinstance(content, str) else content for name, content in files.items()}
    noted = noted_inputs() if inputs is None else inputs
    refuse_unusable(folder)
    with workspace(folder, _recover) as space:
        text = manifest_text(data, noted, made_by, read_manifest(folder))
        _make(space.folder / _NEW, data | {MANIFEST: text.encode()})
        _replace(space, data, beside or {}, list(gone))
        written.append(folder)
    return [folder / name for name in files]


def write_new(folder: Path, files: Mapping[str, bytes | str], *, made_by: str | None = None) -> list[str]:
    """Write a folder that does not exist, or is empty, with all its files, or nothing.

    Parameters
    ----------
    folder : Path
        Its parents are made.
    files : mapping
        Contents by path inside the folder.
    made_by : str, optional
        The command; without one the folder has no manifest.

    Returns
    -------
    list of str
        The paths, in the order of `files`.

    Raises
    ------
    InputError
        When the folder holds something or cannot be written to.
    """
    data = {name: content.encode() if isinstance(content, str) else content for name, content in files.items()}
    if made_by:
        data |= {MANIFEST: manifest_text(data, noted_inputs(), made_by, None).encode()}
    refuse_unusable(folder)
    with workspace(folder, _recover) as space:
        refuse_occupied(folder)
        _make(space.folder / _NEW, data)
        if space.place.exists():
            space.place.rmdir()
        os.rename(space.folder / _NEW, space.place)  # noqa: PTH104
        disk.sync(space.place.parent)
        written.append(folder)
    return list(files)


def refuse_occupied(folder: Path) -> None:
    """Refuse a folder that holds something.

    Raises
    ------
    InputError
    """
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise InputError(f"{folder}: there is such a file already; choose another folder with --out")
    if folder.is_dir() and any(folder.iterdir()):
        raise InputError(f"{folder}: holds files already; remove it, or choose another folder with --out")


def write_file(file: Path, content: bytes | str) -> None:
    """Write a single file, in place of an older one if there is one.

    Raises
    ------
    InputError
        When it cannot be written, or another run writes it.
    """
    _refuse_folder(file)
    with workspace(file) as space:
        new = space.folder / _NEW
        disk.write(new, content.encode() if isinstance(content, str) else content)
        os.replace(new, space.place)  # noqa: PTH105
        disk.sync(space.place.parent)


def _refuse_folder(file: Path) -> None:
    if file.is_dir():
        raise InputError(f"{file}: is a folder; name a file")


def is_unfinished(folder: Path) -> bool:
    """Tell whether a run that has died left a folder that the next one has to finish."""
    space = hidden_folder(resolved(folder))
    return (space / COMMITTED).exists() or (space / JOURNAL).exists()


def _make(new: Path, files: Mapping[str, bytes]) -> None:
    """Make a folder with its files, on the disk."""
    os.mkdir(new)  # noqa: PTH102
    folders = {new}
    for name, content in files.items():
        path = new / name
        for parent in reversed(path.relative_to(new).parents[:-1]):
            if new / parent not in folders:
                os.mkdir(new / parent)  # noqa: PTH102
                folders.add(new / parent)
        disk.write(path, content)
    for folder in folders:
        disk.sync(folder)


def _replace(space: Workspace, files: Iterable[str], beside: Mapping[Path, bytes], gone: list[Path]) -> None:
    """Put the new folder of a workspace in place of the old one, and the files beside it."""
    new, place = space.folder / _NEW, space.place
    if not beside and not gone:
        _swap(space, files)
        return
    os.mkdir(space.folder / _OLD)  # noqa: PTH102
    os.mkdir(space.folder / _BESIDE)  # noqa: PTH102
    for number, (path, content) in enumerate(beside.items()):
        path.parent.mkdir(exist_ok=True)
        disk.write(space.folder / _BESIDE / str(number), content)
    targets = [*beside, *gone]
    names = [path.relative_to(place.parent).as_posix() for path in targets]
    journal = {"new": os.stat(new).st_ino, "targets": names, "n_new": len(beside)}  # noqa: PTH116
    disk.write(space.folder / f"{JOURNAL}.part", json.dumps(journal).encode())
    os.rename(space.folder / f"{JOURNAL}.part", space.folder / JOURNAL)  # noqa: PTH104
    disk.sync(space.folder)
    try:
        for number, target in enumerate(targets):
            _move(target, space.folder / _OLD / str(number))
        _swap(space, files)
    finally:
        _settle(space)
    disk.sync(place.parent)


def _swap(space: Workspace, files: Iterable[str]) -> None:
    """Put the new folder in place of the old one, or its files beside those of the user."""
    new, place = space.folder / _NEW, space.place
    if not place.exists():
        os.rename(new, place)  # noqa: PTH104
        disk.sync(place.parent)
        return
    is_free = place not in space.folder.parents and not _is_used(place)
    if is_free and _keeps_others(place, new) and disk.exchange(new, place):
        disk.sync(place.parent)
        return
    committed = space.folder / COMMITTED
    _only(files, new)
    os.rename(new, committed)  # noqa: PTH104
    disk.sync(space.folder)
    try:
        _move_in(committed, place)
    except KeyboardInterrupt:
        _move_in(committed, place)
        raise


def _is_used(place: Path) -> bool:
    """Tell whether a folder holds anything but files as results have written them, or this process stands in it."""
    try:
        here = Path.cwd()
    except FileNotFoundError:
        here = Path()
    if place == here or place in here.parents:
        return True
    known = listed(read_manifest(place))
    folders = {parent.as_posix() for name in known for parent in PurePosixPath(name).parents}
    for path in place.rglob("*"):
        name = path.relative_to(place).as_posix()
        if name not in folders if _is_folder(path) else name != MANIFEST and known.get(name) != digest_of(path):
            return True
    return False


def _is_folder(path: Path) -> bool:
    return path.is_dir() and not path.is_symlink()


def _keeps_others(place: Path, new: Path) -> bool:
    """Give the files of other results in a folder a second name in the new one; tell whether it can."""
    try:
        new.chmod(_mode(place))
        for name in listed(read_manifest(new)):
            if os.path.lexists(new / name) or not os.path.lexists(place / name):
                continue
            for folder in reversed(PurePosixPath(name).parents[:-1]):
                if not (new / folder).exists():
                    os.mkdir(new / folder, _mode(place / folder))  # noqa: PTH102
            os.link(place / name, new / name, follow_symlinks=False)
    except OSError as error:
        if disk.is_unsupported(error):
            return False
        raise
    return True


def _mode(folder: Path) -> int:
    return folder.stat().st_mode & 0o7777


def _stale(place: Path, new: Path) -> set[str]:
    """Return the files of the last result that the new one does not have, and that nobody has changed since."""
    old = {name: digest for name, digest in listed(read_manifest(place)).items() if _is_inside(place / name, place)}
    unchanged = {name for name, digest in old.items() if digest_of(place / name) == digest}
    return unchanged - listed(read_manifest(new)).keys()


def _is_inside(path: Path, place: Path) -> bool:
    """Tell whether a path leads into a folder, and by no link out of it."""
    folder = resolved(path.parent)
    return folder == place or place in folder.parents


def _only(files: Iterable[str], new: Path) -> None:
    """Remove second names of files of other results again."""
    names = {MANIFEST, *files}
    for path in sorted(new.rglob("*"), reverse=True):
        if _is_folder(path):
            if not any(path.iterdir()):
                disk.remove(path)
        elif path.relative_to(new).as_posix() not in names:
            disk.remove(path)


def _move_in(committed: Path, place: Path) -> None:
    """Move all files in, one by one, the manifest last, and drop those that only the old result has."""
    if (committed / MANIFEST).exists():
        for name in _stale(place, committed):
            disk.remove(place / name)
        for path in sorted(committed.rglob("*")):
            if path.is_file() and path != committed / MANIFEST:
                target = place / path.relative_to(committed)
                if not _is_inside(target, place):
                    text = f"leads by a link out of {place}, where results are to be written"
                    raise InputError(f"{target.parent}: {text}; replace the link by a folder")
                target.parent.mkdir(parents=True, exist_ok=True)
                _move(path, target)
        disk.sync(place)
        _move(committed / MANIFEST, place / MANIFEST)
    disk.sync(place)
    disk.remove(committed)


def _move(source: Path, target: Path) -> None:
    """Move a file, if it has not been moved already."""
    try:
        os.replace(source, target)  # noqa: PTH105
    except FileNotFoundError:
        if source.exists():
            raise


def _recover(space: Workspace) -> None:
    """Finish or undo what a dead run has left."""
    committed = space.folder / COMMITTED
    if committed.exists():
        _move_in(committed, space.place)
    _settle(space)


def _settle(space: Workspace) -> None:
    """Finish the files beside a folder when it has been replaced, put them back when not."""
    journal = _journal(space)
    if journal is None:
        return
    is_replaced = space.place.exists() and not _is_new(space.folder / _NEW, journal.new)
    for number, target in enumerate(journal.targets):
        if is_replaced and number < journal.n_new:
            _move(space.folder / _BESIDE / str(number), target)
        elif not is_replaced:
            _move(space.folder / _OLD / str(number), target)
    disk.remove(space.folder / JOURNAL)


@dataclass(frozen=True)
class _Journal:
    """What is being replaced beside a folder.

    Attributes
    ----------
    new : int
        The new folder, by the number that the system gives it.
    targets : list of Path
        Files beside the folder: first the new ones, then those that go.
    n_new : int
    """

    new: int
    targets: list[Path]
    n_new: int


def _journal(space: Workspace) -> _Journal | None:
    """Read the journal of a run that has died; None where there is none.

    Raises
    ------
    InputError
        When no run of ours wrote it: it could move any file to any place.
    """
    path = space.folder / JOURNAL
    try:
        if not is_endless(path) and path.stat().st_size <= YAML_BYTES.most:
            read = json.loads(path.read_text(encoding="utf-8"))
            names = [PurePosixPath(name) for name in read["targets"]]
            if all(_belongs(name, space.place) for name in names):
                return _Journal(int(read["new"]), [space.place.parent / name for name in names], int(read["n_new"]))
    except FileNotFoundError:
        return None
    except (ValueError, LookupError, TypeError, OverflowError, RecursionError):
        pass
    raise InputError(f"{path}: no run of multilayer wrote this; remove {space.folder}")


def _belongs(name: PurePosixPath, place: Path) -> bool:
    """Tell whether a file beside a folder of results, or in a hidden folder there, has a name that belongs to it.

    Raises
    ------
    ValueError
        For what is no name of a file.
    """
    os.fsencode(name)
    is_beside = len(name.parts) == 1 or (len(name.parts) == 2 and re.fullmatch(r"\.\w+", name.parts[0]) is not None)
    return is_beside and name.name.startswith(f"{place.name}.") and "\0" not in name.name


def _is_new(folder: Path, number: int) -> bool:
    try:
        return folder.stat().st_ino == number
    except FileNotFoundError:
        return False
