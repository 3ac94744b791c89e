"""Face matrices: how the states at a layer's two faces depend on the layer's coefficients.

    V(front) = A c        V(back) = B c

The first half of ``c`` are waves (or wave-like amplitudes) going towards +x3, the second half towards -x3. Two ways to
make them:

- `wave_states`: plane waves, each exponential referred to the face it decays from, so that nothing overflows;
- `from_propagator`: the propagator of the field equations by its power series (`propagator_series`), for layers thin
  beside the wavelengths, where waves would cancel each other to the last digits.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from dataclasses import fields as dataclass_fields
from functools import cached_property, lru_cache
from math import factorial
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from multilayer.arrays import BoolArray, ComplexArray, IndexArray, Numeric, RealArray
from multilayer.matrix.families import FLUID, Family
from multilayer.matrix.small import Entries, aligned, common_shape, multiply, stack_entries
from multilayer.matrix.wave import Wave

THIN = 2.0  # largest |k| h of the power series
_APART = 0.3
TERMS = 12  # the first term left out is below THIN^26 / 27! = 6e-21
_SERIES = np.array([[1 / factorial(2 * n + k) for n in range(TERMS + 1)] for k in (2, 1)])


@dataclass(frozen=True)
class LayerField:
    """The field in a layer, and the adjoint field of some outcomes of the stack; see `matrix.adjoint`.

    Arrays of shape (n, 1, ...), those of the adjoint field (n, n_outcomes, ...). A change of the face matrices changes
    the outcomes by ``-(adjoint_front^T dA + adjoint_back^T dB) amplitudes``.

    Attributes
    ----------
    amplitudes : complex array
        The layer's coefficients c.
    front, back : complex array
        The states V = A c and V = B c at its faces.
    adjoint_front, adjoint_back : complex array
    """

    amplitudes: ComplexArray
    front: ComplexArray
    back: ComplexArray
    adjoint_front: ComplexArray
    adjoint_back: ComplexArray

    def at(self, points: IndexArray | slice, shape: tuple[int, ...]) -> LayerField:
        """Return the fields at some points of the trailing axes, of a shape in all, in one axis."""
        arrays = (getattr(self, item.name) for item in dataclass_fields(self))
        return LayerField(*(whole(a, a.shape[:2] + shape).reshape(*a.shape[:2], -1)[..., points] for a in arrays))


class Origin(ABC):
    """What face matrices are computed from: a few coefficients of a medium, by which responses have derivatives."""

    family: ClassVar[Family]

    @property
    @abstractmethod
    def coefficients(self) -> tuple[Numeric, ...]:
        """Numbers and arrays that hold all that the matrices depend on beside the wave."""

    @abstractmethod
    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices (A, B)."""

    def states(self) -> States:
        """Return the face matrices with what waves lose from face to face apart."""
        return States(*self.matrices())

    @abstractmethod
    def gradient(self, field: LayerField) -> tuple[Numeric, ...]:
        """Return the complex derivatives of the outcomes, shape (n_outcomes, ...), by each of the coefficients."""


