"""Collecting warnings of validity thread by thread, while several threads compute."""

from __future__ import annotations

import threading
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from multilayer.errors import ValidityWarning

_here = threading.local()


@contextmanager
def collected_warnings() -> Iterator[list[str]]:
    """Give a list that takes the texts of every `ValidityWarning` of this thread, in place of showing them.

    Where such contexts are nested, the inner one takes them.
    """
    before = getattr(_here, "texts", None)
    texts: list[str] = []
    _here.texts = texts
    _state.enter()
    try:
        yield texts
    finally:
        _here.texts = before
        _state.leave()


class _State:
    """Python's filters of warnings, which all threads share: the first thread sets them, the last restores them."""

    def __init__(self) -> None:
        self.lock = threading.Lock()
        self.inside = 0
        self.before: warnings.catch_warnings[Any] = warnings.catch_warnings()

    def enter(self) -> None:
        with self.lock:
            if self.inside == 0:
                self.before = warnings.catch_warnings()
                self.before.__enter__()
                warnings.simplefilter("always", ValidityWarning)
                warnings.showwarning = _collecting(warnings.showwarning)
            self.inside += 1

    def leave(self) -> None:
        with self.lock:
            self.inside -= 1
            if self.inside == 0:
                self.before.__exit__(None, None, None)


_state = _State()


def _collecting(show: Any) -> Any:
    def collect(message: Any, category: type[Warning], *rest: Any, **more: Any) -> None:
        texts = getattr(_here, "texts", None)
        if texts is not None and issubclass(category, ValidityWarning):
            texts.append(str(message))
        else:
            show(message, category, *rest, **more)

    return collect
