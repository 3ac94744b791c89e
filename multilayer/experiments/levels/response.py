"""The response of a stack as a measurement of levels asks for it; what was computed of it is remembered."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.interpolate import CubicSpline

from multilayer.arrays import IndexArray, RealArray
from multilayer.experiments.levels.sound_field import Quantity, Ridges, SoundField, mean_power
from multilayer.stack import Stack

_REMEMBERED = 4096  # samples
_SHARES = (1e-30, 1e3)  # to which shares are limited: a search passes over such as have no level


@dataclass(frozen=True, eq=False)
class LevelResponse:
    """Level or absorption of a stack in the sound field of a measurement.

    Attributes
    ----------
    quantity : {'transmission_loss', 'absorption'}
    nodes : array, shape (n, p)
        Frequencies that stand for each datum, Hz.
    sound : SoundField
    ridges : Ridges
    """

    quantity: Quantity
    nodes: RealArray
    sound: SoundField
    ridges: Ridges
    _shares: dict[Hashable, RealArray] = field(default_factory=dict, repr=False)
    _tables: dict[Hashable, Table] = field(default_factory=dict, repr=False)

    def __call__(self, stack: Stack) -> RealArray:
        """Return the level, dB, or the absorption coefficient, shape (..., n)."""
        return level_of(self.quantity, self.share(stack))

    def share(self, stack: Stack) -> RealArray:
        """Return the share of the power, shape (m, n)."""
        return mean_power(self.quantity, stack, self.sound, self.nodes, self.ridges)

    def at(self, index: IndexArray) -> LevelResponse:
        """Return the response at some of its frequencies, by their indices, with what is remembered of these."""
        shares = {key: share[index] for key, share in self._shares.items()}
        tables = {key: table.at_index(index) for key, table in self._tables.items()}
        return replace(self, nodes=self.nodes[index], _shares=shares, _tables=tables)

    @property
    def forgetful(self) -> LevelResponse:
        """The response without what is remembered: for other stacks."""
        return replace(self, _shares={}, _tables={})

    @property
    def n_waves(self) -> int:
        """Number of plane waves."""
        return int(self.nodes.size) * (self.ridges.n_directions if self.sound.is_diffuse else 1)

    def remembered(self, names: Hashable, rows: RealArray, compute: Callable[[RealArray], RealArray]) -> RealArray:
        """Return shares, shape (m, n), for rows of coordinates and parameters, computing each distinct row once.

        Parameters
        ----------
        names : hashable
            Of what acts.
        rows : array, shape (m, k)
        compute : callable
            Of rows.
        """
        keys = [(names, row.tobytes()) for row in np.ascontiguousarray(rows)]
        missing = {key: i for i, key in enumerate(keys) if key not in self._shares}
        if missing:
            self._shares.update(zip(missing, compute(rows[[*missing.values()]]), strict=True))
        found = np.stack([self._shares[key] for key in keys])
        for key in [*self._shares][: max(len(self._shares) - _REMEMBERED, 0)]:
            del self._shares[key]
        return found

    def table(self, key: Hashable, at: RealArray, compute: Callable[[RealArray], RealArray]) -> Table:
        """Return a table of shares over values of a parameter, shape (g,), computed when it is first asked for.

        `compute` takes such values as a column, shape (g, 1).
        """
        if key not in self._tables:
            self._tables[key] = Table.of(at, np.log(compute(at[:, None])))
        return self._tables[key]


@dataclass(frozen=True, eq=False)
class Table:
    """Cubic splines of some functions of one parameter.

    Attributes
    ----------
    at : array, shape (g,)
        Evenly spaced values of the parameter.
    coefficients : array, shape (4, g - 1, n)
        Highest power first.
    """

    at: RealArray
    coefficients: RealArray

    @classmethod
    def of(cls, at: RealArray, values: RealArray) -> Table:
        """Return the splines through values of shape (g, n)."""
        return cls(at, CubicSpline(at, values, axis=0).c)

    def __call__(self, x: RealArray) -> RealArray:
        """Return the functions, each at its own value of the parameter, shape (..., n); ends hold beyond the table."""
        inside = np.clip(x, self.at[0], self.at[-1])
        step = self.at[1] - self.at[0]
        below = np.clip(((inside - self.at[0]) / step).astype(int), 0, len(self.at) - 2)
        t = inside - self.at[below]
        a, b, c, d = self.coefficients[:, below, np.arange(x.shape[-1])]
        return np.asarray(((a * t + b) * t + c) * t + d)

    def at_index(self, index: IndexArray) -> Table:
        """Return some of the functions."""
        return Table(self.at, self.coefficients[..., index])


@np.errstate(all="ignore")
def level_of(quantity: Quantity, share: RealArray) -> RealArray:
    """Return the level, dB, of a share of power that gets through; absorption as it is."""
    return np.asarray(-10 * np.log10(np.clip(share, *_SHARES))) if quantity == "transmission_loss" else share