@dataclass(frozen=True)
class States:
    """Face matrices with what waves lose from face to face apart: ``A = front diag(1, d)``, ``B = back diag(d, 1)``.

    Waves of a homogeneous medium have the same states at both faces, which do not depend on the thickness: of many
    thicknesses they are computed, and eliminated, once.

    Attributes
    ----------
    front, back : complex array, shape (n_state, n_coefficients, ...)
    decay : complex array, shape (n_coefficients/2, 1, ...), or None
        The factors d of the waves, the same in both directions; None for 1.
    """

    front: ComplexArray
    back: ComplexArray
    decay: ComplexArray | None = None

    @property
    def ndim(self) -> int:
        """The most axes of any of the arrays."""
        return max(array.ndim for array in (self.front, self.back, self.decay) if array is not None)

    def aligned(self, ndim: int) -> States:
        """Return them with so many axes."""
        (front,), (back,) = aligned(self.front, ndim=ndim), aligned(self.back, ndim=ndim)
        return States(front, back, None if self.decay is None else aligned(self.decay, ndim=ndim)[0])

    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices (A, B)."""
        if self.decay is None:
            return self.front, self.back
        front, back, decay = aligned(self.front, self.back, self.decay)
        half, shape = len(decay), np.broadcast_shapes(front.shape[2:], back.shape[2:], decay.shape[2:])
        a, b = (np.empty((*front.shape[:2], *shape), dtype=complex) for _ in range(2))
        d = np.swapaxes(decay, 0, 1)
        a[:, :half], b[:, half:] = front[:, :half], back[:, half:]
        np.multiply(front[:, half:], d, out=a[:, half:])
        np.multiply(back[:, :half], d, out=b[:, :half])
        return a, b

    def at_front(self, coefficients: ComplexArray) -> ComplexArray:
        """Return the states A c at the front, of columns of coefficients, shape (n_coefficients, n, ...)."""
        return multiply(self.front, self._lessened(coefficients, slice(len(coefficients) // 2, None)))

    def at_back(self, coefficients: ComplexArray) -> ComplexArray:
        """Return the states B c at the back, of columns of coefficients, shape (n_coefficients, n, ...)."""
        return multiply(self.back, self._lessened(coefficients, slice(len(coefficients) // 2)))

    def _lessened(self, coefficients: ComplexArray, which: slice) -> ComplexArray:
        if self.decay is None:
            return coefficients
        coefficients, decay = aligned(coefficients, self.decay)
        shape = np.broadcast_shapes(coefficients.shape[2:], decay.shape[2:])
        lessened = np.array(np.broadcast_to(coefficients, (*coefficients.shape[:2], *shape)))
        lessened[which] *= decay
        return lessened

    def before(self, answer: ComplexArray) -> ComplexArray:
        """Return what comes back to the front of waves that the back answers so, both where they have not decayed."""
        return answer if self.decay is None else self.decay * answer

    def behind(self, of_back: ComplexArray) -> ComplexArray:
        """Return what follows from waves at the front, a column for each, from what follows from those at the back."""
        return of_back if self.decay is None else of_back * np.swapaxes(self.decay, 0, 1)


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

    @property
    def origin(self) -> Origin | None:
        """What the matrices are computed from, where that is known."""
        return None

    @property
    def states(self) -> States:
        """The matrices with what waves lose from face to face apart, where that is known."""
        return States(self.front, self.back)

    @property
    def computed(self) -> Faces:
        """The same, its matrices computed now: errors in their formulae are raised here."""
        return self


class FacesOfStates(Faces):
    """Face matrices that are multiplied out when they are asked for."""

    def __init__(self, family: Family, states: States, porosity: Numeric = 1.0) -> None:
        self.__dict__.update(family=family, porosity=porosity, _states=states)

    @property
    def states(self) -> States:
        """The matrices with what waves lose from face to face apart."""
        states: States = self.__dict__["_states"]
        return states

    @cached_property
    def _matrices(self) -> tuple[ComplexArray, ComplexArray]:
        return self.states.matrices()

    @property
    def front(self) -> ComplexArray:
        """The matrix A."""
        return self._matrices[0]

    @property
    def back(self) -> ComplexArray:
        """The matrix B."""
        return self._matrices[1]


class FacesOf(FacesOfStates):
    """Face matrices that are computed from coefficients of a medium, when they are asked for."""

    def __init__(self, origin: Origin, porosity: Numeric = 1.0) -> None:
        self.__dict__.update(family=origin.family, porosity=porosity, _origin=origin)

    @property
    def origin(self) -> Origin:
        """What the matrices are computed from."""
        origin: Origin = self.__dict__["_origin"]
        return origin

    @property
    def computed(self) -> Faces:
        """The same, its matrices computed now."""
        assert self.states
        return self

    @property
    def states(self) -> States:
        """The matrices with what waves lose from face to face apart."""
        if "_states" not in self.__dict__:
            self.__dict__["_states"] = self.origin.states()
        return super().states


def mirrored(faces: Faces) -> Faces:
    """Return the face matrices of a layer that is turned round along axis 3: its back is where its front was."""

    def turned(matrix: ComplexArray) -> ComplexArray:
        half = faces.family.half
        waves = np.concatenate([matrix[:, half:], matrix[:, :half]], axis=1)  # what went back goes on
        waves[list(faces.family.odd)] *= -1
        return waves

    states = faces.states
    return FacesOfStates(faces.family, States(turned(states.back), turned(states.front), states.decay), faces.porosity)


def wave_states(
    family: Family, forward: Entries, wavenumbers: Sequence[Numeric], thickness: Numeric
) -> tuple[ComplexArray, ComplexArray]:
    """Return the states of unit waves both ways in a medium that is its own mirror image along axis 3, and their decay.

    Those of `States`: the states serve both faces.

    Parameters
    ----------
    family : Family
        The mirror keeps the even half of its state and turns the odd half round.
    forward : entries, shape (n_state, n_waves)
        States of the waves exp(-i k x3) where their exponential is 1.
    wavenumbers : sequence
        k along x3 of each wave, Im(k) <= 0.
    thickness : float or array
    """
    shape = common_shape(entry for row in forward for entry in row)
    half = family.half
    states = np.empty((family.size, family.size, *shape), dtype=complex)
    for i, row in enumerate(forward):
        for j, entry in enumerate(row):
            states[i, j] = entry
        if i in family.even:
            states[i, half:] = states[i, :half]
        else:  # as real numbers, whose signs NumPy turns faster
            np.negative(states[i, :half].view(float), out=states[i, half:].view(float))
    decay = np.empty((half, 1, *common_shape((thickness, *wavenumbers))), dtype=complex)
    for j, k in enumerate(wavenumbers):
        decay[j, 0] = -1j * thickness * k
    np.exp(decay, out=decay)
    return states, decay


@lru_cache
def amplitudes(family: Family, impedance: float) -> ComplexArray:
    """Return the constant matrix W that makes a state from wave-like amplitudes.

    Each power pair becomes ``v = c+ + c-``, ``sign * stress = impedance * (c+ - c-)``. A passive termination returns a
    c- of no more power than c+, whatever the impedance: the basis adds no resonances.
    """
    w = np.zeros((family.size, family.size), dtype=complex)
    for wave, (velocity, stress, sign) in enumerate(family.power_pairs):
        w[velocity, wave] = w[velocity, wave + family.half] = 1
        w[stress, wave] = sign * impedance
        w[stress, wave + family.half] = -sign * impedance
    w.flags.writeable = False  # it is kept
    return w


def from_propagator(family: Family, propagator: ComplexArray, impedance: float) -> tuple[ComplexArray, ComplexArray]:
    """Return (A, B) from the matrix P that carries the front state to the back, V(back) = P V(front).

    ``P = T^-1`` with the transfer matrix T of Allard & Atalla. `impedance` (Pa s/m) scales the amplitudes and should
    be that of the surroundings.
    """
    w, b = amplitudes(family, impedance), np.empty_like(propagator)
    for wave, (velocity, stress, sign) in enumerate(family.power_pairs):
        of_velocity, of_stress = propagator[:, velocity], (sign * impedance) * propagator[:, stress]
        b[:, wave] = of_velocity + of_stress
        b[:, wave + family.half] = of_velocity - of_stress
    return np.broadcast_to(w.reshape(w.shape + (1,) * (b.ndim - 2)), b.shape), b


@dataclass(frozen=True, eq=False)
class Sheet(Origin):
    """A sheet in a fluid that moves as one: p(front) - p(back) = impedance v3.

    Attributes
    ----------
    impedance : complex or array
        Pa s/m.
    reference : float
        Impedance of the surroundings, Pa s/m.
    """

    family: ClassVar[Family] = FLUID

    impedance: Numeric
    reference: float

    @property
    def coefficients(self) -> tuple[Numeric, ...]:
        """The impedance."""
        return (self.impedance,)

    def matrices(self) -> tuple[ComplexArray, ComplexArray]:
        """Return the face matrices."""
        return from_series_impedance(self.impedance, self.reference)

    def gradient(self, field: LayerField) -> tuple[Numeric, ...]:
        """Return the derivative by the impedance: the pressure behind loses it times the velocity."""
        return (field.adjoint_back[0] * field.front[1],)


def sheet_faces(wave: Wave, impedance: Numeric) -> Faces:
    """Return the face matrices of a sheet by its impedance, Pa s/m; see `from_series_impedance`."""
    return FacesOf(Sheet(impedance, wave.ambient.impedance))


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

    Power series of cosh and sinh of a half-size matrix; exact to rounding for abs(k) h up to `THIN`, entry by entry:
    unlike a sum of waves it keeps the small bending terms of thin stiff layers.
    """
    h = np.asarray(thickness, dtype=complex)
    X, Y = aligned(stack_entries(x), stack_entries(y), ndim=h.ndim + 2)
    square = multiply(X, Y) * h**2
    versine, sinc = _entire_functions(square)
    eye = np.eye(len(square), dtype=complex).reshape(square.shape[:2] + (1,) * (square.ndim - 2))
    at = family.blocks
    p = np.empty((family.size, family.size, *square.shape[2:]), dtype=complex)
    # f(YX) = ... follows from f(XY) by Y g(XY) X
    p[at["even_even"]] = eye + multiply(square, versine)
    p[at["odd_odd"]] = eye + multiply(Y, multiply(versine, X)) * h**2
    p[at["even_odd"]] = multiply(sinc, X) * h
    p[at["odd_even"]] = multiply(Y, sinc) * h
    return p


