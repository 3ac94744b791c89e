"""What pressures on the leaves of a stack move and send on, at any wavenumber along it.

It depends on the wavenumber alone, as the stack is isotropic in its plane, and is asked for at many: harmonics of a
periodic wall, times angles and azimuths. So it is computed at nodes and interpolated between them, by what is smooth:
pressures for unit velocities of the leaves, which have no poles where bending waves are free, times ``|k3|/k`` of the
air, which takes away the poles of its impedance at grazing. Where waves stand between leaves at rest, in a cavity
without losses, they have poles all the same: what is asked for there is solved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from multilayer.arrays import BoolArray, ComplexArray, IndexArray, RealArray
from multilayer.matrix.couplings import Contact
from multilayer.matrix.faces import mirrored
from multilayer.matrix.families import FLUID
from multilayer.matrix.small import solve_small
from multilayer.matrix.solve import HalfSpace, Port, System
from multilayer.matrix.wave import Wave
from multilayer.response.fields import face_states, normal_velocity
from multilayer.response.links import Leaf
from multilayer.response.system import between_gas, solve_or_explain
from multilayer.stack import Stack

_FEWEST, _MOST = 17, 513  # nodes of waves that radiate, and of those that do not; each
_FIRST_NODE = 3e-5  # |k3|/k of the node beside grazing, where the air's impedance is infinite
_ROUGH = 1e-3  # error in the middle between two of every other node, as a share, that asks for more nodes
_AT_REST = 2.0  # Pa on a leaf at rest, of a wave of 1 Pa that comes to it through air alone
_MOVED = Port(FLUID, given=(1,), answers=(0,))  # a leaf that moves with 1 m/s; its pressure answers


@dataclass(frozen=True)
class _Table:
    """Values over ``|k3|/k`` at nodes that are dense at grazing, and cubics through the four around each place.

    Attributes
    ----------
    most : array, shape (n_frequency,)
        The last node of each frequency.
    first, steps : array of int, shape (n_frequency,)
        The row of each frequency's first node, and how many nodes follow that one.
    rows : complex array, shape (n_rows, n_values)
    is_rough : bool array, shape (n_rows,)
        Whether interpolation fails between a node and the next.
    """

    most: RealArray
    first: IndexArray
    steps: IndexArray
    rows: ComplexArray
    is_rough: BoolArray

    @classmethod
    def of(cls, most: RealArray, parts: Sequence[tuple[IndexArray, ComplexArray, BoolArray]]) -> _Table:
        """Return the table of all frequencies by parts with as many nodes each.

        Parameters
        ----------
        most : array, shape (n_frequency,)
        parts : sequence
            Indices of n frequencies; values, shape (n_values, n, n_nodes); `is_rough`, shape (n, n_nodes).
        """
        first, steps, filled = np.zeros(len(most), dtype=int), np.zeros(len(most), dtype=int), 0
        for which, values, _ in parts:
            n = values.shape[-1]
            first[which], steps[which] = filled + n * np.arange(len(which)), n - 1
            filled += n * len(which)
        rows = np.concatenate([values.reshape(len(values), -1) for _, values, _ in parts], axis=1).T.copy()
        return cls(most, first, steps, rows, np.concatenate([is_rough.ravel() for _, _, is_rough in parts]))

    def at(self, which: IndexArray, normal: RealArray) -> tuple[ComplexArray, BoolArray]:
        """Return values, shape (n_values, n), of frequencies by their indices, and whether interpolation fails."""
        steps = self.steps[which]
        place = np.sqrt(np.clip((normal - _FIRST_NODE) / (self.most[which] - _FIRST_NODE), 0.0, 1.0)) * steps
        node = np.minimum(place.astype(int), steps - 1)
        start = np.clip(node - 1, 0, steps - 3)
        t, row = place - start, self.first[which] + start
        weights = np.stack([-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2,
                            -t * (t - 1) * (t - 3) / 2, t * (t - 1) * (t - 2) / 6], axis=-1)  # fmt: skip
        # four rows at once and real numbers: a third of the time
        fours = sliding_window_view(self.rows.view(float), 4, axis=0).swapaxes(1, 2)
        values = (weights[:, None] @ fours[row])[:, 0].view(complex)
        return np.ascontiguousarray(values.T), self.is_rough[self.first[which] + node]


class Answers(NamedTuple):
    """What pressures of 1 Pa on each leaf do, and a wave of 1 Pa that arrives in front, at n wavenumbers.

    Attributes
    ----------
    mobility : complex array, shape (n_leaves, n_leaves, n)
        Velocities of the leaves, m/(s Pa); symmetric.
    passed : complex array, shape (n_leaves, n)
        Pressures behind the stack.
    blocked : complex array, shape (n,)
        Pressure of the wave on the first leaf held at rest; it moves all leaves as this pressure does.
    """

    mobility: ComplexArray
    passed: ComplexArray
    blocked: ComplexArray


class DrivenLeaves:
    """Answers of a stack between half-spaces of its gas to pressures on its leaves.

    Parameters
    ----------
    stack : Stack
        Isotropic in its plane; its fields hold numbers.
    leaves : sequence of Leaf
        Of `elastic_plate`, from the sound on.
    frequency : array, shape (n_frequency,)
        Hz.
    farthest : array, shape (n_frequency,)
        Largest wavenumbers that are asked for, 1/m; above those of sound.
    """

    def __init__(self, stack: Stack, leaves: Sequence[Leaf], frequency: RealArray, farthest: RealArray) -> None:
        self._stack, self._leaves, self._frequency = stack, leaves, frequency
        self._sound = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
        self._pairs = np.triu_indices(len(leaves))
        self._radiating = self._tabled(np.ones_like(frequency), slow=False)
        self._slow = self._tabled(np.sqrt((farthest / self._sound) ** 2 - 1), slow=True)

    def mobility(self, which: IndexArray, wavenumber: RealArray) -> ComplexArray:
        """Return the mobility at wavenumbers above that of sound, 1/m, shape (n,), by indices of frequencies."""
        normal = np.sqrt(np.maximum((wavenumber / self._sound[which]) ** 2 - 1, _FIRST_NODE**2))
        values, is_rough = self._slow.at(which, normal)
        mobility = self._mobility(values / normal)
        if np.any(is_rough):
            mobility[..., is_rough] = self.solved(which[is_rough], wavenumber[is_rough]).mobility
        return mobility

    def answers(self, which: IndexArray, wavenumber: RealArray) -> Answers:
        """Return the answers at wavenumbers up to that of sound, 1/m, shape (n,), by indices of frequencies."""
        normal = np.sqrt(np.maximum(1 - (wavenumber / self._sound[which]) ** 2, _FIRST_NODE**2))
        values, is_rough = self._radiating.at(which, normal)
        answers = self._answers(values, normal)
        if np.any(is_rough):
            solved = self.solved(which[is_rough], wavenumber[is_rough])
            for here, there in zip(answers, solved, strict=True):
                here[..., is_rough] = there
        return answers

    def _answers(self, values: ComplexArray, normal: RealArray) -> Answers:
        mobility = self._mobility(values[:-2] / normal)
        return Answers(mobility, values[-2] / normal * mobility[-1], values[-1])

    def _mobility(self, impedances: ComplexArray) -> ComplexArray:
        """Return mobilities by the impedances of pairs of leaves, shape (n_pairs, n)."""
        impedance = np.empty((len(self._leaves), len(self._leaves), impedances.shape[-1]), dtype=complex)
        rows, columns = self._pairs
        impedance[rows, columns] = impedance[columns, rows] = impedances
        return _inverse(impedance)

    def _tabled(self, most: RealArray, *, slow: bool) -> _Table:
        """Return impedances of the leaves, and pressure behind over the last leaf's velocity, times ``|k3|/k``.

        And `blocked`, both of waves that radiate. Nodes of each frequency are doubled until every other one, by
        interpolation between the rest, is as it is solved; all of them are kept, so that errors are some hundred times
        smaller than those that are looked at.
        """
        which, parts = np.arange(len(most)), list[tuple[IndexArray, ComplexArray, BoolArray]]()
        values = self._values(which, most, np.linspace(0, 1, _FEWEST), slow=slow)[0]
        while len(which):
            n = values.shape[-1]
            middles = (np.arange(n - 1) + 0.5) / (n - 1)
            between, exact = self._values(which, most, middles, slow=slow)
            here = np.arange(len(which))
            coarse = _Table.of(most[which], [(here, values, np.zeros((len(which), n), dtype=bool))])
            normal = _normal(most[which], middles)
            at = coarse.at(np.repeat(here, n - 1), normal)[0]
            off = self._errors(at, normal, exact, slow=slow)
            is_rough = ~(off.reshape(len(which), -1) <= _ROUGH)
            all_values = np.empty((len(values), len(which), 2 * n - 1), dtype=complex)
            all_values[..., ::2], all_values[..., 1::2] = values, between
            again = np.any(is_rough, axis=1) & (2 * n - 1 < _MOST)
            both = np.repeat(is_rough, 2, axis=1)
            done = np.pad(both, ((0, 0), (0, 1)))[~again]
            parts.append((which[~again], all_values[:, ~again], done))
            which, values = which[again], all_values[:, again]
        return _Table.of(most, parts)

    def _errors(self, values: ComplexArray, normal: RealArray, exact: Answers, *, slow: bool) -> RealArray:
        """Return the largest relative error of the answers by values of a table, shape (n,)."""
        answers = None if slow else self._answers(values, normal)
        mobility = answers.mobility if answers else self._mobility(values / normal)
        # one leaf may move another next to nothing, through a thick layer: small beside what both do themselves
        size = np.sqrt(np.abs(np.einsum("iin->in", exact.mobility)))
        off = np.max(np.abs(mobility - exact.mobility) / (size[:, None] * size), axis=(0, 1))
        if answers:  # nothing of slow waves is sent on
            largest = np.max(np.abs(exact.passed), axis=0)
            off = np.maximum(off, np.max(np.abs(answers.passed - exact.passed), axis=0) / largest)
            off = np.maximum(off, np.abs(answers.blocked - exact.blocked) / _AT_REST)
        return np.asarray(off)

    def _values(
        self, which: IndexArray, most: RealArray, places: RealArray, *, slow: bool
    ) -> tuple[ComplexArray, Answers]:
        """Return values of a table, shape (n_values, n_which, n_places), and what they follow from."""
        normal = _normal(most[which], places)
        there = np.repeat(which, len(places))
        wavenumber = self._sound[there] * np.sqrt(1 + (1 if slow else -1) * normal**2)
        exact = self.solved(there, wavenumber)
        values = normal * _inverse(exact.mobility)[self._pairs]
        if not slow:
            behind = normal * exact.passed[-1] / exact.mobility[-1, -1]
            values = np.concatenate([values, behind[None], exact.blocked[None]])
        return values.reshape(-1, len(which), len(places)), exact

    def solved(self, which: IndexArray, wavenumber: RealArray) -> Answers:
        """Return the answers at any wavenumbers, without interpolation."""
        wave = Wave(self._frequency[which], wavenumber, self._stack.ambient.gas)
        system, n = between_gas(self._stack, wave), len(self._leaves)
        mobility = np.empty((n, n, len(which)), dtype=complex)
        passed = np.empty((n, len(which)), dtype=complex)
        blocked = np.full(len(which), _AT_REST, dtype=complex)
        for i, leaf in enumerate(self._leaves):
            behind = System(_MOVED, system.layers[leaf.first :], system.tail, _from(leaf, system))
            answer = solve_or_explain(behind, self._stack, wave)
            assert answer.reflected is not None  # of a port
            assert answer.transmitted is not None  # by validation
            impedance, sent = self._in_front(leaf, system, wave)
            moved = 1 / (answer.reflected + impedance)
            if not i and leaf.first:  # by reciprocity
                assert isinstance(system.head, HalfSpace)
                blocked = _AT_REST * sent / system.head.impedance
            for j, other in enumerate(self._leaves[i:], start=i):
                at = other.first - leaf.first
                mobility[i, j] = mobility[j, i] = moved * front_velocity(behind, at, answer.layers[at])
            passed[i] = moved * answer.transmitted
        return Answers(mobility, passed, blocked)

    def _in_front(self, leaf: Leaf, system: System, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
        """Return the impedance of what lies in front of a leaf, Pa s/m, and the pressure sent there by 1 m/s."""
        assert isinstance(system.head, HalfSpace)
        if not leaf.first:
            return np.asarray(system.head.impedance), np.asarray(system.head.impedance)
        before = [mirrored(layer) for layer in reversed(system.layers[: leaf.first])]
        ahead = System(_MOVED, before, system.head, tuple(reversed(system.contacts[: leaf.first + 1])))
        answer = solve_or_explain(ahead, self._stack, wave)
        assert answer.reflected is not None  # of a port
        assert answer.transmitted is not None  # of a half-space
        return answer.reflected, answer.transmitted


def front_velocity(system: System, index: int, coefficients: ComplexArray) -> ComplexArray:
    """Return the normal velocity of the front of a layer, by the layer's index and the coefficients of its waves."""
    layer = system.layers[index]
    return normal_velocity(layer, face_states(layer, coefficients)[0])


