"""Meshes of the rig's half section: rectangles in (r, z), finer towards the corners where stresses are singular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from skfem import MeshQuad

from multilayer.arrays import BoolArray, RealArray
from multilayer.errors import InputError

MOST_ELEMENTS = 20_000
_GROWTH = 2.0  # of neighbouring intervals towards a singular end


@dataclass(frozen=True)
class Slab:
    """One material over a height of the section.

    Attributes
    ----------
    name : str
    bottom, top : float
        Heights, m.
    size : float
        Largest interval in z, m.
    finest : float
        Interval at both ends, m: the singular corners lie there.
    """

    name: str
    bottom: float
    top: float
    size: float
    finest: float


@dataclass(frozen=True)
class Slit:
    """An interface at a height, m, that is open beyond a radius, m: nodes there are double."""

    height: float
    radius: float


@dataclass(frozen=True)
class Section:
    """A meshed half section.

    Attributes
    ----------
    radii, heights : array
        Lines of the grid, m.
    slabs : tuple of Slab
        From the base upwards.
    slits : tuple of Slit
    """

    radii: RealArray
    heights: RealArray
    slabs: tuple[Slab, ...]
    slits: tuple[Slit, ...] = ()

    @property
    def n_elements(self) -> int:
        """Number of elements."""
        return (len(self.radii) - 1) * (len(self.heights) - 1)

    @cached_property
    def mesh(self) -> MeshQuad:
        """The mesh; element ``i + j (n_r - 1)`` is the i-th from the axis in row j."""
        n_r, n_z = len(self.radii), len(self.heights)
        lower = np.arange(n_r * n_z).reshape(n_z, n_r)  # nodes as the row above a line sees them, and the row below
        upper = lower.copy()
        points = [np.stack([np.tile(self.radii, n_z), np.repeat(self.heights, n_r)])]
        total = n_r * n_z
        for slit in self.slits:
            j = int(np.argmin(np.abs(self.heights - slit.height)))
            open_ = np.flatnonzero(self.radii > slit.radius * (1 + 1e-9))
            upper[j, open_] = total + np.arange(len(open_))
            points.append(np.stack([self.radii[open_], np.full(len(open_), self.heights[j])]))
            total += len(open_)
        below, above = upper[:-1], lower[1:]
        corners = [below[:, :-1], below[:, 1:], above[:, 1:], above[:, :-1]]
        return MeshQuad(np.concatenate(points, axis=1), np.stack([c.ravel() for c in corners]))

    def elements(self, name: str) -> NDArray[np.intp]:
        """Return the indices of a slab's elements."""
        rows: BoolArray = np.zeros(len(self.heights) - 1, dtype=bool)
        middle = 0.5 * (self.heights[1:] + self.heights[:-1])
        for slab in self.slabs:
            if slab.name == name:
                rows |= (middle > slab.bottom) & (middle < slab.top)
        return np.flatnonzero(np.repeat(rows, len(self.radii) - 1))

    def halved(self) -> Section:
        """Return the same section with every interval halved."""
        return Section(_halved(self.radii), _halved(self.heights), self.slabs, self.slits)


def build_section(
    slabs: Sequence[Slab],
    radius: float,
    size: float,
    finest: float,
    stops: Sequence[float],
    slits: Sequence[Slit] = (),
    tips: Sequence[float] = (),
) -> Section:
    """Return the section of a stack of slabs of one radius.

    Parameters
    ----------
    slabs : sequence of Slab
    radius : float
        m.
    size, finest : float
        Largest interval in r, and the one at the rim, m.
    stops : sequence of float
        Radii where a line of the grid must lie, m; those beyond the rim are ignored.
    slits : sequence of Slit
        Their radii are stops, with fine intervals on both sides.
    tips : sequence of float
        Further radii of that kind, m, where the bond to a boundary ends.

    Raises
    ------
    InputError
        When the mesh would have more than `MOST_ELEMENTS` elements.
    """
    heights = [np.array([slabs[0].bottom])]
    for slab in slabs:
        heights.append(graded(slab.bottom, slab.top, slab.size, slab.finest, slab.finest)[1:])
    radii = _radial_lines(radius, size, finest, stops, [*tips, *(slit.radius for slit in slits)])
    section = Section(radii, np.concatenate(heights), tuple(slabs), tuple(slits))
    if section.n_elements > MOST_ELEMENTS:
        raise InputError(
            f"the mesh would need {section.n_elements} elements, the limit is {MOST_ELEMENTS}: the shortest wavelength "
            f"asks for intervals of {1e3 * size:.2g} mm; lower the highest frequency, or ask for a stiffer sample"
        )
    return section


def _radial_lines(
    radius: float, size: float, finest: float, stops: Sequence[float], tips: Sequence[float]
) -> RealArray:
    singular = {radius, *(t for t in tips if 0 < t < radius)}
    inside = {s for s in stops if 1e-6 * radius < s < (1 - 1e-6) * radius}
    ends = sorted({0.0, *singular, *inside})
    lines = [np.zeros(1)]
    for low, high in pairwise(ends):
        start, stop = (finest if end in singular else size for end in (low, high))
        lines.append(graded(low, high, size, start, stop)[1:])
    return np.concatenate(lines)


def graded(low: float, high: float, size: float, start: float, stop: float) -> RealArray:
    """Return lines from `low` to `high`, both included, whose intervals grow from the ends inwards.

    Parameters
    ----------
    low, high : float
    size : float
        Largest interval.
    start, stop : float
        Intervals at the two ends; each next one is twice as large until `size`.
    """
    length = high - low
    size = min(size, length)
    front, back = _growing(start, size, 0.5 * length), _growing(stop, size, 0.5 * length)
    rest = length - sum(front) - sum(back)
    n = max(1, int(np.ceil(rest / size - 1e-9)))
    steps = np.array([*front, *([rest / n] * n), *reversed(back)])
    lines = low + np.concatenate([[0.0], np.cumsum(steps)])
    lines[-1] = high
    return np.asarray(lines)


def _growing(first: float, size: float, room: float) -> list[float]:
    """Return growing intervals up to `size` that leave half of the room."""
    steps: list[float] = []
    step = first
    while step < size / _GROWTH**0.5 and sum(steps) + step <= 0.7 * room:
        steps.append(step)
        step *= _GROWTH
    return steps


def _halved(lines: RealArray) -> RealArray:
    return np.asarray(np.sort(np.concatenate([lines, 0.5 * (lines[1:] + lines[:-1])])))
