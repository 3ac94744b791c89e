"""What it changes that the open rim of a disc's upper face is worn away to a depth, from finite elements.

Units and partial fractions are those of `rig.partly_bonded`, whose forces these changes are added to. Each depth and
width is a mesh of its own, without the elements that are gone; widths and depths between are interpolated.

Accuracy: beside a mesh of half the intervals a plate moves within 1 % of its largest motion; between the tabled depths
it is moved within a tenth of what the depth changes, below half the first of them within a fifth.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve, eigh
from scipy.sparse.linalg import splu

from multilayer.arrays import ComplexArray, RealArray
from multilayer.rig.mesh import Section, Slab
from multilayer.rig.operators import Sparse, basis_of
from multilayer.rig.partly_bonded import (
    EDGES,
    FORCES,
    RIMS,
    WIDEST_RIM,
    WIDTHS,
    Forces,
    between,
    deflection,
    interpolation_weights,
    matrices,
    on_plate,
    partial_fractions,
    slope,
    weighed,
)
from multilayer.shared_results import shared

DEPTHS = (0.0, 1 / 32, 1 / 16, 1 / 8)  # shares of the height
_FINE = 1 - np.array([8, 6, 4, 3, 2, 1, 0]) / 64  # rows where the rim may be worn away
_ROWS = np.array([0, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.75, 0.8, 0.8375, *_FINE])
_CORE = 4  # elements of the part that always is bonded
_MOMENTS = 10
_EDGE = 1e-9
_ACTING = WIDTHS[np.isin(RIMS, EDGES)]  # widths as which rims that end at these act


def worn_change(
    poisson_ratio: float, shape: float, x: ComplexArray, rim: RealArray, depth: RealArray, eccentricity: float = 0.0
) -> tuple[ComplexArray, ...]:
    """Return the changes of the forces of `PartlyBondedDisc.stiffness` where the open rim is worn away.

    Parameters
    ----------
    poisson_ratio, shape : float
        As those of `partly_bonded_disc`.
    x : complex array, shape (..., n)
        ``rho w^2 h^2 / E``.
    rim, depth : array, shape (..., 1)
        Width of the open rim of the upper face as a share of the radius, and what is gone of it as a share of the
        height, 0 to 1/8; cut there.
    eccentricity : float
        As that of `PartlyBondedDisc.stiffness`.
    """
    x, rim, depth = np.broadcast_arrays(np.asarray(x, dtype=complex), rim, depth)
    whole, x = x.shape, x.reshape(-1, x.shape[-1])
    rim, depth = rim.reshape(x.shape), depth.reshape(x.shape)
    widths = rim[:, 0]
    within = np.clip(depth[:, 0], DEPTHS[0], DEPTHS[-1])
    of_depths = interpolation_weights(within, np.array(DEPTHS), range(len(DEPTHS)))
    of_depths[:, 0] -= 1  # changes from the rim that is not worn
    parts, rows, weights = list[tuple[int, float]](), [], []
    for deep, of_depth in zip(DEPTHS, of_depths.T, strict=True):
        # the edge of a neck concentrates the stress much less than that of an open rim
        numbers, index, of_rims = between(widths, EDGES if deep else _ACTING)
        rows.append(len(parts) + index)
        weights.append(of_depth[:, None] * of_rims)
        parts += [(number, deep) for number in numbers.tolist()]
    table = _table(poisson_ratio, shape, tuple(parts), eccentricity)
    forces = weighed(table, np.concatenate(rows, axis=1), np.concatenate(weights, axis=1), x)
    return tuple(forces.reshape(FORCES, *whole))


@lru_cache(maxsize=256)  # a search asks for the same rims again and again
def _table(poisson_ratio: float, shape: float, rims: tuple[tuple[int, float], ...], eccentricity: float) -> Forces:
    """Return the forces of rims, by number and depth, on a plate of some eccentricity."""
    return on_plate([_forces(poisson_ratio, shape, number, depth) for number, depth in rims], eccentricity)


@lru_cache(maxsize=4096)
@shared
def _forces(poisson_ratio: float, shape: float, number: int, depth: float) -> Forces:
    """Return the forces of the rim of a number, worn to a depth."""
    disc = _disc(poisson_ratio, shape)
    return disc.forces(EDGES[number], depth if number else 0.0)


@lru_cache(maxsize=16)
def _disc(poisson_ratio: float, shape: float) -> _Disc:
    radii = np.concatenate([np.linspace(0, 1 - WIDEST_RIM, _CORE + 1)[:-1], 1 - EDGES[::-1]]) * 2 * shape
    section = Section(radii, _ROWS, (Slab("sample", 0.0, 1.0, 1.0, 1.0),))
    return _Disc(section.mesh, poisson_ratio, 2 * shape)


@dataclass(frozen=True)
class _Disc:
    """The mesh of a disc of height 1, without the plates."""

    mesh: Any
    poisson_ratio: float
    radius: float

    @cached_property
    def basis(self) -> Any:
        """Functions on the disc that is not worn."""
        return basis_of(self.mesh)

    @cached_property
    def whole(self) -> tuple[Sparse, Sparse]:
        """Its stiffness and inertia."""
        return matrices(self.basis, self.poisson_ratio)

    def forces(self, rim: float, depth: float) -> Forces:
        """Return the forces with an open rim of the upper face, a share of the radius, worn to a depth."""
        edge = self.radius * (1 - rim) * (1 + _EDGE)
        across, up = self.mesh.p[:, self.mesh.t].mean(axis=1)
        is_worn = (across > edge) & (up > 1 - depth)
        stiffness, inertia = self.whole
        if is_worn.any():  # taken off the whole, as few elements are gone
            worn = matrices(basis_of(self.mesh, np.flatnonzero(is_worn)), self.poisson_ratio)
            stiffness, inertia = stiffness - worn[0], inertia - worn[1]
        r, z = self.basis.doflocs
        top, base, gone = np.isclose(z, 1) & (r < edge), np.isclose(z, 0), np.ones(len(r), dtype=bool)
        gone[self.basis.element_dofs[:, ~is_worn]] = False
        held = top | base | gone
        rigid = np.zeros((2 * len(r), 4))
        for column, face in enumerate((top, base, top)):
            rigid[len(r) + np.flatnonzero(face), column] = 1.0
        rigid[len(r) + np.flatnonzero(top), 2] = _weight(r[top] / self.radius)
        turned = top & (r > self.radius * (1 - WIDEST_RIM) * (1 + _EDGE))  # as in `rig.partly_bonded`
        rigid[np.flatnonzero(turned), 3] = slope(r[turned] / self.radius)
        free = np.flatnonzero(~np.concatenate([held | (r < _EDGE * self.radius), held]))
        solver = splu(stiffness[free][:, free], permc_spec="MMD_AT_PLUS_A")
        rigid[free] = -solver.solve((stiffness @ rigid)[free])
        motions = np.concatenate([rigid, _moments(solver, inertia, rigid, free)], axis=1)
        k, m = (motions.T @ (matrix @ motions) for matrix in (stiffness, inertia))
        others = np.arange(rigid.shape[1], len(k))
        inner, inner_mass = k[np.ix_(others, others)], m[np.ix_(others, others)]
        solve = partial(cho_solve, cho_factor(inner))
        by_plates = np.eye(len(k))[:, : rigid.shape[1]]
        return partial_fractions(k, m, by_plates, others, solve, eigh(inner, inner_mass), np.pi * self.radius**2)


def _moments(solver: Any, inertia: Any, rigid: RealArray, free: NDArray[np.intp]) -> RealArray:
    """Return motions of the free unknowns, orthonormal: those of the powers of x about 0.

    Forces of the disc on these are right to twice as many powers of x: R. W. Freund, Acta Numerica 12 (2003) 267-319.
    """
    inner_mass = inertia[free][:, free]
    block, width = (inertia @ rigid)[free], rigid.shape[1]
    found = np.zeros((len(free), _MOMENTS * width), order="F")
    for first in range(0, found.shape[1], width):
        block = solver.solve(block)
        for _ in range(2):  # once more, for what rounding leaves
            block = block - found[:, :first] @ (found[:, :first].T @ block)
        found[:, first : first + width], _ = np.linalg.qr(block)
        block = inner_mass @ found[:, first : first + width]
    motions = np.zeros((len(rigid), found.shape[1]))
    motions[free] = found
    return motions


def _weight(place: RealArray) -> RealArray:
    """Return `deflection`, its mean over the part that always is bonded there, as in `rig.partly_bonded`."""
    return deflection(np.where(place < (1 - WIDEST_RIM) * (1 - _EDGE), 0.0, place))
