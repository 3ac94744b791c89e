"""The rod under a rigid mass: the transfer function method that the paper compares itself with."""

from __future__ import annotations

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray


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
