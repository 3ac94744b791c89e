"""Homogeneous slabs that are their own mirror image along axis 3, and how a response depends on their media.

A medium gives its field equations ``d(even)/dx3 = X odd, d(odd)/dx3 = Y even`` and its waves; face matrices follow, and
the derivative of any linear functional of the field by X, Y and the thickness. With the field V and the adjoint field
mu, ``d(mu)/dx3 = -M^T mu``, a change of the matrix M of the field equations changes the functional by

    do = -int_0^h mu^T dM V dx3,

exactly: no exponential is differentiated, and none grows.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import factorial

import numpy as np
from numpy.polynomial.legendre import leggauss

from multilayer.arrays import BoolArray, ComplexArray, Numeric, RealArray
from multilayer.matrix.faces import (
    LayerField,
    Origin,
    States,
    choose,
    from_propagator,
    propagator_series,
    thin_limit,
    wave_states,
)
from multilayer.matrix.families import Family
from multilayer.matrix.small import Entries, aligned, beside, multiply, solve_small, stack_entries
from multilayer.matrix.wave import Wave

_ROUNDING = 1e-16


@dataclass(frozen=True, eq=False)
class Slab(Origin):
    """A homogeneous slab in a plane harmonic field.

    Its constants are numbers and arrays that broadcast over frequency, angle and samples: what its field equations and
    its waves are made of.

    Attributes
    ----------
    wave : Wave
    thickness : float or array
        m.
    """

    wave: Wave
    thickness: Numeric

    @cached_property
    @abstractmethod
    def constants(self) -> tuple[Numeric, ...]:
        """What `equations` and `waves` take; the wavenumbers along axis 3 are the last."""

    @staticmethod
    @abstractmethod
    def equations(*constants: Numeric) -> tuple[Entries, Entries]:
        """Return X and Y."""

    @staticmethod
    @abstractmethod
    def waves(*constants: Numeric) -> Entries:
        """Return the states of the waves exp(-i k x3), one in a column, shape (n_state, n_state/2)."""

    @abstractmethod
    def by_medium(self, x: ComplexArray, y: ComplexArray) -> tuple[Numeric, ...]:
        """Return derivatives by the `coefficients` behind the thickness from those by the entries of X and Y."""

    @property
    def trace(self) -> Numeric:
        """Wavenumber along the layer, rad/m, that the power series must resolve beside those of the waves."""
        return self.wave.kx

    @property
    def shear(self) -> Numeric | None:
        """Squared wavenumber of the shear wave, if there is one."""
        return None

    @cached_property
    def turn(self) -> RealArray:
        """The largest |k| h."""
        largest = np.abs(self.trace)
        for k in self.constants[-self.family.half :]:
            largest = np.maximum(largest, np.abs(k))
        return np.asarray(largest * self.thickness)

    @cached_property
    def thin(self) -> BoolArray:
        """Where the power series is the better basis."""
        return np.asarray(self.turn < thin_limit(self.wave.kx, self.shear))

    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices (A, B)."""
        return self.states().matrices()

    def states(self) -> States:
        """Return the face matrices with what waves lose apart: nothing where the slab is thin."""
        arguments = (self.thickness, *self.constants)
        if np.all(self.thin):
            return States(*self._series(*arguments))
        return States(*choose(self.thin, self._series_beside_waves, self._waves, arguments))

    def _series(self, thickness: Numeric, *constants: Numeric) -> tuple[ComplexArray, ComplexArray]:
        propagator = propagator_series(self.family, *self.equations(*constants), thickness)
        return from_propagator(self.family, propagator, self.wave.ambient.impedance)

    def _series_beside_waves(self, *arguments: Numeric) -> tuple[ComplexArray, ...]:
        front, back = self._series(*arguments)
        return front, back, np.ones((self.family.half, 1, *back.shape[2:]), dtype=complex)

    def _waves(self, thickness: Numeric, *constants: Numeric) -> tuple[ComplexArray, ...]:
        wavenumbers = constants[-self.family.half :]
        states, decay = wave_states(self.family, self.waves(*constants), wavenumbers, thickness)
        return states, states, decay

    def gradient(self, field: LayerField) -> tuple[Numeric, ...]:
        """Return derivatives by the thickness and the medium's coefficients."""
        x, y = self._by_equations(field)
        return self._by_thickness(field), *self.by_medium(x, y)

    def _by_equations(self, field: LayerField) -> tuple[ComplexArray, ComplexArray]:
        """Return derivatives by the entries of X and Y, from series where the slab is thin, from waves elsewhere."""
        arguments = (self.thickness, *self.constants)
        if np.all(self.thin):
            return self._of_series(field, *arguments)
        if not np.any(self.thin):
            return self._of_waves(field, *arguments)
        shape = np.broadcast_shapes(self.thin.shape, *(np.shape(argument) for argument in arguments))
        shape = np.broadcast_shapes(shape, field.adjoint_back.shape[2:])
        gradients: list[ComplexArray] = []
        for make, where in ((self._of_series, self.thin), (self._of_waves, ~self.thin)):
            mask = np.broadcast_to(where, shape)
            parts = make(field.at(mask), *(np.broadcast_to(a, shape)[mask] if np.ndim(a) else a for a in arguments))
            gradients = gradients or [np.empty((*part.shape[:-1], *shape), dtype=complex) for part in parts]
            for gradient, part in zip(gradients, parts, strict=True):
                gradient[..., mask] = part
        return gradients[0], gradients[1]

    def _of_series(
        self, field: LayerField, thickness: Numeric, *constants: Numeric
    ) -> tuple[ComplexArray, ComplexArray]:
        turn = float(np.max(self.turn, where=self.thin, initial=0.0))
        return _by_series(self.family, *self.equations(*constants), thickness, field, turn)

    def _of_waves(
        self, field: LayerField, thickness: Numeric, *constants: Numeric
    ) -> tuple[ComplexArray, ComplexArray]:
        return _by_waves(self.family, self.waves(*constants), constants[-self.family.half :], thickness, field)

    def _by_thickness(self, field: LayerField) -> ComplexArray:
        """Return the derivative by the thickness: the back face moves through the field."""
        x, y = self.equations(*self.constants)
        even, odd = list(self.family.even), list(self.family.odd)
        total: Numeric = 0.0
        for matrix, rows, columns in ((x, even, odd), (y, odd, even)):
            for entries, row in zip(matrix, rows, strict=True):
                for entry, column in zip(entries, columns, strict=True):
                    total = total - field.adjoint_back[row] * (entry * field.back[column])
        return np.asarray(total)


