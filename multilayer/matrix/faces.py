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
THIN = 2.0  # largest |k| h of the power series
_TERMS = 12  # the first term left out is below THIN^26 / 27! = 6e-21


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


def aligned(*matrices: ComplexArray, ndim: int = 0) -> list[ComplexArray]:
    """Return entry-first matrices with equally many axes, so that their trailing ones broadcast."""
    ndim = max(ndim, *(matrix.ndim for matrix in matrices))
    return [matrix.reshape(matrix.shape[:2] + (1,) * (ndim - matrix.ndim) + matrix.shape[2:]) for matrix in matrices]


def multiply(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return the matrix product of entry-first matrices, broadcasting their trailing axes."""
    result: ComplexArray = np.einsum("ij...,jk...->ik...", *aligned(a, b))
    return result


def beside(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    """Return [a b], the columns of two entry-first matrices with equally many rows."""
    a, b = aligned(a, b)
    shape = np.broadcast_shapes(a.shape[2:], b.shape[2:])
    return np.concatenate([np.broadcast_to(m, m.shape[:2] + shape) for m in (a, b)], axis=1)


def from_waves(
    forward: Entries, backward: Entries, wavenumbers: Sequence[Numeric], thickness: Numeric
) -> tuple[ComplexArray, ComplexArray]:
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
    ahead, back, decay = aligned(ahead, back, decay)
    return beside(ahead, back * decay), beside(ahead * decay, back)


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


def from_propagator(family: Family, propagator: ComplexArray, impedance: float) -> tuple[ComplexArray, ComplexArray]:
    """Return (A, B) from the matrix P that carries the front state to the back, V(back) = P V(front).

    ``P = T^-1`` with the transfer matrix T of Allard & Atalla. `impedance` (Pa s/m) scales the amplitudes and should
    be that of the surroundings.
    """
    w = amplitudes(family, impedance)
    b = multiply(propagator, w)
    return np.broadcast_to(w.reshape(w.shape + (1,) * (b.ndim - 2)), b.shape), b


def from_series_impedance(impedance: Numeric, reference: float) -> tuple[ComplexArray, ComplexArray]:
    """Return (A, B) of a sheet in a fluid that moves as one: p(front) - p(back) = impedance v3.

    The coefficients are twice the pressures of the waves that arrive at the front and at the back from a medium of
    the impedance `reference`, Pa s/m. Exact for any impedance with Re >= 0, none to infinite, where the propagator
    ``[[1, -impedance], [0, 1]]`` loses the fluid beside a stiff sheet.
    """
    total = np.asarray(2 * reference + np.asarray(impedance, dtype=complex))
    through = 2 * reference / total
    bounced, moved = 1 + impedance / total, through / reference
    front = stack_entries([[bounced, through], [moved, -moved]])
    back = stack_entries([[through, bounced], [moved, -moved]])
    return front, back


def propagator_series(family: Family, x: Entries, y: Entries, thickness: Numeric) -> ComplexArray:
    """Return exp(M h) for the field equations d(even)/dx3 = X odd, d(odd)/dx3 = Y even.

    Power series of cosh and sinh of a half-size matrix; exact to rounding for |k| h up to `THIN`, entry by entry:
    unlike a sum of waves it keeps the small bending terms of thin stiff layers.
    """
    X, Y = aligned(stack_entries(x), stack_entries(y))
    h = np.asarray(thickness, dtype=complex)
    XY = multiply(X, Y)
    square = stack_entries([[entry * h**2 for entry in row] for row in XY])
    versine, sinc = _entire_functions(square)
    eye = np.eye(len(square), dtype=complex).reshape(square.shape[:2] + (1,) * (square.ndim - 2))
    even, odd = family.even, family.odd
    p = np.empty((family.size, family.size, *square.shape[2:]), dtype=complex)
    # f(YX) = ... follows from f(XY) by Y g(XY) X
    p[np.ix_(even, even)] = eye + multiply(square, versine)
    p[np.ix_(odd, odd)] = eye + multiply(Y, multiply(versine, X)) * h**2
    p[np.ix_(even, odd)] = multiply(sinc, X) * h
    p[np.ix_(odd, even)] = multiply(Y, sinc) * h
    return p


def _entire_functions(square: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return sum(M^n / (2n + 2)!) and sum(M^n / (2n + 1)!), that is (cosh(m) - 1) / m^2 and sinh(m) / m of m^2 = M."""
    eye = np.eye(len(square), dtype=complex).reshape((1, *square.shape[:2]) + (1,) * (square.ndim - 2))
    sums = np.broadcast_to(eye, (2, *square.shape))
    for n in range(_TERMS, 0, -1):  # Horner's rule on both at once
        step = np.array([(2 * n + 1) * (2 * n + 2), 2 * n * (2 * n + 1)]).reshape(2, *(1,) * square.ndim)
        sums = eye + np.einsum("ij...,njk...->nik...", square, sums) / step
    return sums[0] / 2, sums[1]


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
    front, back = (np.where(thin, *aligned(x, y, ndim=thin.ndim + 2)) for x, y in ((a, c), (b, d)))
    return front, back


def is_thin(wavenumbers: Sequence[Numeric], kx: RealArray, thickness: Numeric) -> BoolArray:
    """Tell where a layer is thin beside every wavelength in it, along x3 and along x1."""
    largest = np.abs(kx)
    for k in wavenumbers:
        largest = np.maximum(largest, np.abs(k))
    return np.asarray(largest * thickness < THIN)
