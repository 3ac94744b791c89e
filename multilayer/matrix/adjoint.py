"""The adjoint of a stack's global system: how its outcomes change with every face matrix, from one more sweep.

Outcomes are linear in the solution x of ``M x = b``, o = l^T x, so that ``do = -y^T dM x`` with ``M^T y = l``: one
solution of the transposed system serves all entries of M. `solve` eliminates layer by layer, and the transposed system
is solved in the same order, interface by interface, from the same small systems: nothing grows exponentially here
either.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from multilayer.arrays import ComplexArray, Numeric
from multilayer.matrix.couplings import Contact, Rows, couple, wall_rows
from multilayer.matrix.faces import Faces, LayerField
from multilayer.matrix.families import Family, normal_velocity
from multilayer.matrix.small import beside, multiply, solve_small
from multilayer.matrix.solve import (
    HalfSpace,
    Port,
    Solution,
    Sweep,
    System,
    Void,
    Wall,
    allowed,
    apply_rows,
    backward,
    end_rows,
    interface,
    onward,
)

_STEP = 1e-3  # of a porosity: differences of fourth order of 1/porosity are exact to some 1e-12


@dataclass(frozen=True)
class Outcomes:
    """The solution of a system, and what the derivatives of its outcomes are made of.

    Outcomes are the pressure that goes back into the head, a half-space, and that which leaves through the tail, if
    that is one; of a moving base the normal velocity of the last back face.

    Attributes
    ----------
    solution : Solution
    fields : list of LayerField
        Of every layer.
    by_porosity : list of complex array or None
        Derivatives by the porosity of every layer's faces, shape (n_outcomes, ...); None where it does not matter.
    """

    solution: Solution
    fields: list[LayerField]
    by_porosity: list[ComplexArray | None]


def solve_with_adjoint(system: System) -> Outcomes:
    """Solve a system and its transpose; the system has no ports."""
    sweep = backward(system, keep=True)
    solution = onward(system, sweep)
    adjoints = _adjoints(system, sweep)
    fields = []
    for i, (layer, coefficients) in enumerate(zip(sweep.layers, solution.layers, strict=True)):
        before, behind, amplitudes = adjoints[i], adjoints[i + 1], coefficients[:, None]
        adjoint_front = apply_rows(_transposed(before.j_rows), before.values)
        adjoint_back = apply_rows(_transposed(behind.i_rows), behind.values)
        if behind.outcome is not None:
            adjoint_back[behind.outcome] -= 1
        front, back = layer.states.at_front(amplitudes), layer.states.at_back(amplitudes)
        fields.append(LayerField(amplitudes, front, back, adjoint_front, adjoint_back))
    return Outcomes(solution, fields, _by_porosity(system, solution, adjoints, fields))


@dataclass(frozen=True)
class _Adjoint:
    """Unknowns of the transposed system at one interface, shape (n_rows, n_outcomes, ...), and its coupling."""

    values: ComplexArray
    i_rows: Rows
    j_rows: Rows
    outcome: int | None = None  # the row of the last back face that is one


def _adjoints(system: System, sweep: Sweep) -> list[_Adjoint]:
    """Return the unknowns of the transposed system at every interface, from the head on.

    A disturbance of an interface's equations changes the waves that go on from it and the one that comes back. How the
    outcomes follow the former, all interfaces know beforehand; what comes back disturbs the interface before.
    """
    layers, last = sweep.layers, sweep.layers[-1]
    row = normal_velocity(last.family) if isinstance(system.head, Wall) else None
    ahead = _ahead(system, sweep, row)
    comes_back = np.eye(0 if row is not None else 1, ahead[0].shape[1], dtype=complex)
    returned: ComplexArray = comes_back.reshape(comes_back.shape + (1,) * (last.states.ndim - 2))
    adjoints = []
    for i, (matrix, i_rows, j_rows) in enumerate(_interfaces(system, sweep)):
        values = _solve_transposed(matrix, _above(ahead[i], returned))
        adjoints.append(_Adjoint(values, i_rows, j_rows, row if i == len(layers) else None))
        if i < len(layers):
            half, states = layers[i].family.half, layers[i].states
            front = apply_rows(_transposed(j_rows), values)
            returned = -states.before(multiply(np.swapaxes(states.front[:, half:], 0, 1), front))
            if row is not None and i == len(layers) - 1:
                returned = returned + last.states.back[row, half:, None]
    return adjoints


def _ahead(system: System, sweep: Sweep, row: int | None) -> list[ComplexArray]:
    """Return how the outcomes follow the waves that go on from every interface, shape (n_waves, n_outcomes, ...)."""
    last, carry = sweep.layers[-1], sweep.carries[-1]
    axes = (1,) * (last.states.ndim - 2)
    n_outcomes = 1 if carry is None or row is not None else 2
    beyond = np.zeros((0 if carry is None else 1, n_outcomes, *axes), dtype=complex)
    if row is not None:
        half, back = last.family.half, last.states.back[row, None]
        state = (last.states.behind(back[:, :half]) + multiply(back[:, half:], sweep.answers[-1]))[0]
        ahead = [beyond, state[:, None]]
    elif carry is not None:
        beyond[0, 1] = 1
        ahead = [beyond, multiply(np.swapaxes(carry, 0, 1), beyond)]
    else:
        ahead = [beyond, np.zeros((last.family.half, 1, *axes), dtype=complex)]
    for carry in sweep.carries[-2::-1]:
        assert carry is not None  # between layers
        ahead.append(multiply(np.swapaxes(carry, 0, 1), ahead[-1]))
    return ahead[::-1]


def _interfaces(system: System, sweep: Sweep) -> Iterator[tuple[ComplexArray, Rows, Rows]]:
    """Give the matrix of the unknowns of every interface, from the head on, and its coupling."""
    first, last, contacts = sweep.layers[0], sweep.layers[-1], system.contacts
    axes = first.states.ndim
    if isinstance(system.head, HalfSpace):
        head, contact = system.head.faces(axes), contacts[0]
        rows = couple(head.family, first.family, contact, head.porosity, first.porosity)
        yield interface(head, first, sweep.answers[0], contact)[:, head.family.half :], *rows
    else:
        held, _ = wall_rows(first.family, contacts[0])
        yield allowed(held, first, sweep.answers[0]), (), held
    tail = [system.tail.faces(axes)] if isinstance(system.tail, HalfSpace) else []
    chain = pairwise([*sweep.layers, *tail])
    for (here, there), matrix, contact in zip(chain, sweep.matrices, contacts[1:], strict=False):
        yield matrix, *couple(here.family, there.family, contact, here.porosity, there.porosity)
    if isinstance(system.tail, Wall | Void):
        yield sweep.matrices[-1], end_rows(last, system.tail, contacts[-1]), ()


def _solve_transposed(matrix: ComplexArray, right: ComplexArray) -> ComplexArray:
    """Return X of ``matrix^T X = right``, the matrix's rows weighed first: velocities beside stresses."""
    with np.errstate(divide="ignore", invalid="ignore"):
        weight = 1 / np.abs(matrix).max(axis=1, keepdims=True)
    n, m = len(matrix), right.shape[1]
    work = np.empty((n, m + n, *np.broadcast_shapes(matrix.shape[2:], right.shape[2:])), dtype=complex)
    np.negative(right, out=work[:, :m])
    np.multiply(np.swapaxes(matrix, 0, 1), np.swapaxes(weight, 0, 1), out=work[:, m:])
    solution = solve_small(work)
    solution *= weight
    return solution


