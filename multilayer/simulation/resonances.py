"""Resonances between the frequencies that stand for a band, and means over the band that hold them.

The frequencies that stand for a band are midpoints of equal parts of it. Where the response does not run straight from
each to the next, as beside a cavity's resonance at one angle of incidence, the parts there are cut in three, again and
again, until it does: points gather about what is narrow, and few are added elsewhere. Of single frequencies the same
tells what lies hidden between them.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, RealArray

UNEVEN = {"transmission_loss": 0.5, "absorption": 0.02}
"""Twice how far a value may lie off the straight line between its neighbours: a mean is then right to 1/24 of it."""
_HIDDEN = {"transmission_loss": 3.0, "absorption": 0.2}  # beyond both neighbours: a curve through these looks wrong
_CUTS = 13  # each in three: a part of 1e-8 of a third octave
_FEWEST_LINES = 3
_MOST_PARTS = 3000  # of a band

Arrays = Mapping[str, NDArray[Any]]


@dataclass(frozen=True, eq=False)
class Parts:
    """The parts of a band, in order.

    Attributes
    ----------
    place, width : array, shape (n,)
        Middle and width of each on the logarithmic axis.
    values : dict of array, shape (n,)
        By quantity, those in the middle.
    even : bool
        Whether the response runs straight from each part to the next.
    """

    place: RealArray
    width: RealArray
    values: Arrays
    even: bool = False

    @classmethod
    def equal(cls, frequency: RealArray, values: Arrays) -> Parts:
        """Return equal parts about frequencies, Hz."""
        place = np.log(frequency)
        return cls(place, np.full(len(place), (place[-1] - place[0]) / (len(place) - 1)), values)

    def weights(self) -> RealArray:
        """Return the share of each part in the band."""
        return np.asarray(self.width / np.sum(self.width))

    def uneven(self) -> BoolArray:
        """Tell which parts the response does not pass straight."""
        return uneven(self.place, self.values)


def uneven(place: RealArray, values: Arrays, limits: Mapping[str, float] = UNEVEN) -> BoolArray:
    """Tell at which places a response lies off the straight line between its neighbours; an end is as its neighbour.

    Parameters
    ----------
    place : array, shape (..., n)
        On any axis, rising.
    values : mapping
        By quantity, arrays of the shape (..., n); what is not finite is no reason.
    limits : mapping
        By quantity, how far off is too far.
    """
    before, behind = np.diff(place)[..., :-1], np.diff(place)[..., 1:]
    off = np.zeros_like(before, dtype=bool)
    for quantity, limit in limits.items():
        if quantity in values:
            y = values[quantity]
            with np.errstate(invalid="ignore"):
                line = (y[..., :-2] * behind + y[..., 2:] * before) / (before + behind)
                off = off | (2 * np.abs(y[..., 1:-1] - line) > limit)
    return np.concatenate([off[..., :1], off, off[..., -1:]], axis=-1)


def resolved(bands: Sequence[Parts], respond: Callable[[RealArray], Arrays], most: int = _MOST_PARTS) -> list[Parts]:
    """Return bands with their parts cut until the response runs straight from each to the next.

    Parameters
    ----------
    bands : sequence of Parts
    respond : callable
        Gives the quantities at frequencies, Hz, shape (n,).
    most : int
        Parts of a band from which on it is cut no further.
    """
    done = list(bands)
    for _ in range(_CUTS):
        cut = [parts.uneven() if len(parts.place) < most else np.zeros(len(parts.place), bool) for parts in done]
        if not any(np.any(which) for which in cut):
            break
        third = [parts.width[which] / 3 for parts, which in zip(done, cut, strict=True)]
        new = [
            np.concatenate([parts.place[which] - step, parts.place[which] + step])
            for parts, which, step in zip(done, cut, third, strict=True)
        ]
        values = respond(np.exp(np.concatenate(new)))
        ends = np.cumsum([len(places) for places in new])
        done = [
            _with(parts, which, places, {name: value[end - len(places) : end] for name, value in values.items()})
            for parts, which, places, end in zip(done, cut, new, ends, strict=True)
        ]
    return [Parts(parts.place, parts.width, parts.values, not np.any(parts.uneven())) for parts in done]


class Hidden(NamedTuple):
    """How far a quantity between two neighbouring frequencies goes beyond both, up or down, and at which, Hz."""

    quantity: str
    beyond: float
    frequency: float


def hidden(frequency: RealArray, values: Arrays, respond: Callable[[RealArray], Arrays]) -> list[Hidden]:
    """Return what single frequencies hide of the transmission loss and the absorption, the most of each.

    Only beside frequencies that the response does not pass straight are others tried.

    Parameters
    ----------
    frequency : array, shape (n,)
        Hz, rising.
    values : mapping
        By quantity, arrays of the shape (n,).
    respond : callable
        Gives the quantities at frequencies, Hz.
    """
    if len(frequency) < _FEWEST_LINES:
        return []
    place, first, last = np.log(frequency), float(frequency[0]), float(frequency[-1])
    shown = {name: values[name] for name in _HIDDEN if name in values}
    parts = Parts(place, np.gradient(place), shown)  # the outer ones reach beyond the range, which is not asked for
    (fine,) = resolved([parts], lambda f: respond(np.clip(f, first, last)), len(place) + _MOST_PARTS)
    within = (fine.place > place[0]) & (fine.place < place[-1])
    right = np.searchsorted(place, fine.place[within])
    most = []
    for name, ends in shown.items():
        value = fine.values[name][within]
        beyond = value - np.clip(value, *np.sort([ends[right - 1], ends[right]], axis=0))
        beyond = np.where(np.isfinite(beyond), beyond, 0.0)
        at = int(np.argmax(np.abs(beyond)))
        if abs(beyond[at]) > _HIDDEN[name]:
            most.append(Hidden(name, float(beyond[at]), float(np.exp(fine.place[within][at]))))
    return most


def _with(parts: Parts, which: BoolArray, new: RealArray, values: Arrays) -> Parts:
    """Return parts, some of them cut in three, by the places of the new ones and the response there."""
    width = np.where(which, parts.width / 3, parts.width)
    place = np.concatenate([parts.place, new])
    order = np.argsort(place, kind="stable")
    joined = {name: np.concatenate([parts.values[name], values[name]])[order] for name in values}
    return Parts(place[order], np.concatenate([width, width[which], width[which]])[order], joined)
