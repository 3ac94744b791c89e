"""Running laws on a subject, one function per law."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import TypeVar

S = TypeVar("S")


def broken_laws(laws: Iterable[Callable[[S], Iterator[str]]], subject: S) -> list[str]:
    """Return how a subject breaks laws, each sentence behind the name of its law.

    Parameters
    ----------
    laws : iterable of callable
        Each yields the ways in which a subject breaks it. Its name, words joined by underscores, is that of the law.
    subject : object
        What the laws are checked on; where it raises an exception, that is the sentence.
    """
    broken = []
    for law in laws:
        name = law.__name__.strip("_").replace("_", " ")
        try:
            broken += [f"{name}: {reason}" for reason in law(subject)]
        except Exception as error:  # a subject under test may fail in any way; the other laws are still worth knowing
            broken.append(f"{name}: {type(error).__name__}: {error}")
    return broken