def _above(first: ComplexArray, second: ComplexArray) -> ComplexArray:
    """Return the rows of two matrices, one above the other."""
    return np.swapaxes(beside(np.swapaxes(first, 0, 1), np.swapaxes(second, 0, 1)), 0, 1)


def _transposed(rows: Rows) -> Rows:
    return tuple(zip(*rows, strict=True))


def _by_porosity(
    system: System, solution: Solution, adjoints: list[_Adjoint], fields: list[LayerField]
) -> list[ComplexArray | None]:
    """Return the derivatives by the porosity of every layer's faces, where it stands in their couplings."""
    inside = [(layer, field.front, field.back) for layer, field in zip(system.layers, fields, strict=True)]
    chain = [_outside(system.head, solution.reflected, 1.0), *inside, _outside(system.tail, solution.transmitted, 0.0)]
    total: list[ComplexArray | None] = [None] * len(inside)
    for i, adjoint in enumerate(adjoints):
        (here, _, back), (there, front, _) = chain[i], chain[i + 1]
        if here is None or there is None or back is None or front is None:
            continue  # the conditions at an end know no porosity
        for place, which in ((i - 1, 0), (i, 1)):
            if not 0 <= place < len(inside):
                continue
            if _knows_porosity(here.family, there.family, system.contacts[i], which):
                slopes = _slopes(here, there, system.contacts[i], which)
                change = apply_rows(slopes[0], back) + apply_rows(slopes[1], front)
                lost = np.sum(adjoint.values * change, axis=0)
                total[place] = -lost if total[place] is None else total[place] - lost
    return total


@lru_cache
def _knows_porosity(here: Family, there: Family, contact: Contact, which: int) -> bool:
    """Tell whether one of its porosities stands in a coupling."""
    return couple(here, there, contact, 0.5, 0.5) != couple(here, there, contact, *((0.25, 0.5), (0.5, 0.25))[which])


def _outside(
    end: HalfSpace | Wall | Void | Port, leaving: ComplexArray | None, arriving: float
) -> tuple[Faces | None, ComplexArray | None, ComplexArray | None]:
    """Return the faces of a half-space and the state there, twice; nothing of another end."""
    if not isinstance(end, HalfSpace) or leaving is None:
        return None, None, None
    faces = end.faces(leaving.ndim + 2)
    # c+ arrives through the head and leaves through the tail, as c- does the other way round
    waves = [arriving + 0 * leaving, leaving] if arriving else [leaving, 0 * leaving]
    state = multiply(faces.front, np.array(waves)[:, None])
    return faces, state, state


def _slopes(here: Faces, there: Faces, contact: Contact, which: int) -> tuple[Rows, Rows]:
    """Return the derivatives of both matrices of a coupling by one of its porosities."""
    porosities = (here.porosity, there.porosity)
    step = _STEP * porosities[which]

    def moved(times: int) -> tuple[Rows, Rows]:
        front, back = (value + times * step if i == which else value for i, value in enumerate(porosities))
        return couple(here.family, there.family, contact, front, back)

    def slope(*values: Numeric) -> Numeric:
        return (8 * (values[0] - values[1]) - (values[2] - values[3])) / (12 * step)

    points = [moved(times) for times in (1, -1, 2, -2)]
    first, second = (
        tuple(tuple(map(slope, *rows)) for rows in zip(*(point[side] for point in points), strict=True))
        for side in (0, 1)
    )
    return first, second
