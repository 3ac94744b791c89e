"""Collecting warnings thread by thread, while several threads compute."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TypeAlias

from multilayer.errors import ValidityWarning

_Wanted: TypeAlias = tuple[type[Warning], list[str]]
_here = threading.local()


@contextmanager
def collected_warnings(category: type[Warning] = ValidityWarning) -> Iterator[list[str]]:
    """Give a list that takes the texts of every warning of this thread and a category, in place of showing them.

    Where such contexts are nested, the innermost that asks for a warning takes it.
    """
    before: tuple[_Wanted, ...] = getattr(_here, "wanted", ())
    texts: list[str] = []
    _here.wanted = ((category, texts), *before)
    _state.enter(category)
    try:
        yield texts
    finally:
        _here.wanted = before
        _state.leave()


class _State:
    """Python's filters of warnings, which all threads share: the first thread sets them, the last restores them."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.inside = 0
        self.before: warnings.catch_warnings[Any] = warnings.catch_warnings()

    def enter(self, category: type[Warning]) -> None:
        with self.lock:
            if self.inside == 0:
                self.before = warnings.catch_warnings()
                self.before.__enter__()
                warnings.showwarning = _collecting(warnings.showwarning)
            warnings.simplefilter("always", category)
            self.inside += 1

    def leave(self) -> None:
        with self.lock:
            self.inside -= 1
            if self.inside == 0:
                self.before.__exit__(None, None, None)


_state = _State()


def _collecting(show: Any) -> Any:
    def collect(message: Any, category: type[Warning], *rest: Any, **more: Any) -> None:
        for wanted, texts in getattr(_here, "wanted", ()):
            if issubclass(category, wanted):
                texts.append(str(message))
                return
        show(message, category, *rest, **more)

    return collect
