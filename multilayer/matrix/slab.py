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
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from math import factorial

import numpy as np
from numpy.polynomial.legendre import leggauss

from multilayer.arrays import BoolArray, ComplexArray, Numeric, RealArray
from multilayer.matrix.faces import (
    TERMS,
    LayerField,
    Origin,
    States,
    choose,
    from_propagator,
    propagator_series,
    run,
    thin_limit,
    wave_states,
    weighted_sums,
    whole,
)
from multilayer.matrix.families import Family
from multilayer.matrix.small import Entries, aligned, common_shape, multiply, stack_entries
from multilayer.matrix.wave import Wave

_ROUNDING = 1e-16
_MOST = 0.5  # where so many points take the series, the other thin ones cost less with them than apart
# of m^2 h^2: over 1/h, 1/h^2 and 1/h^3, of cosh with cosh, of cosh with sinh / m and of sinh / m with itself
_CONVOLUTIONS = np.array(
    [
        [(n + 1) / factorial(2 * n + 1), 0.5 / factorial(2 * n + 1), (n + 1) / factorial(2 * n + 3)]
        for n in range(TERMS + 1)
    ]
).T


@dataclass(frozen=True, eq=False)
class Slab(Origin):
    """A homogeneous slab in a plane harmonic field.

    Its constants are numbers and arrays that broadcast over frequency, angle and samples: what its field equations and
    its waves are made of. These are reciprocal, as those of any medium at rest without memory of a direction.

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

    @cached_property
    def merged(self) -> BoolArray:
        """Where derivatives take the power series: thin, and with waves that are nearly the same along axis 3.

        However thin a layer is, products of waves that differ have good integrals.
        """
        if self.shear is None:
            return self.thin
        merged = np.asarray(self.thin & (np.abs(self.shear) < np.abs(self.wave.kx) ** 2))
        return self.thin if np.mean(merged) > _MOST else merged

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
        """Return derivatives by the entries of X and Y, from series where waves merge, from waves elsewhere."""
        arguments = (self.thickness, *self.constants)
        if np.all(self.merged):
            return self._of_series(field, *arguments)
        if np.any(self.thin & ~self.merged):
            field = self._with_waves(field)
        if not np.any(self.merged):
            return self._of_waves(field, *arguments)
        shape = np.broadcast_shapes(self.merged.shape, *(np.shape(argument) for argument in arguments))
        shape = np.broadcast_shapes(shape, field.adjoint_back.shape[2:])
        gradients: list[ComplexArray] = []
        for make, where in ((self._of_series, self.merged), (self._of_waves, ~self.merged)):
            points = run(np.flatnonzero(whole(where, shape)))
            here = (whole(a, shape).reshape(-1)[points] if np.ndim(a) else a for a in arguments)
            parts = make(field.at(points, shape), *here)
            gradients = gradients or [np.empty((*part.shape[:-1], *shape), dtype=complex) for part in parts]
            for gradient, part in zip(gradients, parts, strict=True):
                gradient.reshape(*part.shape[:-1], -1)[..., points] = part
        return gradients[0], gradients[1]

    def _with_waves(self, field: LayerField) -> LayerField:
        """Return the fields with the amplitudes of waves also where the power series has others."""
        states = stack_entries(self.waves(*self.constants))
        even, odd = list(self.family.even), list(self.family.odd)
        of_even, of_odd = _inverses(self.family, states[even], states[odd])
        onward, back = multiply(of_even, field.front[even]), multiply(of_even, field.back[even])
        onward += multiply(of_odd, field.front[odd])
        back -= multiply(of_odd, field.back[odd])
        waves = np.concatenate([onward, back]) / 2
        return replace(field, amplitudes=np.where(self.thin, waves, field.amplitudes))

    def _of_series(
        self, field: LayerField, thickness: Numeric, *constants: Numeric
    ) -> tuple[ComplexArray, ComplexArray]:
        turn = float(np.max(self.turn, where=self.merged, initial=0.0))
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
    if family.half == 1:
        return _by_series_of_fluid(x[0][0], y[0][0], h, field, family)
    even, odd = list(family.even), list(family.odd)
    nodes, weights = _gauss(_nodes(turn))
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


def _by_series_of_fluid(
    x: Numeric, y: Numeric, h: Numeric, field: LayerField, family: Family
) -> tuple[ComplexArray, ComplexArray]:
    """Return derivatives by X and Y of a single wave both ways, from products whose integrals have series.

    The field is ``cosh(m x)`` and ``sinh(m x) / m`` times its halves at the front, m^2 = X Y, and the adjoint field
    the same of h - x times its halves at the back: what is left are three convolutions of these functions.
    """
    powers = np.multiply.accumulate(np.broadcast_to(x * y * h**2, (TERMS, *common_shape((x, y, h)))))
    alike, mixed, twice = (
        first + later
        for first, later in zip(_CONVOLUTIONS[:, 0], weighted_sums(_CONVOLUTIONS[:, 1:], powers), strict=True)
    )
    (even,), (odd,) = family.even, family.odd
    into_even, into_odd = x * h, y * h

    def integral(a: ComplexArray, turned_a: ComplexArray, b: ComplexArray, turned_b: ComplexArray) -> ComplexArray:
        return np.asarray(-h * (a * (alike * b + mixed * turned_b) + turned_a * (mixed * b + twice * turned_b)))

    (e, o), (a, b) = (field.front[even], field.front[odd]), (field.adjoint_back[even], field.adjoint_back[odd])
    by_x = integral(a, into_odd * b, o, into_odd * e)
    by_y = integral(b, into_even * a, e, into_even * o)
    return by_x[None, None], by_y[None, None]


@lru_cache
def _gauss(n: int) -> tuple[RealArray, RealArray]:
    """Return Gauss's nodes and weights from 0 to 1."""
    nodes, weights = leggauss(n)
    return (1 + nodes) / 2, weights / 2