def _normal(most: RealArray, places: RealArray) -> RealArray:
    """Return ``|k3|/k`` at places from 0, beside grazing, to 1, shape (n_frequency * n_places,)."""
    return np.asarray((_FIRST_NODE + (most[:, None] - _FIRST_NODE) * places**2).ravel())


def _from(leaf: Leaf, system: System) -> tuple[Contact, ...]:
    """Return the contacts of a system from the front of a leaf on."""
    return ("bonded", *system.contacts[leaf.first + 1 :])


def _inverse(matrices: ComplexArray) -> ComplexArray:
    """Return the inverses of symmetric entry-first matrices."""
    n = len(matrices)
    if n == 1:
        return 1 / matrices
    if n == 2:
        (a, b), (c, d) = matrices
        inverse = np.empty_like(matrices)
        over = 1 / (a * d - b * c)
        inverse[0, 0], inverse[0, 1], inverse[1, 0], inverse[1, 1] = d * over, -b * over, -c * over, a * over
        return inverse
    if n == 3:
        (a, b, c), (_, d, e), (_, _, f) = matrices
        first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
        fourth, fifth, sixth = a * f - c * c, b * c - a * e, a * d - b * b
        over = 1 / (a * first + b * second + c * third)
        rows = (first, second, third), (second, fourth, fifth), (third, fifth, sixth)
        return np.asarray(np.array(rows) * over)
    work = np.empty((n, 2 * n, *matrices.shape[2:]), dtype=complex)
    work[:, :n] = -np.eye(n)[(..., *(None,) * (matrices.ndim - 2))]
    work[:, n:] = matrices
    return solve_small(work)
