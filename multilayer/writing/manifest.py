"""What a folder of results holds and what it was made from: ``manifest.json``, by which it can be checked."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from functools import lru_cache
from hashlib import file_digest, sha256
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

from multilayer.bounds import FILE_BYTES
from multilayer.files import is_file
from multilayer.json_text import json_text

MANIFEST = "manifest.json"
EDITED = ("rig", "import")
"""Commands that make campaigns."""
_PACKAGES = ("multilayer", "numpy", "scipy", "pydantic", "PyYAML", "matplotlib")
_command: ContextVar[str] = ContextVar("command", default="multilayer")
_inputs: ContextVar[dict[Path, str] | None] = ContextVar("inputs", default=None)


@contextmanager
def inputs_noted(command: str | None = None) -> Iterator[dict[Path, str]]:
    """Note every file that is read inside: give them by path, with their SHA-256.

    Parameters
    ----------
    command : str, optional
        That which runs inside, see `running`.
    """
    noted: dict[Path, str] = {}
    tokens = _inputs.set(noted), _command.set(command or running())
    try:
        yield noted
    finally:
        _inputs.reset(tokens[0])
        _command.reset(tokens[1])


def running() -> str:
    """Return the command that runs, as manifests name it."""
    return _command.get()


def note_input(file: Path) -> None:
    """Note that a file is read as input, if anything notes; what is no file, or cannot be read, is nobody's input."""
    noted = _inputs.get()
    if noted is None or file in noted or not is_file(file):  # a pipe can be read once, and a device has no end
        return
    try:
        if file.stat().st_size <= FILE_BYTES.most:  # a larger one is refused
            with file.open("rb") as stream:
                noted[file] = file_digest(stream, "sha256").hexdigest()
    except OSError:
        return


def noted_inputs() -> dict[Path, str]:
    """Return what has been noted so far."""
    return dict(_inputs.get() or {})


def manifest_text(
    files: Mapping[str, bytes], inputs: Mapping[Path, str], made_by: str, before: Mapping[str, Any] | None
) -> str:
    """Return the text of a manifest.

    Parameters
    ----------
    files : mapping
        Contents by name.
    inputs : mapping
        SHA-256 by path.
    made_by : str
        The command.
    before : mapping or None
        The manifest that the folder has: results of other commands stay in it.
    """
    results = {
        name: {**entry, "files": {file: digest for file, digest in entry["files"].items() if file not in files}}
        for name, entry in (before or {"results": {}})["results"].items()
        if name != made_by
    }
    results[made_by] = {
        "made_with": _versions(),
        "inputs": {str(file): inputs[file] for file in sorted(inputs)},
        "files": {name: sha256(files[name]).hexdigest() for name in sorted(files)},
    }
    return json_text({"version": 1, "results": {name: results[name] for name in sorted(results)}})


@lru_cache(maxsize=1)
def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for name in _PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:  # run from a copy that is not installed
            continue
    return found


def read_manifest(folder: Path) -> dict[str, Any] | None:
    """Return the manifest of a folder; None where there is none that can be read, or it lists files outside."""
    file = folder / MANIFEST
    try:
        if not is_file(file) or file.stat().st_size > FILE_BYTES.most:
            return None
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        tables = [entry[part] for entry in found["results"].values() for part in ("inputs", "files")]
        is_sound = all(isinstance(digest, str) for table in tables for digest in table.values())
        is_sound = is_sound and not any(map(_leaves, listed(found)))
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return found if is_sound else None


def _leaves(name: str) -> bool:
    """Tell whether a name leads out of the folder that it is looked for in."""
    path = Path(name)
    return bool(path.anchor) or ".." in path.parts


def listed(manifest: Mapping[str, Any] | None) -> dict[str, str]:
    """Return all files of a manifest with their SHA-256; none where there is no manifest."""
    if manifest is None:
        return {}
    return {name: digest for entry in manifest["results"].values() for name, digest in entry["files"].items()}


def differences(folder: Path, manifest: Mapping[str, Any]) -> list[str]:
    """Return the files that a folder no longer holds, or not as they were written.

    Campaigns are made to be edited, and so are left out.
    """
    kept = {name: entry for name, entry in manifest["results"].items() if name not in EDITED}
    return [name for name, digest in sorted(listed({"results": kept}).items()) if digest_of(folder / name) != digest]


def changed_inputs(manifest: Mapping[str, Any]) -> list[str]:
    """Return inputs that are there and no longer what they were when the results were made."""
    inputs = {name: digest for entry in manifest["results"].values() for name, digest in entry["inputs"].items()}
    return sorted(name for name, digest in inputs.items() if digest_of(Path(name)) not in (None, digest))


def digest_of(file: Path) -> str | None:
    """Return the SHA-256 of a file; None where there is none. A pipe or a device, which may have no end, is none."""
    try:
        if not is_file(file):
            return None
        with file.open("rb") as stream:
            return file_digest(stream, "sha256").hexdigest()
    except (OSError, ValueError):
        return None
