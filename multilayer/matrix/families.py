"""State families: which quantities describe the field at a face, and which of them a wall holds still."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from multilayer.arrays import IndexArray


@dataclass(frozen=True)
class Family:
    """A kind of state vector.

    Attributes
    ----------
    name : str
    components : tuple of str
        Names of the entries, velocities in m/s and stresses in Pa, axis 3 pointing from excitation to termination.
    power_pairs : tuple of (int, int, int)
        (velocity index, stress index, sign): ``Re(sign * stress * conj(velocity)) / 2`` is the power per area that
        this pair carries towards +x3; each velocity and each stress stands in exactly one pair.
    even : tuple of int
        Indices of one half of the state; the field equations couple it to the other half only, so that
        ``d(even)/dx3 = X odd`` and ``d(odd)/dx3 = Y even``.
    """

    name: str
    components: tuple[str, ...]
    power_pairs: tuple[tuple[int, int, int], ...]
    even: tuple[int, ...]

    @cached_property
    def size(self) -> int:
        """Number of entries of the state."""
        return len(self.components)

    @cached_property
    def half(self) -> int:
        """Number of waves in each direction."""
        return len(self.components) // 2

    @cached_property
    def odd(self) -> tuple[int, ...]:
        """Indices of the other half of the state."""
        return tuple(i for i in range(self.size) if i not in self.even)

    @cached_property
    def blocks(self) -> dict[str, tuple[IndexArray, IndexArray]]:
        """Indices of the four blocks of a matrix on states: ``even_odd`` has rows of `even` and columns of `odd`."""
        halves = {"even": self.even, "odd": self.odd}
        return {
            f"{row}_{column}": (np.array(rows)[:, None], np.array(columns)[None])
            for row, rows in halves.items()
            for column, columns in halves.items()
        }

    @cached_property
    def reciprocal_pairs(self) -> tuple[tuple[int, int, int], ...]:
        """Of every power pair the places in `even` and in `odd`, and the sign with which waves are orthogonal in it.

        Of ``velocity stress' - stress velocity'`` what comes back has the odd half turned round, and what runs the
        other way along axis 1 the velocity and the shear along it.
        """
        pairs = []
        for velocity, stress, sign in self.power_pairs:
            turned = -1 if self.components[velocity].startswith("v1") else 1
            if stress in self.even:
                pairs.append((self.even.index(stress), self.odd.index(velocity), sign * turned))
            else:
                pairs.append((self.even.index(velocity), self.odd.index(stress), -sign * turned))
        return tuple(pairs)

    def index(self, component: str) -> int:
        """Return the position of a component."""
        return self.components.index(component)


FLUID = Family("fluid", ("p", "v3"), ((1, 0, 1),), even=(0,))
SOLID = Family("solid", ("v1", "v3", "s33", "s13"), ((1, 2, -1), (0, 3, -1)), even=(0, 2))
POROELASTIC = Family(
    "poroelastic",
    ("v1s", "v3s", "v3f", "s33s", "s13s", "s33f"),
    ((1, 3, -1), (2, 5, -1), (0, 4, -1)),
    even=(0, 3, 5),
)


def normal_velocity(family: Family) -> int:
    """Return the index of the normal velocity (of the frame) in a state."""
    return next(i for i, name in enumerate(family.components) if name.startswith("v3"))
