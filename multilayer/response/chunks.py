"""Long frequency axes in pieces: bounded memory, arrays that stay in the processor's cache, and threads."""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel

from multilayer.arrays import ArrayLike, RealArray, frequencies
from multilayer.errors import InputError
from multilayer.stack import Stack

POINTS = 4096  # frequencies times angles solved at once
_MOST_LAYERS = 50  # of which that many points take 250 MB

T = TypeVar("T")


def frequency_axis(frequency: ArrayLike) -> RealArray:
    """Return frequencies as an array of shape (n_frequency,).

    Raises
    ------
    InputError
        For more axes than one, and as `frequencies`.
    """
    f = np.atleast_1d(frequencies(frequency))
    if f.ndim != 1:
        raise InputError("give frequencies along one axis")
    return f


def in_chunks(
    compute: Callable[[NDArray[Any]], T], stack: Stack, frequency: NDArray[Any], n_angles: int, workers: int = 1
) -> list[T]:
    """Return the results of `compute` for consecutive pieces of the frequency axis.

    Parameters
    ----------
    compute : callable
        Takes a part of `frequency`.
    stack : Stack
        With arrays in its fields, which may follow the frequency axis, everything is computed at once.
    frequency : array, shape (n_frequency,) or (); or (n_bands, n_points), the points of a band in one piece
        Hz, or their indices.
    n_angles : int
        How many points each frequency stands for.
    workers : int
        Threads. NumPy releases the interpreter while it computes; two of them gain on two cores, many do not.
    """
    # threads hand the interpreter to each other between operations: long ones cost them less
    points = POINTS if workers == 1 else 2 * POINTS
    many = max(1, len(stack.layers) // _MOST_LAYERS)  # all layers' matrices are held at once
    step = max(1, points // (max(n_angles, 1) * many * max(1, math.prod(frequency.shape[1:]))))
    if not frequency.ndim or len(frequency) <= step or has_arrays(stack):
        return [compute(frequency)]
    pieces = [frequency[i : i + step] for i in range(0, len(frequency), step)]
    if workers == 1:
        return [compute(piece) for piece in pieces]
    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(compute, pieces))


def has_arrays(stack: Stack) -> bool:
    """Tell whether fields of the stack's layers, or of laws in them, hold arrays."""
    return any(_holds_arrays(value) for layer in stack.layers for _, value in layer)


def _holds_arrays(value: Any) -> bool:
    if isinstance(value, BaseModel):
        return any(_holds_arrays(inner) for _, inner in value)
    if isinstance(value, tuple):
        return any(map(_holds_arrays, value))
    return isinstance(value, np.ndarray) and value.ndim > 0
