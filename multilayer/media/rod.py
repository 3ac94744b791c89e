"""Longitudinal waves in rods: under a rigid mass (the transfer function method), and in chains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, Numeric


def rod_transmissibility(
    frequency: ArrayLike, modulus: ArrayLike, density: float, length: float, mass_per_area: float
) -> ComplexArray:
    """Return top over base motion of a rod-like sample under a rigid mass.

    Bonfiglio & Pompoli 2015, eq. (11); T. Pritz, J. Sound Vib. 81 (1982) 359-376.

    Parameters
    ----------
    frequency : array
        Hz.
    modulus : complex array
        Young's modulus of a slender rod, or lambda + 2 mu of a sample held at its rim, Pa.
    density : float
        kg/m3.
    length : float
        m.
    mass_per_area : float
        Of the top plate, kg/m2.
    """
    propagation = 2j * np.pi * np.asarray(frequency) * np.sqrt(density / np.asarray(modulus, dtype=complex)) * length
    ratio = mass_per_area / (density * length)
    return np.asarray(1 / (np.cosh(propagation) + ratio * propagation * np.sinh(propagation)))


def chain_transmissibility(frequency: ArrayLike, layers: Sequence[tuple[Numeric, Numeric, Numeric]]) -> ComplexArray:
    """Return the motion of the free end of a chain of rods over that of its driven end.

    Parameters
    ----------
    frequency : array
        Hz.
    layers : sequence of (modulus, density, thickness)
        From the driven to the free end: Young's modulus for slender rods, lambda + 2 mu for layers of infinite extent
        (compression waves at normal incidence), Pa; kg/m3; m. All broadcast against `frequency`.

    Notes
    -----
    The impedance that loads each rod is carried from the free end to the driven one. Time exp(+i w t).
    """
    turning = -2j * np.pi * np.asarray(frequency, dtype=float)
    load: Numeric | None = None  # force over velocity per area at the far end, which is free at first
    ratio: Numeric = 1.0
    for modulus, density, thickness in reversed(layers):
        slowness = np.sqrt(density / np.asarray(modulus, dtype=complex))
        characteristic = modulus * slowness
        # over exp(i k h), which grows: nothing overflows, however lossy and thick
        decay = np.exp(turning * (thickness * slowness))
        square = decay * decay
        half = 1 / (1 + square)
        tangent = (1 - square) * half  # i tan(k h)
        ratio = ratio * (2 * decay * half)
        if load is None:
            load = characteristic * tangent
            continue
        relative = load / characteristic
        step = 1 / (1 + relative * tangent)
        ratio = ratio * step
        load = characteristic * (relative + tangent) * step
    return np.asarray(ratio)