def _by_series(
    family: Family, x: Entries, y: Entries, h: Numeric, field: LayerField, turn: float
) -> tuple[ComplexArray, ComplexArray]:
    """Return derivatives by X and Y from power series of both fields, of thin slabs.

    The field is known at the front, the adjoint field at the back; Gauss's nodes integrate their product, whose series
    they hold to rounding.
    """
    even, odd = list(family.even), list(family.odd)
    nodes, weights = _gauss(5 + int(2.5 * turn))
    turned = ([[entry * h for entry in row] for row in matrix] for matrix in (x, y))
    matrix_x, matrix_y = (stack_entries(rows) for rows in turned)
    powers = _powers(turn)
    front, adjoint = field.front, field.adjoint_back
    fields = _at(nodes[:, None] ** powers, front[even], front[odd], matrix_x, matrix_y)
    transposed = np.swapaxes(matrix_y, 0, 1), np.swapaxes(matrix_x, 0, 1)
    weighed = -weights[:, None] * (1 - nodes[:, None]) ** powers
    adjoints = _at(weighed, adjoint[even], adjoint[odd], *transposed)
    gradients = []
    for left, right in ((adjoints[0], fields[1]), (adjoints[1], fields[0])):
        total = left[0][:, None] * right[0]
        for a, b in zip(left[1:], right[1:], strict=True):
            total += a[:, None] * b
        gradients.append(total * h)
    return gradients[0], gradients[1]


@lru_cache
def _gauss(n: int) -> tuple[RealArray, RealArray]:
    """Return Gauss's nodes and weights from 0 to 1."""
    nodes, weights = leggauss(n)
    return (1 + nodes) / 2, weights / 2


def _powers(turn: float) -> RealArray:
    """Return the exponents of a series that holds exp(x) to rounding up to abs(x) = `turn`."""
    n = 4
    while turn**n / factorial(n) > _ROUNDING:
        n += 1
    return np.arange(n + 2.0)  # of states whose waves merge the terms are larger, as n turn^n / n!


