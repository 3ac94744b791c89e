"""Adaptive quadrature of many spectra side by side: absorption and transmission over directions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, BoolArray, IndexArray, RealArray

# Gauss-Kronrod pair of 7 and 15 nodes on [-1, 1] (QUADPACK, Piessens et al. 1983, routine qk15)
_NODES = np.array([
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
    0.741531185599394439863864773280788, 0.586087235467691130294144691693137, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0,
])  # fmt: skip
_KRONROD = np.array([
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
    0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714,
])  # fmt: skip
_GAUSS = np.array([
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
])  # fmt: skip
NODES = np.concatenate([-_NODES, _NODES[-2::-1]])
KRONROD = np.concatenate([_KRONROD, _KRONROD[-2::-1]])
GAUSS = np.zeros(15)
GAUSS[1::2] = np.concatenate([_GAUSS, _GAUSS[-2::-1]])

# Takes indices of items and abscissae, two arrays of shape (n_panels, 15), and gives, shape (5, n_panels, 15): weight,
# weighted absorption, weighted transmission, and the errors that the last two have already.
Integrand: TypeAlias = Callable[[IndexArray, RealArray], RealArray]

_LEAST_SHARE = 0.05  # of the tolerance, however narrow a panel
_LEAST_WIDTH = 1e-9  # of a panel, as a share of the whole


@dataclass(frozen=True)
class Tolerance:
    """Largest estimated error of a mean absorption, and of a mean transmission as a share of it."""

    absorption: float
    transmission: float

    @property
    def halved(self) -> Tolerance:
        """Half of both errors."""
        return Tolerance(self.absorption / 2, self.transmission / 2)


# of what goes through links, with the most panels: far below what the models of links are good for
LINKED, LINKED_PANELS = Tolerance(absorption=1.0, transmission=2e-3), 64


@dataclass(frozen=True)
class Panels:
    """Panels of a quadrature: the item of each, and its ends; arrays of shape (n_panels,)."""

    which: IndexArray
    low: RealArray
    high: RealArray

    @classmethod
    def joined(cls, parts: Sequence[Panels]) -> Panels:
        """Return all panels of several lots."""
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in ("which", "low", "high")))


def integrate(
    integrand: Integrand,
    n: int,
    upper: float,
    tolerance: Tolerance,
    max_panels: int,
    first: int = 1,
    exhausted: Callable[[], BoolArray] | None = None,
    accepted: list[Panels] | None = None,
) -> tuple[RealArray, RealArray]:
    """Return the integrals of `n` items from 0 to `upper`, with their errors.

    Parameters
    ----------
    integrand : callable
        See `Integrand`.
    n : int
        Number of items; each has its panels, and all are computed at once.
    upper : float
    tolerance : Tolerance
        Of the whole integral; each panel may err by its share of the width.
    max_panels : int
        Of each item.
    first : int
        Panels to start with.
    exhausted : callable, optional
        Tells which items have taken much work, shape (n,). Their panels are halved no more where the integrand's own
        errors and those of panels that are done exceed twice the tolerance: halving does not lessen these.
    accepted : list, optional
        Takes the panels that make the integrals.

    Returns
    -------
    rows : array, shape (5, n)
        Integrals of the weight, the absorption and the transmission, and the errors of the last two: those that the
        integrand has and that of the quadrature.
    points : array, shape (n,)
        Abscissae of each item.

    Notes
    -----
    Gauss-Kronrod panels of 15 nodes are halved where the rules of 15 and of 7 nodes disagree.
    """
    ends = np.linspace(0, upper, first + 1)
    which = np.repeat(np.arange(n), first)
    low, high = np.tile(ends[:-1], n), np.tile(ends[1:], n)
    done, points, panels = np.zeros((5, n)), np.zeros(n), np.full(n, float(first))
    while len(which):
        values, errors = _panels(integrand, which, low, high)
        np.add.at(points, which, len(NODES))
        scale = done[:3].copy()
        for row, part in zip(scale, values, strict=False):
            np.add.at(row, which, part)
        again = _too_coarse(errors, scale[:, which], (high - low) / upper, tolerance)
        again &= (panels[which] < max_panels) & (high - low > _LEAST_WIDTH * upper)
        if exhausted is not None and np.any(much := exhausted()):
            lasting = done[3:].copy()
            for row, part in zip(lasting, values[3:], strict=True):
                np.add.at(row, which, part)
            again &= ~(much & _too_coarse(lasting, scale, 2.0, tolerance))[which]
        kept = ~again
        values[3:] += errors
        for row, part in zip(done, values, strict=True):
            np.add.at(row, which[kept], part[kept])
        if accepted is not None:
            accepted.append(Panels(which[kept], low[kept], high[kept]))
        np.add.at(panels, which[again], 1)
        middle = 0.5 * (low + high)[again]
        which = np.concatenate([which[again]] * 2)
        low, high = np.concatenate([low[again], middle]), np.concatenate([middle, high[again]])
    return done, points


def nodes(low: RealArray, high: RealArray) -> RealArray:
    """Return the abscissae of panels, shape (n_panels, 15)."""
    return np.asarray((0.5 * (high + low))[:, None] + (0.5 * (high - low))[:, None] * NODES)


def _panels(integrand: Integrand, which: IndexArray, low: RealArray, high: RealArray) -> tuple[RealArray, RealArray]:
    """Return integrals over panels, and errors of the quadrature of absorption and transmission."""
    half, x = 0.5 * (high - low), nodes(low, high)
    rows = integrand(np.broadcast_to(which[:, None], x.shape), x)
    fine = half * np.array([row @ KRONROD for row in rows])
    coarse = half * np.array([row @ GAUSS for row in rows[1:3]])
    return fine, np.abs(fine[1:3] - coarse)


def _too_coarse(errors: RealArray, total: RealArray, share: ArrayLike, tolerance: Tolerance) -> BoolArray:
    """Tell which panels, or items, err by more than their share of the tolerance."""
    least = np.maximum(share, _LEAST_SHARE)
    with np.errstate(invalid="ignore"):  # without transmission there is nothing to compare
        coarse_tau = errors[1] > least * (tolerance.transmission * total[2])
    return np.asarray((errors[0] > least * tolerance.absorption * total[0]) | coarse_tau)


# Takes indices of items and abscissae in (0, 1), two arrays of shape (n_panels, 15), and gives (n_rows, n_panels, 15).
Rows: TypeAlias = Callable[[IndexArray, RealArray], RealArray]


def integrate_rows(
    integrand: Rows, owner: IndexArray, floor: RealArray, tolerance: float, max_panels: int
) -> tuple[RealArray, RealArray, RealArray]:
    """Return the integrals of several functions of each item from 0 to 1.

    Parameters
    ----------
    integrand : callable
        See `Rows`.
    owner : array of int, shape (n_items,)
        To which sum each item adds, as one interval of a longer integral.
    floor : array, shape (n_rows, n_owners)
        Integrals of the absolute values that the owners have already.
    tolerance : float
        Allowed error of each row, as a share of the integral of its absolute value over all items of its owner.
    max_panels : int
        Of each item.

    Returns
    -------
    rows, sizes, errors : array, shape (n_rows, n_items)
        Integrals, integrals of absolute values, and estimated errors.
    """
    n = len(owner)
    which, low, high = np.arange(n), np.zeros(n), np.ones(n)
    done = np.zeros((3, len(floor), n))
    panels = np.ones(n)
    while len(which):
        half = 0.5 * (high - low)
        values = integrand(which, (0.5 * (high + low))[:, None] + half[:, None] * NODES)
        parts = half * np.stack([values @ KRONROD, np.abs(values) @ KRONROD, np.abs(values @ (KRONROD - GAUSS))])
        sizes = floor.copy()
        for row, settled, part in zip(sizes, done[1], parts[1], strict=True):
            np.add.at(row, owner, settled)
            np.add.at(row, owner[which], part)
        allowed = tolerance * np.maximum(high - low, _LEAST_SHARE) * sizes[:, owner[which]]
        again = np.any(parts[2] > allowed, axis=0) & (panels[which] < max_panels) & (high - low > _LEAST_WIDTH)
        for result, part in zip(done, parts, strict=True):
            for row, values_of_row in zip(result, part, strict=True):
                np.add.at(row, which[~again], values_of_row[~again])
        np.add.at(panels, which[again], 1)
        middle = 0.5 * (low + high)[again]
        which = np.concatenate([which[again]] * 2)
        low, high = np.concatenate([low[again], middle]), np.concatenate([middle, high[again]])
    return done[0], done[1], done[2]
