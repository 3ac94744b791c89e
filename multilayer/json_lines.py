"""Results of long computations, written as they come: one line of JSON each, after a first line of settings."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from multilayer.errors import InputError
from multilayer.writing.folders import write_file


class JsonLines:
    """A file to which a computation adds its results, and from which an interrupted one resumes.

    Parameters
    ----------
    path : Path
    made_with : dict
        The settings, as plain data; a file with other settings is not resumed.
    """

    def __init__(self, path: Path, made_with: dict[str, Any]) -> None:
        self.path, self._head = path, made_with

    def begin(self, *, resume: bool) -> list[dict[str, Any]]:
        """Return the results that the file holds already.

        A last line that was cut short is left out.

        Raises
        ------
        InputError
            When the file holds results of other settings, or any without `resume`: they took hours.
        """
        lines = self.path.read_text(encoding="utf-8").splitlines() if self.path.exists() else []
        plain = [entry for entry in map(_parsed, lines) if entry is not None]
        if len(plain) > 1 and not resume:
            text = f"holds {len(plain) - 1} results, which would be lost"
            raise InputError(f"{self.path} {text}; --resume goes on from there, or choose another folder")
        if plain and plain[0] != self._head:
            text = "holds results of another seed, version or other settings"
            raise InputError(f"{self.path} {text}; choose another file, or remove this one")
        kept = [self._head, *plain[1:]]
        write_file(self.path, "".join(f"{json.dumps(entry)}\n" for entry in kept))
        return kept[1:]

    def append(self, result: dict[str, Any]) -> None:
        """Add a result."""
        with self.path.open("a", encoding="utf-8") as file:
            file.write(f"{json.dumps(result)}\n")


def _parsed(line: str) -> dict[str, Any] | None:
    try:
        entry: dict[str, Any] = json.loads(line)
    except (ValueError, RecursionError):
        return None
    return entry
