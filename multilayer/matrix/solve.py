"""The global system of a stack, eliminated layer by layer.

Unknowns are the coefficients ``c_i`` of every layer (and the amplitudes of the waves that leave through half-spaces);
the equations are one row block per interface, ``I B_i c_i + J A_j c_j = 0``, and one per end.

`solve` sweeps from the termination to the excitation and back. At each interface it finds the waves that the layers
behind return, ``c- = R c+``, and transmit, ``c+(next) = F c+``, from one small system of (n_i + n_j)/2 equations. In
the bases of `matrix.faces` this is a recursion of scattering matrices: no exponential grows, and the cost is linear in
the number of layers. The same equations as one matrix (Allard & Atalla 2009, section 11.5) are solved in the tests.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.matrix.couplings import Contact, Rows, couple, void_rows, wall_rows
from multilayer.matrix.faces import Faces, FacesOfStates
from multilayer.matrix.families import FLUID, Family
from multilayer.matrix.small import aligned, beside, common_shape, multiply, solve_small


@dataclass(frozen=True)
class HalfSpace:
    """A fluid half-space, by its normal wave impedance omega rho / k3, Pa s/m."""

    impedance: Numeric

    def faces(self, ndim: int = 0) -> Faces:
        """Return both directions at the interface: p = c+ + c-, v3 = (c+ - c-) / impedance."""
        y = 1 / np.asarray(self.impedance, dtype=complex)
        (entries,) = aligned(np.array([[np.ones_like(y), np.ones_like(y)], [y, -y]]), ndim=ndim)
        return Faces(FLUID, entries, entries)


@dataclass(frozen=True)
class Wall:
    """A rigid wall; as an excitation, a base that moves along axis 3 with velocity 1."""


@dataclass(frozen=True)
class Void:
    """Nothing: the face is free of stress."""


@dataclass(frozen=True)
class Port:
    """What a medium imposes on an end of a stack: half of its state is given, the other half answers.

    Attributes
    ----------
    family : Family
        Of the medium.
    given, answers : tuple of int
        Indices into its state. As an excitation the first given quantity is 1 and the others are 0, and the first
        answer is what `Solution.reflected` holds; as a termination all that is given is 0, and the first answer is what
        `Solution.transmitted` holds.
    """

    family: Family
    given: tuple[int, ...]
    answers: tuple[int, ...]

    def faces(self, ndim: int = 0, *, is_head: bool) -> Faces:
        """Return the state by coefficients, those that are known first at a head, last at a tail."""
        order = [*self.given, *self.answers] if is_head else [*self.answers, *self.given]
        (entries,) = aligned(np.eye(self.family.size, dtype=complex)[:, order], ndim=ndim)
        return Faces(self.family, entries, entries)


@dataclass(frozen=True)
class System:
    """A stack ready to be solved.

    Attributes
    ----------
    head : HalfSpace, Wall or Port
        Excitation: a plane wave of unit pressure arriving through a half-space, a base of unit velocity, or a port.
    layers : sequence of Faces
        From the excitation to the termination.
    tail : HalfSpace, Wall, Void or Port
    contacts : sequence
        One per interface: head to first layer, between layers, last layer to tail.
    """

    head: HalfSpace | Wall | Port
    layers: Sequence[Faces]
    tail: HalfSpace | Wall | Void | Port
    contacts: Sequence[Contact]


@dataclass(frozen=True)
class Solution:
    """Coefficients of a solved system; each of shape (n_coefficients, ...).

    Attributes
    ----------
    layers : list of complex array
        Coefficients of every layer.
    reflected : complex array or None
        Pressure of the wave that goes back into the head, or the answer of a port; None for a moving base.
    transmitted : complex array or None
        Pressure of the wave that leaves through the tail, at the interface, or the answer of a port; None for a wall or
        a void.
    """

    layers: list[ComplexArray]
    reflected: ComplexArray | None
    transmitted: ComplexArray | None


@dataclass(frozen=True)
class Sweep:
    """The stack behind every layer, as the sweep from the termination finds it.

    Attributes
    ----------
    layers : list of Faces
        With equally many axes in their matrices.
    answers : list of complex array
        Of every layer, c- from c+.
    carries : list of complex array or None
        Of every layer, the c+ of the next layer or half-space from c+; None before a wall or a void.
    matrices : list of complex array
        Of the interface behind every layer, the equations' coefficients of its unknowns; empty unless they are kept.
    """

    layers: list[Faces]
    answers: list[ComplexArray]
    carries: list[ComplexArray | None]
    matrices: list[ComplexArray]


def solve(system: System) -> Solution:
    """Solve a system; every result broadcasts over frequency, angle and samples."""
    return onward(system, backward(system))


def onward(system: System, sweep: Sweep) -> Solution:
    """Return the solution of a system, from the excitation on, after the sweep from its termination."""
    layers, answers, carries = sweep.layers, sweep.answers, sweep.carries
    first = layers[0]
    reflected: ComplexArray | None = None
    if not isinstance(system.head, Wall):
        ndim = answers[0].ndim
        head = system.head.faces(ndim, is_head=True) if isinstance(system.head, Port) else system.head.faces(ndim)
        reflection, carry = _joined(head, first, interface(head, first, answers[0], system.contacts[0]))
        reflected, ahead = reflection[0, 0], carry[:, 0]
    else:
        ahead = _drive(first, answers[0], system.contacts[0])
    coefficients = []
    for answer, carry_on in zip(answers, carries, strict=True):
        coefficients.append(_stacked(ahead, _apply(answer, ahead)))
        ahead = _apply(carry_on, ahead) if carry_on is not None else ahead[:0]
    return Solution(coefficients, reflected, ahead[0] if len(ahead) else None)


def _same_axes(layers: Sequence[Faces]) -> list[Faces]:
    """Return the layers with equally many axes in their matrices; one layer alone may depend on samples."""
    ndim = max(layer.states.ndim for layer in layers)
    return [FacesOfStates(layer.family, layer.states.aligned(ndim), layer.porosity) for layer in layers]


def backward(system: System, *, keep: bool = False) -> Sweep:
    """Sweep a system from its termination to its first layer; `keep` the interfaces' coefficients."""
    layers = _same_axes(system.layers)
    last = layers[-1]
    answers: list[ComplexArray] = []
    carries: list[ComplexArray | None] = []
    matrices: list[ComplexArray] = []

    def keeps(equations: ComplexArray) -> ComplexArray:
        if keep:
            matrices.append(equations[:, -len(equations) :].copy())
        return equations

    if isinstance(system.tail, HalfSpace | Port):
        ndim, tail = last.states.ndim, system.tail
        behind = tail.faces(ndim, is_head=False) if isinstance(tail, Port) else tail.faces(ndim)
        answer, carry = _joined(last, behind, keeps(interface(last, behind, None, system.contacts[-1])))
        answers.append(answer)
        carries.append(carry)
    else:
        held = apply_rows(end_rows(last, system.tail, system.contacts[-1]), last.states.back)
        answers.append(last.states.behind(solve_small(keeps(held))))
        carries.append(None)
    for (layer, following), contact in zip(
        reversed(list(pairwise(layers))), reversed(system.contacts[1:-1]), strict=True
    ):
        answer, carry = _joined(layer, following, keeps(interface(layer, following, answers[-1], contact)))
        answers.append(answer)
        carries.append(carry)
    return Sweep(layers, answers[::-1], carries[::-1], matrices[::-1])


