"""Isotropic elasticity and its plane waves."""

from __future__ import annotations

from typing import TypeVar

import numpy as np

from multilayer.arrays import ComplexArray, Numeric

N = TypeVar("N", float, Numeric)
# 2 pi f R^2 sqrt(rho h / D) of the first axisymmetric mode of a free disc with a Poisson's ratio of 0.3 (A. W. Leissa,
# Vibration of Plates, NASA SP-160, 1969, ch. 2)
FIRST_BENDING = 9.003


def lame(young_modulus: Numeric, poisson_ratio: Numeric) -> tuple[Numeric, Numeric]:
    """Return Lame's coefficients (lambda, mu), Pa; Bonfiglio & Pompoli 2015, eq. (8).

    `poisson_ratio` within (-1, 0.5), both ends excluded.
    """
    mu = young_modulus / (2 * (1 + poisson_ratio))
    return 2 * mu * poisson_ratio / (1 - 2 * poisson_ratio), mu


def p_wave_modulus(young_modulus: Numeric, poisson_ratio: Numeric) -> Numeric:
    """Return lambda + 2 mu, Pa: the modulus of laterally constrained compression."""
    lam, mu = lame(young_modulus, poisson_ratio)
    return lam + 2 * mu


def flexural_rigidity(young_modulus: N, poisson_ratio: N, thickness: N) -> N:
    """Return the bending stiffness of a thin plate per width, N m; S. P. Timoshenko & S. Woinowsky-Krieger 1959, ch. 1.

    Parameters
    ----------
    young_modulus : complex array
        Pa.
    poisson_ratio, thickness : array
        1 and m.
    """
    return young_modulus * thickness**3 / (12 * (1 - poisson_ratio**2))


def decaying_root(square: Numeric) -> ComplexArray:
    """Return the wavenumber whose wave exp(-i k x) decays (or travels) towards +x, from its square.

    Im(k) <= 0; a lossless travelling wave (Im = 0) keeps Re(k) >= 0.
    """
    if np.isrealobj(square):
        size = np.sqrt(np.abs(square))
        return np.where(np.asarray(square) >= 0, size, -1j * size)
    root = np.asarray(np.sqrt(np.asarray(square, dtype=complex)))  # principal branch: Re >= 0
    np.negative(root, out=root, where=root.imag > 0)
    return root
