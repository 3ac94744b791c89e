"""Errors that a user can act on: one message per mistake, with its place in the input."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path

from multilayer.doors import cut, for_log, for_terminal

_LONGEST_SHOWN, _LONGEST_PATH, _LONGEST_WORD, _LONGEST_LINE = 80, 200, 500, 4000
_LONG_WORD = re.compile(rf"\S{{{_LONGEST_WORD},}}")


class MultilayerError(Exception):
    """Base of every error the package raises on purpose; its text is meant for the user, as `readable` has it."""

    def __str__(self) -> str:
        return readable(super().__str__())


class MultilayerWarning(UserWarning):
    """Base of every warning the package gives on purpose; commands tell each once, in a line."""


class ValidityWarning(MultilayerWarning):
    """A formula is used outside the range it was made for; the result may be wrong, the computation goes on."""


class PlausibilityWarning(MultilayerWarning):
    """A value is allowed, and hardly ever meant: what a file says goes on as it is written."""


class PluginWarning(MultilayerWarning):
    """A plugin, an effect or a place that is broken was left out; everything else goes on."""


@dataclass(frozen=True)
class Problem:
    """One mistake in one input.

    Attributes
    ----------
    message : str
        What is wrong and what is allowed.
    path : str
        Dotted path into the input, as ``layers.1.tortuosity``; empty for the whole of it.
    file : Path or None
        The file it stands in.
    line, column : int or None
        Counted from 1.
    """

    message: str
    path: str = ""
    file: Path | None = None
    line: int | None = None
    column: int | None = None

    def __str__(self) -> str:
        place = ":".join(str(part) for part in (self.file, self.line, self.column) if part is not None)
        parts = for_log(place), for_log(cut(self.path, _LONGEST_PATH)), readable(self.message)
        return ": ".join(part for part in parts if part)

    def at(self, file: Path, line: int | None = None, column: int | None = None) -> Problem:
        """Return the same problem, placed in a file."""
        return replace(self, file=file, line=line, column=column)


class InputError(MultilayerError):
    """Input that cannot be used; carries every mistake, not only the first.

    Parameters
    ----------
    problems : Problem or str, or several of them
        The mistakes.
    """

    def __init__(self, problems: str | Problem | Iterable[str | Problem]) -> None:
        items = [problems] if isinstance(problems, str | Problem) else list(problems)
        self.problems = [item if isinstance(item, Problem) else Problem(item) for item in items]
        super().__init__("\n".join(str(problem) for problem in self.problems))


class FieldError(InputError, ValueError):
    """Fields of a model made in Python that cannot be used: a ValueError as well, as such mistakes are elsewhere."""


def suggest(name: str, allowed: Iterable[str]) -> str:
    """Return ``did you mean 'x'?``, or the list of what is allowed when nothing is near.

    Parameters
    ----------
    name : str
        What was written.
    allowed : iterable of str
        What may be written.
    """
    names = sorted(allowed)
    near = get_close_matches(name[:_LONGEST_PATH], names, n=1, cutoff=0.6)
    listed = ", ".join(cut(one, _LONGEST_SHOWN) for one in names)
    return f"did you mean '{cut(near[0], _LONGEST_SHOWN)}'?" if near else f"allowed: {listed or 'none'}"


def readable(message: str) -> str:
    """Return a message without control characters; names and lines in it that are very long lose their middle.

    Parameters
    ----------
    message : str
        May have several lines.
    """
    words = _LONG_WORD.sub(lambda word: cut(word[0], _LONGEST_PATH), message)
    return for_terminal("\n".join(cut(line, _LONGEST_LINE) for line in words.split("\n")))


def show(value: object) -> str:
    """Return a value as messages quote it: text in quotes, None as 'an empty value', cut to the length of a line.

    Parameters
    ----------
    value : object
        What was written.
    """
    if value is None:
        return "an empty value"
    shown = f"'{value}'" if isinstance(value, str) and value.isprintable() else repr(value)
    return shown if len(shown) <= _LONGEST_SHOWN else f"{shown[:_LONGEST_SHOWN]}..."