def _nodes(turn: float) -> int:
    """Return how many nodes integrate a product of two exponentials to rounding, each up to exp(`turn`)."""
    n = 2
    while (2 * turn) ** (2 * n) * factorial(n) ** 4 / ((2 * n + 1) * factorial(2 * n) ** 3) > _ROUNDING:
        n += 1
    return n


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
    inverse_even, inverse_odd = _inverses(family, s_even, s_odd)
    a, b = field.amplitudes[:n, None], field.amplitudes[n:, None]
    a, b, alpha, beta, alike, crossed = aligned(a, b, alpha[None], beta[None], *_integrals(k, h))
    of_both, of_one = (a * beta - b * alpha) * crossed, (a * alpha - b * beta) * alike
    x = multiply(s_odd, multiply(of_both + of_one, inverse_even))
    y = multiply(s_even, multiply(of_both - of_one, inverse_odd))
    return -0.5 * np.swapaxes(x, 0, 1), -0.5 * np.swapaxes(y, 0, 1)


def _inverses(family: Family, even: ComplexArray, odd: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the inverses of both halves of the states of the waves.

    Of two waves the sum of ``velocity stress' - stress velocity'`` over the power pairs, the second mirrored along axis
    1, is the same everywhere (reciprocity), so that it vanishes unless each undoes the phase of the other: one half's
    transpose is the other's inverse, but for a factor of each wave.
    """
    of_even, of_odd = (np.empty_like(half) for half in (even, odd))
    for i, j, sign in family.reciprocal_pairs:
        np.multiply(sign, odd[j], out=of_even[:, i])
        np.multiply(sign, even[i], out=of_odd[:, j])
    factor = 1 / sum(of_even[:, i] * even[i] for i in range(family.half))
    return of_even * factor[:, None], of_odd * factor[:, None]


def _along(states: ComplexArray, adjoint: ComplexArray) -> ComplexArray:
    """Return the products of an adjoint state with the state of each wave."""
    return multiply(np.swapaxes(states, 0, 1), adjoint[:, None])[:, 0]


def _integrals(k: Sequence[Numeric], h: Numeric) -> tuple[ComplexArray, ComplexArray]:
    """Return integrals over the thickness of products of two waves, one row and one column for each wave.

    First of two that decay from the same face, ``exp(-i (k + k') x)``, then of two that decay from opposite faces,
    ``exp(-i k x - i k' (h - x))``.
    """
    phases = [np.asarray(wavenumber * h, dtype=complex) for wavenumber in k]
    lost = [np.expm1(-1j * phase) for phase in phases]
    n, shape = len(phases), common_shape((h, *phases))
    alike, crossed = (np.empty((n, n, *shape), dtype=complex) for _ in range(2))
    for i, p in enumerate(phases):
        crossed[i, i] = h * np.exp(-1j * p)
        for j, q in enumerate(phases[: i + 1]):
            # exp(-i (p + q)) - 1 to the last digit, of the same for each
            alike[i, j] = alike[j, i] = h * _mean(p + q, lost[i] + lost[j] + lost[i] * lost[j])
        for j, q in enumerate(phases[:i]):
            nearer, farther = np.where(p.imag < q.imag, q, p), np.where(p.imag < q.imag, p, q)
            apart = farther - nearer
            crossed[i, j] = crossed[j, i] = h * np.exp(-1j * nearer) * _mean(apart, np.expm1(-1j * apart))
    return alike, crossed


def _mean(phase: ComplexArray, lost: ComplexArray) -> ComplexArray:
    """Return the mean of exp(-i phase t), t from 0 to 1, from ``lost`` = exp(-i phase) - 1."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(phase == 0, 1, 1j * lost / phase)