def _entire_functions(square: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return sum(M^n / (2n + 2)!) and sum(M^n / (2n + 1)!), that is (cosh(m) - 1) / m^2 and sinh(m) / m of m^2 = M."""
    match len(square):
        case 1:
            powers = np.multiply.accumulate(np.broadcast_to(square, (TERMS, *square.shape)))
            sums = weighted_sums(_SERIES[:, 1:], powers)
        case 2:
            sums = _entire_functions_of_two(square)
        case _:
            sums = _entire_functions_of_many(square)
    eye = np.eye(len(square)).reshape(square.shape[:2] + (1,) * (square.ndim - 2))
    return sums[0] + _SERIES[0, 0] * eye, sums[1] + _SERIES[1, 0] * eye


def _entire_functions_of_two(square: ComplexArray) -> ComplexArray:
    """Return both series from n = 1 on, by ``M^n = p_n M - det p_(n-1)`` (Cayley and Hamilton)."""
    trace = square[0, 0] + square[1, 1]
    minus_det = square[0, 1] * square[1, 0] - square[0, 0] * square[1, 1]
    p = np.empty((TERMS + 1, *trace.shape), dtype=complex)
    p[0], p[1] = 0, 1
    for n in range(2, TERMS + 1):
        p[n] = trace * p[n - 1] + minus_det * p[n - 2]
    sums = weighted_sums(_SERIES[:, 1:], p[1:])[:, None, None] * square
    of_eye = minus_det * weighted_sums(_SERIES[:, 1:], p[:-1])
    for i in range(2):
        sums[:, i, i] += of_eye
    return sums


def _entire_functions_of_many(square: ComplexArray) -> ComplexArray:
    """Return both series from n = 1 on, in pieces of four powers.

    M. S. Paterson & L. J. Stockmeyer, SIAM J. Comput. 2 (1973) 60-66: seven products of matrices for both.
    """
    second = multiply(square, square)
    powers = np.array([square, second, multiply(second, square), multiply(second, second)])
    eye = np.eye(len(square)).reshape(square.shape[:2] + (1,) * (square.ndim - 2))
    sums = weighted_sums(_SERIES[:, 9:], powers)
    for n in (4, 0):
        sums += _SERIES[:, n + 4].reshape(-1, *(1,) * square.ndim) * eye
        sums = np.einsum("ij...,njk...->nik...", powers[3], sums)
        sums += weighted_sums(_SERIES[:, n + 1 : n + 4], powers[:3])
    return sums


def weighted_sums(weights: RealArray, terms: ComplexArray) -> ComplexArray:
    """Return sums of terms, each with real weights, shape (n_sums, ...); no BLAS, whose rounding depends on shapes."""
    flat = np.ascontiguousarray(terms).reshape(len(terms), -1).view(float)
    sums: RealArray = np.einsum("kn,nm->km", weights, flat)
    return sums.view(complex).reshape(len(weights), *terms.shape[1:])


def choose(
    thin: BoolArray,
    series: Callable[..., tuple[ComplexArray, ...]],
    waves: Callable[..., tuple[ComplexArray, ...]],
    arguments: Sequence[Numeric],
) -> tuple[ComplexArray, ...]:
    """Return the matrices of `series` where `thin`, of `waves` elsewhere, each computed where it is needed only.

    Parameters
    ----------
    thin : bool array
    series, waves : callable
        Make entry-first matrices from `arguments`, both equally many of the same sizes.
    arguments : sequence
        Numbers and arrays that broadcast against `thin`.
    """
    if np.all(thin):
        return series(*arguments)
    if not np.any(thin):
        return waves(*arguments)
    shape = common_shape((thin, *arguments))
    matrices: list[ComplexArray] = []
    for make, where in ((series, thin), (waves, ~thin)):
        points = run(np.flatnonzero(whole(where, shape)))
        parts = make(*(whole(a, shape).reshape(-1)[points] if np.ndim(a) else a for a in arguments))
        matrices = matrices or [np.empty((*part.shape[:2], *shape), dtype=complex) for part in parts]
        for matrix, part in zip(matrices, parts, strict=True):
            matrix.reshape(*matrix.shape[:2], -1)[..., points] = part
    return tuple(matrices)


def run(points: IndexArray) -> IndexArray | slice:
    """Return consecutive indices, as those of the lowest frequencies, as a slice, which copies nothing."""
    first, last = points[0], points[-1]
    return slice(first, last + 1) if last - first + 1 == len(points) else points


def whole(values: Numeric, shape: tuple[int, ...]) -> NDArray[Any]:
    """Return an array of the shape; NumPy takes long to find that it has it already."""
    array = np.asarray(values)
    return array if array.shape == shape else np.broadcast_to(array, shape)


def thin_limit(kx: Numeric, shear: Numeric | None = None) -> Numeric:
    """Return the abs(k) h below which the power series is the better basis.

    Parameters
    ----------
    kx : array
    shear : complex, optional
        Squared wavenumber of the shear wave. Where it is below 2 kx^2, in a layer stiffer than its surroundings,
        compression and shear waves grow alike and cancel each other in thin layers: the series serves up to `THIN`
        there. Elsewhere waves are good down to `_APART`.
    """
    return THIN if shear is None else np.where(np.abs(shear) < 2 * np.abs(kx) ** 2, THIN, _APART)