def _joined(layer: Faces, following: Faces, equations: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return (R, F) of one interface: unknown are the layer's c- and the c+ behind, given is the layer's c+."""
    n_behind = following.family.half
    solution = layer.states.behind(solve_small(equations))
    return solution[n_behind:], solution[:n_behind]


def interface(layer: Faces, following: Faces, answer: ComplexArray | None, contact: Contact) -> ComplexArray:
    """Return the equations of one interface: columns of the layer's waves that arrive, of the c+ behind, and of its c-.

    What arrives is the layer's c+ times its decay.
    """
    i_rows, j_rows = couple(layer.family, following.family, contact, layer.porosity, following.porosity)
    here, behind = apply_rows(i_rows, layer.states.back), allowed(j_rows, following, answer)
    half = layer.family.half
    # c- is eliminated: what passes through a stiff layer is small beside what comes back, and no difference of it
    return beside(here[:, :half], behind, here[:, half:])


def allowed(rows: Rows, layer: Faces, answer: ComplexArray | None) -> ComplexArray:
    """Return rows @ the front states that the stack behind allows, one column per c+; c- is zero without an answer."""
    half, states = layer.family.half, layer.states
    if answer is None:
        return apply_rows(rows, states.front[:, :half])
    held = apply_rows(rows, states.front)
    total = multiply(held[:, half:], states.before(answer))
    total += held[:, :half]
    return total


def end_rows(layer: Faces, tail: Wall | Void, contact: Contact) -> Rows:
    """Return the rows of what vanishes at a wall or a void."""
    return wall_rows(layer.family, contact)[0] if isinstance(tail, Wall) else void_rows(layer.family)


def _drive(layer: Faces, answer: ComplexArray, contact: Contact) -> ComplexArray:
    """Return c+ of the layer on a base that moves with unit velocity along axis 3."""
    rows, normal = wall_rows(layer.family, contact)
    held = allowed(rows, layer, answer)
    base = -np.reshape(np.array(normal, dtype=complex), (-1, 1, *(1,) * (held.ndim - 2)))
    return solve_small(beside(base, held))[:, 0]


def apply_rows(rows: Rows, matrix: ComplexArray) -> ComplexArray:
    """Return rows @ matrix, skipping the zeros that most entries of a coupling are."""
    shape = common_shape((matrix[0, 0], *(factor for row in rows for factor in row)))
    result = np.empty((len(rows), matrix.shape[1], *shape), dtype=complex)
    for total, row in zip(result, rows, strict=True):
        terms = [(c, matrix[i]) for i, c in enumerate(row) if not (isinstance(c, int | float) and c == 0)]
        _add_up(terms, total)
    return result


def _add_up(terms: Sequence[tuple[Numeric, ComplexArray]], total: ComplexArray) -> None:
    if not terms:
        total[...] = 0
    for n, (factor, line) in enumerate(terms):
        if n:
            total += factor * line
        elif isinstance(factor, int) and factor == 1:
            total[...] = line
        else:
            np.multiply(factor, line, out=total)


def _stacked(a: ComplexArray, b: ComplexArray) -> ComplexArray:
    shape = np.broadcast_shapes(a.shape[1:], b.shape[1:])
    return np.concatenate([np.broadcast_to(v, v.shape[:1] + shape) for v in (a, b)])


def _apply(matrix: ComplexArray, vector: ComplexArray) -> ComplexArray:
    return multiply(matrix, vector[:, None])[:, 0]