def _at(
    powers: RealArray, even: ComplexArray, odd: ComplexArray, to_even: ComplexArray, to_odd: ComplexArray
) -> ComplexArray:
    """Return both halves of a field at some nodes, shape (2, n_nodes, n_state/2, ...), from its value at 0.

    Parameters
    ----------
    powers : array, shape (n_nodes, n_terms)
        Of the nodes, from 0 on.
    even, odd : complex array
        The halves at 0.
    to_even, to_odd : complex array
        Thickness times the matrices of the field equations.
    """
    n_nodes, n = powers.shape
    to_even, to_odd = aligned(to_even, to_odd, ndim=even.ndim + 1)
    shape = np.broadcast_shapes(even.shape[1:], to_even.shape[2:], to_odd.shape[2:])
    terms = np.empty((2, n, len(even), *shape), dtype=complex)
    terms[0, 0], terms[1, 0] = even, odd
    for m in range(1, n):
        for half, matrix in enumerate((to_even, to_odd)):
            source, term = terms[1 - half, m - 1], terms[half, m]
            np.multiply(matrix[:, 0], source[0], out=term)
            for k in range(1, len(source)):
                term += matrix[:, k] * source[k]
    scaled = powers / np.array([factorial(m) for m in range(n)], dtype=float)
    # a real matrix times a complex one, which NumPy would take for two complex ones
    flat = scaled @ terms.reshape(2, n, -1).view(float)
    return np.asarray(flat.view(complex).reshape(2, n_nodes, len(even), *shape))


def _by_waves(
    family: Family, waves: Entries, k: Sequence[Numeric], h: Numeric, field: LayerField
) -> tuple[ComplexArray, ComplexArray]:
    """Return derivatives by X and Y from the waves of both fields, whose products have integrals in closed form.

    The field's waves are ``s exp(-i k x)`` and their mirror images; the adjoint field's amplitude along each is known
    at the face that it decays from.
    """
    n, (even, odd) = family.half, (list(family.even), list(family.odd))
    states = stack_entries(waves)
    s_even, s_odd = states[even], states[odd]
    # of the adjoint field: amplitudes that decay from the front face, and from the back face
    alpha = _along(s_odd, field.adjoint_front[odd]) - _along(s_even, field.adjoint_front[even])
    beta = _along(s_odd, field.adjoint_back[odd]) + _along(s_even, field.adjoint_back[even])
    a, b = field.amplitudes[:n, None], field.amplitudes[n:, None]
    a, b, alpha, beta, alike, crossed = aligned(a, b, alpha[None], beta[None], *_integrals(k, h))
    of_both, of_one = (a * beta - b * alpha) * crossed, (a * alpha - b * beta) * alike
    x = multiply(s_odd, multiply(of_both + of_one, _inverse(s_even)))
    y = multiply(s_even, multiply(of_both - of_one, _inverse(s_odd)))
    return -0.5 * np.swapaxes(x, 0, 1), -0.5 * np.swapaxes(y, 0, 1)


def _along(states: ComplexArray, adjoint: ComplexArray) -> ComplexArray:
    """Return the products of an adjoint state with the state of each wave."""
    return multiply(np.swapaxes(states, 0, 1), adjoint[:, None])[:, 0]


def _inverse(matrix: ComplexArray) -> ComplexArray:
    eye = np.eye(len(matrix)).reshape(matrix.shape[:2] + (1,) * (matrix.ndim - 2))
    return solve_small(beside(-eye.astype(complex), matrix))


def _integrals(k: Sequence[Numeric], h: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return integrals over the thickness of products of two waves, one row and one column for each wave.

    First of two that decay from the same face, ``exp(-i (k + k') x)``, then of two that decay from opposite faces,
    ``exp(-i k x - i k' (h - x))``.
    """
    phases = [np.asarray(wavenumber * h, dtype=complex) for wavenumber in k]
    alike: list[list[Numeric]] = [[h * _mean(p + q) for q in phases] for p in phases]
    crossed: list[list[Numeric]] = [[h * np.exp(-1j * p) for _ in phases] for p in phases]
    for i, p in enumerate(phases):
        for j, q in enumerate(phases[:i]):
            nearer, farther = np.where(p.imag < q.imag, q, p), np.where(p.imag < q.imag, p, q)
            crossed[i][j] = crossed[j][i] = h * np.exp(-1j * nearer) * _mean(farther - nearer)
    return stack_entries(alike), stack_entries(crossed)


def _mean(phase: ComplexArray) -> ComplexArray:
    """Return the mean of exp(-i phase t), t from 0 to 1: (1 - exp(-i phase)) / (i phase)."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(phase == 0, 1, -np.expm1(-1j * phase) / (1j * phase))
