"""Exact percentiles of values that arrive piece by piece, in memory that grows as the root of their number.

Where the final percentile lies is known from the values seen so far to some standard deviations of its rank, ``sqrt(p
(1 - p) n)`` of n independent values; what lies outside is counted, not kept. Compare J. I. Munro & M. S. Paterson,
Theor. Comput. Sci. 12 (1980) 315-323, who do the same for any order of arrival in several passes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import RealArray

_REACH = 8.0  # standard deviations of a rank: farther once in 1e15
_FIRST = 2048  # values at each place before any is dropped
_BLOCK = 256  # values at each place that are taken in together
_SMALL = 1 << 16  # places that NumPy sorts in linear time
_BYTES_KEPT = 16  # a value with its place


class Percentiles:
    """Percentiles at each of k places, of n values each that arrive in any number of pieces.

    Values must be independent draws of one distribution, in any order; NaN at a place makes its percentiles NaN.

    Parameters
    ----------
    percents : sequence of float
        0 to 100.
    """

    def __init__(self, percents: Sequence[float]) -> None:
        self._percents, self._shares = list(percents), [percent / 100 for percent in percents]
        self._n = self._next = 0
        self._waiting: list[RealArray] = []
        self._n_waiting = 0
        self._parts: list[_OrderStatistics] = []
        self._is_nan: NDArray[np.bool_] = np.zeros(0, dtype=bool)

    def add(self, values: RealArray) -> None:
        """Take in values, shape (m, k)."""
        self._waiting.append(values)
        self._n_waiting += len(values)
        if self._n_waiting >= (_BLOCK if self._parts else _FIRST):
            self._take_in()

    def _take_in(self) -> None:
        values = np.concatenate(self._waiting)
        self._waiting, self._n_waiting = [], 0
        self._n += len(values)
        nan = np.isnan(values)
        if nan.any():
            values = np.where(nan, 0.0, values)
        if not self._parts:
            self._parts = [_OrderStatistics.of(values, *self._ranks(share)) for share in self._shares]
            self._is_nan, self._next = np.any(nan, axis=0), 2 * self._n
            return
        self._is_nan |= np.any(nan, axis=0)
        is_due = self._n >= self._next
        for share, part in zip(self._shares, self._parts, strict=True):
            part.add(values)
            if is_due:
                part.narrow(*self._ranks(share), self._n)
        if is_due:
            self._next = 2 * self._n

    def _ranks(self, share: float) -> tuple[int, int]:
        """Return ranks among the values so far between which the final percentile lies; they may lie beyond these."""
        reach = _REACH * (1 + np.sqrt(share * (1 - share) * self._n))
        return int(share * self._n - reach), int(np.ceil(share * self._n + reach))

    def result(self) -> RealArray:
        """Return the percentiles, shape (n_percents, k): linear between two values, as `numpy.percentile` has them."""
        if not self._parts:
            with np.errstate(invalid="ignore"):  # infinite values beside each other
                return np.asarray(np.percentile(np.concatenate(self._waiting), self._percents, axis=0))
        if self._waiting:
            self._take_in()
        rows = []
        for share, part in zip(self._shares, self._parts, strict=True):
            place = (self._n - 1) * share
            rank = int(place)
            low, high = part.of_rank(rank), part.of_rank(min(rank + 1, self._n - 1))
            with np.errstate(invalid="ignore"):
                between, weight = high - low, place - rank
                row = low + between * weight if weight < 0.5 else high - between * (1 - weight)
            rows.append(np.where(self._is_nan, np.nan, row))
        return np.array(rows)


def bytes_kept(n: int, n_percents: int) -> int:
    """Return about how much memory the percentiles of n values at one place take at most."""
    if n < _FIRST:
        return 2 * 8 * n
    # the median's, between two times at which its bounds are drawn in; sorted for one percentile at a time
    kept = min(n, int(2 * _REACH * n**0.5))
    return (n_percents + 2) * kept * _BYTES_KEPT + 2 * 8 * _FIRST


class _OrderStatistics:
    """Values between two bounds at each of k places, and how many lie below and at these bounds."""

    def __init__(self, lower: RealArray, upper: RealArray) -> None:
        self._lower, self._upper = lower, upper
        self._below, self._at_lower, self._at_upper = (np.zeros(len(lower), dtype=np.int64) for _ in range(3))
        self._values: list[RealArray] = []
        self._places: list[NDArray[np.intp]] = []
        self._first: NDArray[np.intp] | None = None  # of each place, where all values stand sorted

    @classmethod
    def of(cls, values: RealArray, low: int, high: int) -> _OrderStatistics:
        """Return those of values, shape (m, k), between two ranks; ranks beyond these leave no bound."""
        n, k = values.shape
        ranks = [rank for rank in (low, high) if 0 < rank < n - 1]
        parted = np.partition(np.ascontiguousarray(values.T), ranks, axis=1) if ranks else values.T
        lower = parted[:, low].copy() if low in ranks else np.full(k, -np.inf)
        upper = parted[:, high].copy() if high in ranks else np.full(k, np.inf)
        made = cls(lower, upper)
        made.add(values)
        return made

    def add(self, values: RealArray) -> None:
        """Count or keep values, shape (m, k)."""
        self._below += np.sum(values < self._lower, axis=0)
        self._at_lower += np.sum(values == self._lower, axis=0)
        self._at_upper += np.sum((values == self._upper) & (self._upper > self._lower), axis=0)
        rows, places = np.nonzero((values > self._lower) & (values < self._upper))
        self._values.append(values[rows, places])
        self._places.append(places)
        self._first = None

    def of_rank(self, rank: int) -> RealArray:
        """Return the value of a rank, counted from 0, at each place; NaN where it was dropped."""
        first = self._sorted()
        values = self._values[0]
        index = rank - self._below - self._at_lower
        inside = np.diff(first)
        found = np.full(len(inside), np.nan)
        kept = (index >= 0) & (index < inside)
        found[kept] = values[(first[:-1] + index)[kept]]
        found = np.where((index < 0) & (index >= -self._at_lower), self._lower, found)
        return np.where((index >= inside) & (index < inside + self._at_upper), self._upper, found)

    def _of_rank_or(self, rank: int, bound: RealArray) -> RealArray:
        found = self.of_rank(rank)
        return np.where(np.isnan(found), bound, found)

    def narrow(self, low: int, high: int, n: int) -> None:
        """Drop what lies outside of two ranks, of n values so far; ranks beyond these, or dropped, leave a bound."""
        lower = self._lower if low <= 0 else self._of_rank_or(low, self._lower)
        upper = self._upper if high >= n - 1 else self._of_rank_or(high, self._upper)
        # what is known: the values kept, and so many equal to each bound
        everywhere = np.arange(len(lower))
        values = np.concatenate([*self._values, self._lower, self._upper])
        places = np.concatenate([*self._places, everywhere, everywhere])
        counts = np.ones(len(values), dtype=np.int64)
        counts[-2 * len(lower) :] = np.concatenate([self._at_lower, self._at_upper])

        def counted(chosen: NDArray[np.bool_]) -> NDArray[np.int64]:
            return np.bincount(places[chosen], counts[chosen], len(lower)).astype(np.int64)

        at, to = lower[places], upper[places]
        self._below += counted(values < at)
        self._at_lower, self._at_upper = counted(values == at), counted((values == to) & (to > at))
        left = (values > at) & (values < to)
        self._lower, self._upper = lower, upper
        self._values, self._places, self._first = [values[left]], [places[left]], None

    def _sorted(self) -> NDArray[np.intp]:
        """Sort what is kept by place and value, and return where each place begins, and the end."""
        if self._first is None:
            values, places = np.concatenate(self._values), np.concatenate(self._places)
            order = np.argsort(values)
            small = places[order].astype(np.uint16) if len(self._lower) <= _SMALL else places[order]
            order = order[np.argsort(small, kind="stable")]
            self._values, self._places = [values[order]], [places[order]]
            counts = np.bincount(places, minlength=len(self._lower))
            self._first = np.concatenate([[0], np.cumsum(counts)])
        return self._first
