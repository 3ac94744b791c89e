"""The file that a page shows: read, looked after while others may change it, and saved."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from multilayer.config.kinds import KEY, OF_A_SIMULATION
from multilayer.config.validate import validate
from multilayer.config.yaml12 import Document, dump_yaml, read_yaml
from multilayer.doors import for_log
from multilayer.errors import InputError
from multilayer.simulation.file import SimulationFile, load_simulation
from multilayer.stack import Stack
from multilayer.writing.folders import write_file
from multilayer.writing.manifest import digest_of
from multilayer.writing.workspace import resolved

_NAME = re.compile(r"[^\W_][\w .+=,()-]*\.ya?ml")  # no folder, nothing hidden, no control characters
_LONGEST_NAME = 120
ASIDE = ("sweep", "tolerances", "samples", "seed")
"""Fields of a simulation that a page keeps and does not compute."""


@dataclass(frozen=True)
class Opened:
    """A file as it was read.

    Attributes
    ----------
    data : dict
        As written, without ``kind``.
    digest : str
        Of the bytes on the disk.
    """

    data: dict[str, Any]
    digest: str


def open_file(file: Path) -> Opened:
    """Read a stack or simulation file.

    Raises
    ------
    InputError
        With every mistake in it, as `load_simulation`, or when it is changed while it is read.
    """
    for _ in range(3):
        before = digest_of(file)
        load_simulation(file)
        data = read_yaml(file).data
        if before is not None and before == digest_of(file):
            return Opened({key: value for key, value in data.items() if key != KEY}, before)
    raise InputError(f"{file}: changes while it is read; try again")


def validated(data: Mapping[str, Any], file: Path, kind: str = "simulation") -> SimulationFile | Stack:
    """Return data as the model of their kind.

    Parameters
    ----------
    data : mapping
        Without ``kind``.
    file : Path
        In whose folder other files are looked for.
    kind : str
        ``stack`` or ``simulation``.

    Raises
    ------
    InputError
        With every mistake and its path.
    """
    model: type[SimulationFile | Stack] = SimulationFile if kind == "simulation" else Stack
    return validate(Document(file, dict(data)), model, context={"folder": file.parent})


class NameTakenError(InputError):
    """There is such a file, and nobody has said that it may be replaced."""


@dataclass(frozen=True)
class Save:
    """What is to be saved, and where.

    Attributes
    ----------
    name : str
        Of a file in the folder of the one that was opened.
    kind : str
        ``stack`` or ``simulation``.
    replace : bool
        Whether a file of that name may be replaced.
    known : str
        Digest of the opened file as the window knows it.
    """

    name: str
    kind: str
    replace: bool = False
    known: str = ""


def save(data: Mapping[str, Any], opened: Path, wanted: Save) -> Opened:
    """Write data beside the file that was opened, or in its place.

    Raises
    ------
    NameTakenError
        When there is such a file, and `wanted` does not say that it may be replaced.
    InputError
        When the name is none or that of a link out of the folder, the data have mistakes, the file cannot be written,
        or the opened file, which is to be replaced, has changed since the window read it.
    """
    if wanted.kind not in ("stack", "simulation"):
        raise InputError(f"a page saves a stack or a simulation, not '{wanted.kind}'")
    if len(wanted.name) > _LONGEST_NAME or not _NAME.fullmatch(wanted.name):
        remedy = "letters, digits, spaces and . _ + = , ( ) - beginning with a letter or a digit, and .yaml at the end"
        raise InputError(f"'{for_log(wanted.name)}' is no name of a file here; write {remedy}")
    kept = {key: value for key, value in data.items() if wanted.kind == "simulation" or key not in OF_A_SIMULATION}
    validated(kept, opened, wanted.kind)
    target = opened.parent / wanted.name
    _refuse_link_out(target)
    if target.exists():
        is_opened = is_same(target, opened)
        if is_opened and digest_of(opened) != wanted.known:
            text = "has changed on the disk since this window read it; read it again, or save under another name"
            raise InputError(f"{wanted.name}: {text}")
        if not wanted.replace:
            lost = "; its comments will be lost" if is_opened else ""
            raise NameTakenError(f"{wanted.name}: there is such a file already{lost}")
    text = f"# Made by `multilayer explore` from {for_log(opened.name)}\n{_text(kept, wanted.kind)}"
    write_file(target, text)
    return Opened(kept, digest_of(target) or "")


def is_same(one: Path, other: Path) -> bool:
    """Tell whether two paths lead to one file; False where either leads to none."""
    try:
        return one.samefile(other)
    except OSError:
        return False


def _refuse_link_out(target: Path) -> None:
    """Refuse a link that leads out of its folder, or to no file: writing would follow it."""
    is_inside = target.exists() and resolved(target.parent) in resolved(target).parents
    if target.is_symlink() and not is_inside:
        raise InputError(
            f"{target.name}: is a link that leads out of the folder, or to no file; save under another name"
        )


def _text(data: Mapping[str, Any], kind: str) -> str:
    rest = {key: value for key, value in data.items() if key not in (KEY, "version")}
    return dump_yaml({KEY: kind, "version": 1, **rest})
