"""What the pages show of a terminal: files that they print, commands, and what these answer."""

import re
import shlex
from pathlib import Path
from typing import NamedTuple

_BLOCK = re.compile(r"^```(yaml|console)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
_NAMED = re.compile(r"# (\S+\.ya?ml)\n")
MORE = "..."


class Command(NamedTuple):
    """One command of a page, and the lines that the page shows of its answer."""

    arguments: tuple[str, ...]
    shown: tuple[str, ...]


def files(page: Path) -> dict[str, str]:
    """Return the texts of the YAML blocks that begin with a file's name, by that name."""
    blocks = [text for kind, text in _BLOCK.findall(page.read_text()) if kind == "yaml"]
    return {named[1]: text for text in blocks if (named := _NAMED.match(text))}


def commands(page: Path) -> list[Command]:
    """Return the ``multilayer`` commands of the console blocks."""
    found: list[list[str]] = []
    for kind, text in _BLOCK.findall(page.read_text()):
        if kind == "console":
            for line in text.splitlines():
                if line.startswith("$ "):
                    found.append([line])
                else:
                    found[-1].append(line)
    split = [(shlex.split(first[2:], comments=True), tuple(shown)) for first, *shown in found]
    return [Command(tuple(words[1:]), shown) for words, shown in split if words[0] == "multilayer"]


def missing(command: Command, answer: str) -> list[str]:
    """Return the lines shown that do not stand in the answer, in this order; spaces at their ends do not count."""
    rest = iter([line.rstrip() for line in answer.splitlines()])
    return [line for line in command.shown if line.strip() != MORE and line.rstrip() not in rest]
