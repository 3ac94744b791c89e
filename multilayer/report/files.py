"""Names of files."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import chain, count

_LONGEST_FILE_NAME = 80


def file_names(names: Sequence[str]) -> list[str]:
    """Return a file name for each name, different ones also where a file system does not tell case apart."""
    found: dict[str, str] = {}
    for name in names:
        stem = "".join(c if c.isalnum() or c in "-_." else "_" for c in name)[:_LONGEST_FILE_NAME]
        numbered = (f"{stem}-{n}" for n in count(2))
        new = next(one for one in chain([stem], numbered) if one.casefold() not in found)
        found[new.casefold()] = new
    return list(found.values())
