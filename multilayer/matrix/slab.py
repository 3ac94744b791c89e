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
from functools import cached_property
from math import factorial

import numpy as np
from numpy.polynomial.legendre import leggauss

from multilayer.arrays import BoolArray, ComplexArray, Numeric, RealArray
from multilayer.matrix.faces import (
    LayerField,
    Origin,
    choose,
    from_propagator,
    from_waves,
    propagator_series,
    thin_limit,
)
from multilayer.matrix.families import Family
from multilayer.matrix.small import Entries, aligned, beside, multiply, solve_small, stack_entries
from multilayer.matrix.wave import Wave

_ROUNDING = 1e-17


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
        return choose(self.thin, self._series, self._waves, (self.thickness, *self.constants))

    def _series(self, thickness: Numeric, *constants: Numeric) -> tuple[ComplexArray, ComplexArray]:
        propagator = propagator_series(self.family, *self.equations(*constants), thickness)
        return from_propagator(self.family, propagator, self.wave.ambient.impedance)

    def _waves(self, thickness: Numeric, *constants: Numeric) -> tuple[ComplexArray, ComplexArray]:
        return from_waves(self.family, self.waves(*constants), constants[-self.family.half :], thickness)

    def gradient(self, field: LayerField) -> tuple[Numeric, ...]:
        """Return derivatives by the thickness and the medium's coefficients."""
        family, n = self.family, self.family.size
        constants = self.constants
        ends = (field.amplitudes, field.front, field.adjoint_front, field.adjoint_back)
        known = 1 + len(constants)

        def series(*arguments: Numeric) -> tuple[ComplexArray, ComplexArray]:
            x, y = self.equations(*arguments[1:known])
            front, adjoint = np.array(arguments[known + n : known + 2 * n]), np.array(arguments[known + 3 * n :])
            return _by_series(family, x, y, arguments[0], front, adjoint, turn)

        def waves(*arguments: Numeric) -> tuple[ComplexArray, ComplexArray]:
            amplitudes, _, *adjoint = (
                np.array(arguments[known + i * n : known + (i + 1) * n]) for i in range(len(ends))
            )
            k = arguments[known - family.half : known]
            return _by_waves(family, self.waves(*arguments[1:known]), k, arguments[0], amplitudes, *adjoint)

        turn = float(np.max(self.turn, where=self.thin, initial=0.0))
        entries = (entry for end in ends for entry in end)
        x, y = choose(self.thin, series, waves, (self.thickness, *constants, *entries))
        return self._by_thickness(field), *self.by_medium(x, y)

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
    family: Family, x: Entries, y: Entries, h: Numeric, front: ComplexArray, adjoint: ComplexArray, turn: float
) -> tuple[ComplexArray, ComplexArray]:
    """Return derivatives by X and Y from power series of both fields, of thin slabs.

    The field is known at the front, the adjoint field at the back; Gauss's nodes integrate their product, whose series
    they hold to rounding.
    """
    even, odd = list(family.even), list(family.odd)
    nodes, weights = leggauss(5 + int(2.5 * turn))
    nodes, weights = (1 + nodes) / 2, weights / 2
    turned = [[entry * h for entry in row] for row in x], [[entry * h for entry in row] for row in y]
    matrix_x, matrix_y = (stack_entries(rows) for rows in turned)
    transposed = np.swapaxes(matrix_y, 0, 1), np.swapaxes(matrix_x, 0, 1)
    terms = _terms(turn)
    fields = _at(nodes, front[even], front[odd], matrix_x, matrix_y, terms)
    adjoints = _at(1 - nodes, adjoint[even], adjoint[odd], *transposed, terms)
    gradients = []
    for left, right in ((adjoints[0], fields[1]), (adjoints[1], fields[0])):
        total = (-weights[0] * left[0])[:, None] * right[0][None]
        for weight, a, b in zip(weights[1:], left[1:], right[1:], strict=True):
            total -= (weight * a)[:, None] * b[None]
        gradients.append(total * h)
    return gradients[0], gradients[1]


def _terms(turn: float) -> int:
    """Return how many terms of the exponential series hold it to rounding up to an argument of the size `turn`."""
    n = 4
    while turn**n / factorial(n) > _ROUNDING:
        n += 1
    return n + 3  # of states whose waves merge the terms are larger, as n turn^n / n!


def _at(
    nodes: RealArray, even: ComplexArray, odd: ComplexArray, to_even: ComplexArray, to_odd: ComplexArray, n: int
) -> list[ComplexArray]:
    """Return both halves of a field at shares of the thickness, from its value at 0, by `n` terms of its series."""
    terms = [(even, odd)]
    for m in range(1, n):
        even, odd = terms[-1]
        terms.append((multiply(to_even, odd[:, None])[:, 0] / m, multiply(to_odd, even[:, None])[:, 0] / m))
    powers = nodes[:, None] ** np.arange(n)
    halves = []
    for which in (0, 1):
        shape = np.broadcast_shapes(*{term[which].shape for term in terms})
        series = np.empty((n, *shape), dtype=complex)
        for place, term in zip(series, terms, strict=True):
            place[...] = term[which]
        # a real matrix times a complex one, which NumPy would take for two complex ones
        flat = powers @ series.reshape(n, -1).view(float)
        halves.append(flat.view(complex).reshape(len(nodes), *shape))
    return halves


def _by_waves(
    family: Family,
    waves: Entries,
    k: Sequence[Numeric],
    h: Numeric,
    amplitudes: ComplexArray,
    adjoint_front: ComplexArray,
    adjoint_back: ComplexArray,
) -> tuple[ComplexArray, ComplexArray]:
    """Return derivatives by X and Y from the waves of both fields, whose products have integrals in closed form.

    The field's waves are ``s exp(-i k x)`` and their mirror images; the adjoint field's amplitude along each is known
    at the face that it decays from.
    """
    n, (even, odd) = family.half, (list(family.even), list(family.odd))
    states = stack_entries(waves)
    s_even, s_odd = states[even], states[odd]
    # of the adjoint field: amplitudes that decay from the front face, and from the back face
    alpha = _along(s_odd, adjoint_front[odd]) - _along(s_even, adjoint_front[even])
    beta = _along(s_odd, adjoint_back[odd]) + _along(s_even, adjoint_back[even])
    a, b = amplitudes[:n, None], amplitudes[n:, None]
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
