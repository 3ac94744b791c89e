"""Transmission through walls whose leaves are linked, of plane waves and in a diffuse field."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Protocol

import numpy as np

from multilayer.arrays import IndexArray, RealArray
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import POINTS, in_chunks
from multilayer.response.diffuse_field import Weighting, WeightingName, angle_of, diffuse_field, weighting_function
from multilayer.response.finite_size import Window, finite_transmission, radiation_at
from multilayer.response.links import LineLinks, PointLinks, periodic
from multilayer.response.periodic_links import PeriodicLinks
from multilayer.response.quadrature import LINKED, LINKED_PANELS, NODES, integrate
from multilayer.response.single_links import SingleLinks
from multilayer.stack import Stack

# directions of periodic links, and steps of azimuths; the first two for means over frequencies only
_LATTICES = ((34, 21), (89, 55), (233, 144), (610, 377), (1597, 987))
_SHIFTS = 0.7548776662466927, 0.5698402909980532  # of the lattice of the next frequency (R2 sequence of M. Roberts)
# change by more directions, as a share: of a mean over frequencies, whose errors add up as squares, and of one alone,
# which may be off by as much before and after
_ENOUGH_OF_MEAN, _ENOUGH_ALONE = 0.05, 0.01


class _Linked(Protocol):
    """What goes through a wall with links."""

    def through(self, which: IndexArray, wave: Wave) -> tuple[RealArray, RealArray, RealArray]:
        """Return the power that goes on as it came, that into other directions, and the first without links."""
        ...


def linked_transmission(
    stack: Stack,
    links: Sequence[LineLinks | PointLinks],
    frequency: RealArray,
    angle: float | None = None,
    *,
    max_angle: float = 78.0,
    weighting: WeightingName = "uniform",
    window: Window | None = None,
    together: int = 1,
    alone: RealArray | None = None,
) -> RealArray:
    """Return the power that a stack with links between its leaves transmits, over the power that arrives.

    Parameters
    ----------
    stack : Stack
        Between half-spaces of its ambient gas, isotropic in its plane; its fields hold numbers.
    links : sequence of LineLinks or PointLinks
        Those of one kind and spacing lie on the same lines or points, so that forces go through a leaf between them.
    frequency : array, shape (n_frequency,)
        Hz.
    angle : float, optional
        Of plane waves, degrees; a diffuse field when left out. Of periodic links, the mean over all azimuths.
    max_angle, weighting
        Of the diffuse field, as of `diffuse_field`.
    window : Window, optional
        Size of the wall; it corrects the wave that goes on as it came.
    together : int
        So many frequencies after each other are averaged by the caller, as those of a band; only their mean is exact.
    alone : array, shape (n_frequency,), optional
        What the stack transmits in the same field without links, where that is known.

    Returns
    -------
    array, shape (n_frequency,)

    Notes
    -----
    See `SingleLinks` and `PeriodicLinks`. Of the latter, directions are added until the mean over them changes by less
    than 1 %, or the mean over frequencies by 5 %, which errs by less than half of that then, up to 1597: within 0.15 dB
    rms at single frequencies and 1 dB at most, and 0.2 dB in third octaves.
    """
    lines = periodic(links)
    upper = float(np.sin(np.deg2rad(max_angle if angle is None else angle)))
    relative, gas = weighting_function(weighting), stack.ambient.gas
    if lines and angle is None and alone is None:
        field = diffuse_field(stack, frequency, max_angle, weighting=weighting, window=window)
        alone = field.transmission_coefficient

    def compute(these: IndexArray) -> RealArray:
        piece = frequency[these.ravel()]
        linked: _Linked = PeriodicLinks(stack, lines, piece) if lines else SingleLinks(stack, links, piece)
        k = 2 * np.pi * piece / gas.sound_speed
        radiation = None if window is None else radiation_at(window, k, float(np.max(k)) * upper, 3 * len(NODES))

        def tau(
            which: IndexArray, s: RealArray, azimuth: RealArray | float = 0.0, *, beyond: bool = False
        ) -> RealArray:
            """Return the transmission of plane waves, or how far it is beyond that without links."""
            wave, cosine = Wave(piece[which], k[which] * np.sqrt(s), gas, azimuth), np.sqrt(1 - s)
            onward, other, alone = linked.through(which, wave)
            if radiation is not None:
                radiated = radiation.efficiency(which, wave.kx.real)
                onward, alone = (finite_transmission(power, radiated, cosine) for power in (onward, alone))
            return np.asarray(onward + other - alone if beyond else onward + other)

        if lines and angle is not None:
            return _over_directions(tau, np.zeros(len(piece)), upper, None, together)
        if lines:
            assert alone is not None  # by validation
            return _over_directions(partial(tau, beyond=True), alone[these.ravel()], upper, relative, together)
        if angle is not None:
            return tau(np.arange(len(piece)), np.full(len(piece), upper**2))

        def integrand(which: IndexArray, s: RealArray) -> RealArray:
            weight, nothing = relative(angle_of(s)), np.zeros_like(s)
            return np.array([weight, nothing, weight * tau(which, s), nothing, nothing])

        rows, _ = integrate(integrand, len(piece), upper**2, LINKED, LINKED_PANELS)
        return np.asarray(rows[2] / rows[0])

    n_angles = _LATTICES[0][0] if lines else 2 * len(NODES)
    return np.concatenate(in_chunks(compute, stack, np.arange(len(frequency)).reshape(-1, together), n_angles))


def _over_directions(
    tau: Callable[[IndexArray, RealArray, RealArray], RealArray],
    alone: RealArray,
    upper: float,
    relative: Weighting | None,
    together: int,
) -> RealArray:
    """Return the mean over azimuths, and over a diffuse field's angles.

    By Fibonacci's lattices over sin^2 of the angle and a quarter of a turn of the azimuth, folded so that both are
    periodic (F. J. Hickernell, in: Monte Carlo and Quasi-Monte Carlo Methods 2000 (2002) 274-289): what lines send on
    has ridges, along which harmonics meet free waves, and no row of a lattice lies along them. Frequencies that are
    averaged have lattices of their own, shifted against each other, whose errors cancel for the most part.

    Parameters
    ----------
    tau : callable
        Takes indices of frequencies, squared sines of angles, and azimuths in degrees; three arrays that broadcast.
    alone : array, shape (n_frequency,)
        What is added to the mean: peaks of the stack without links are narrow in the angle, and known better.
    upper : float
        Sine of the largest angle, or of the only one.
    relative : callable, optional
        Weighting of the angles of a diffuse field.
    together : int
        As of `linked_transmission`.
    """
    total, going = alone.copy(), np.arange(len(alone)).reshape(-1, together)
    before = np.full(going.shape, np.nan)
    lattices, enough = (_LATTICES, _ENOUGH_OF_MEAN) if together > 1 else (_LATTICES[2:], _ENOUGH_ALONE)
    for number, steps in lattices:
        step = max(1, POINTS // number)
        for some in (going.ravel()[i : i + step] for i in range(0, going.size, step)):
            shift = (some % together)[:, None]
            s, azimuth = (
                _folded(np.arange(number) * times / number + 0.25 / number + shift * by)
                for times, by in zip((1, steps), _SHIFTS, strict=True)
            )
            if relative is None:
                s, weight = np.full_like(s, upper**2), np.ones_like(s)
            else:
                s = upper**2 * s
                weight = relative(angle_of(s))
            values = weight * tau(np.broadcast_to(some[:, None], s.shape), s, 90 * azimuth)
            total[some] = alone[some] + np.sum(values, axis=1) / np.sum(weight, axis=1)
        values = total[going]
        change = np.sqrt(np.sum((values - before) ** 2, axis=1))  # of the sum, as errors of its terms are independent
        is_coarse = ~(change <= enough * np.abs(np.sum(values, axis=1)))
        going, before = going[is_coarse], values[is_coarse]
        if not going.size:
            break
    return total


def _folded(places: RealArray) -> RealArray:
    """Return places of a period, 0 to 1, folded so that what is taken there is even about both ends."""
    return np.asarray(1 - np.abs(2 * (places % 1) - 1))
