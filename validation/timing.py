"""How long something takes, as the pages of times tell it."""

from __future__ import annotations

from collections.abc import Callable
from time import process_time
from typing import TypeVar

T = TypeVar("T")


def least_seconds(function: Callable[[], T], repeats: int) -> tuple[float, T]:
    """Return the least processor time of some repeats, s, and what came of the last."""
    times = []
    for _ in range(repeats):
        start = process_time()
        result = function()
        times.append(process_time() - start)
    return min(times), result
