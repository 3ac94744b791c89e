"""Face matrices: how the states at a layer's two faces depend on the layer's coefficients.

    V(front) = A c        V(back) = B c

The first half of ``c`` are waves (or wave-like amplitudes) going towards +x3, the second half towards -x3. Two ways to
make them:

- `from_waves`: plane waves, each exponential referred to the face it decays from, so that nothing overflows;
- `from_system`: the propagator of the field equations by its power series, for layers thin beside the wavelengths,
  where waves would cancel each other to the last digits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, Numeric, RealArray
from multilayer.matrix.families import Family

Entries = Sequence[Sequence[Numeric]]
THIN = 1.0  # largest |k| h of the power series
_TERMS = 11  # the first term left out is below 1 / 22! = 1e-21


@dataclass(frozen=True)
class Faces:
    """Face matrices of one layer.

    Attributes
    ----------
    family : Family
    front, back : complex array, shape (n_state, n_coefficients, ...)
        The matrices A and B.
    porosity : float or array
        Open area at the faces; 1 for families without pores.
    """

    family: Family
    front: ComplexArray
    back: ComplexArray
    porosity: Numeric = 1.0


def stack_entries(entries: Entries) -> ComplexArray:
    """Return nested entries, broadcast against each other, as one array of shape (rows, columns, ...)."""
    shape = np.broadcast_shapes(*(np.shape(entry) for row in entries for entry in row))
    matrix = np.empty((len(entries), len(entries[0]), *shape), dtype=complex)
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            matrix[i, j] = entry
    return matrix


def multiply(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the matrix product of entry-first matrices, broadcasting their trailing axes."""
    result: ComplexArray = np.einsum("ij...,jk...->ik...", a, b)
    return result


def from_waves(forward: Entries, backward: Entries, wavenumbers: Sequence[Numeric], thickness: Numeric) -> tuple[
    ComplexArray, ComplexArray
]:
    """Return (A, B) from the states of unit waves.

    Parameters
    ----------
    forward, backward : entries, shape (n_state, n_waves)
        States of the waves exp(-i k x3) and exp(+i k x3) where their exponential is 1.
    wavenumbers : sequence
        k along x3 of each wave, Im(k) <= 0.
    thickness : float or array
    """
    decay = stack_entries([[np.exp(-1j * k * thickness) for k in wavenumbers]])
    ahead, back = stack_entries(forward), stack_entries(backward)
    a = np.concatenate(np.broadcast_arrays(ahead, back * decay), axis=1)
    b = np.concatenate(np.broadcast_arrays(ahead * decay, back), axis=1)
    return a, b


def amplitudes(family: Family, impedance: float) -> ComplexArray:
    """Return the constant matrix W that makes a state from wave-like amplitudes.

    Each power pair becomes ``v = c+ + c-``, ``sign * stress = impedance * (c+ - c-)``. A passive termination answers
    any c+ by a c- of no more power, whatever the impedance: a basis without resonances of its own.
    """
    w = np.zeros((family.size, family.size), dtype=complex)
    for wave, (velocity, stress, sign) in enumerate(family.power_pairs):
        w[velocity, wave] = w[velocity, wave + family.half] = 1
        w[stress, wave] = sign * impedance
        w[stress, wave + family.half] = -sign * impedance
    return w


def from_propagator(
    family: Family, propagator: ComplexArray, impedance: float
) -> tuple[ComplexArray, ComplexArray]:
    """Return (A, B) from the matrix P that carries the front state to the back, V(back) = P V(front).

    ``P = T^-1`` with the transfer matrix T of Allard & Atalla. `impedance` (Pa s/m) scales the amplitudes and should
    be that of the surroundings.
    """
    w = amplitudes(family, impedance)
    b = multiply(propagator, w)
    return np.broadcast_to(w.reshape(w.shape + (1,) * (b.ndim - 2)), b.shape), b


def propagator_series(family: Family, x: Entries, y: Entries, thickness: Numeric) -> ComplexArray:
    """Return exp(M h) for the field equations d(even)/dx3 = X odd, d(odd)/dx3 = Y even.

    Power series of cosh and sinh of a half-size matrix; exact to rounding for |k| h up to `THIN`, entry by entry:
    unlike a sum of waves it keeps the small bending terms of thin stiff layers.
    """
    X, Y = stack_entries(x), stack_entries(y)
    h = np.asarray(thickness, dtype=complex)
    xy, yx = multiply(X, Y) * h**2, multiply(Y, X) * h**2
    cosh_even, sinh_even = _cosh_sinh(xy)
    cosh_odd, sinh_odd = _cosh_sinh(yx)
    ahead, behind = multiply(sinh_even, X) * h, multiply(sinh_odd, Y) * h
    p = np.empty((family.size, family.size, *np.broadcast_shapes(cosh_even.shape, ahead.shape)[2:]), dtype=complex)
    even, odd = family.even, family.odd
    p[np.ix_(even, even)], p[np.ix_(even, odd)] = cosh_even, ahead
    p[np.ix_(odd, even)], p[np.ix_(odd, odd)] = behind, cosh_odd
    return p


def _cosh_sinh(square: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return sum(M^n / (2n)!) and sum(M^n / (2n + 1)!) by Horner's rule."""
    eye = np.eye(square.shape[0], dtype=complex).reshape(square.shape[:2] + (1,) * (square.ndim - 2))
    cosh = sinh = np.broadcast_to(eye, square.shape)
    for n in range(_TERMS, 0, -1):
        cosh = eye + multiply(square, cosh) / (2 * n * (2 * n - 1))
        sinh = eye + multiply(square, sinh) / (2 * n * (2 * n + 1))
    return cosh, sinh


def choose(
    thin: BoolArray,
    series: Callable[[], tuple[ComplexArray, ComplexArray]],
    waves: Callable[[], tuple[ComplexArray, ComplexArray]],
) -> tuple[ComplexArray, ComplexArray]:
    """Return the face matrices of `series` where `thin`, of `waves` elsewhere, computing only what is needed."""
    if np.all(thin):
        return series()
    if not np.any(thin):
        return waves()
    (a, b), (c, d) = series(), waves()
    return np.where(thin, a, c), np.where(thin, b, d)


def is_thin(wavenumbers: Sequence[Numeric], kx: RealArray, thickness: Numeric) -> BoolArray:
    """Tell where a layer is thin beside every wavelength in it, along x3 and along x1."""
    largest = np.abs(kx)
    for k in wavenumbers:
        largest = np.maximum(largest, np.abs(k))
    return np.asarray(largest * thickness < THIN)
