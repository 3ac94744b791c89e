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

import numpy as np

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

_NODES = 512  # of waves that radiate, and of those that do not; each
_FIRST_NODE = 3e-5  # |k3|/k of the node beside grazing, where the air's impedance is infinite
_ROUGH = 1e-3  # error in the middle between two nodes, as a share, from which on nothing is interpolated there
_MOVED = Port(FLUID, given=(1,), answers=(0,))  # a leaf that moves with 1 m/s; its pressure answers


@dataclass(frozen=True)
class _Table:
    """Values over ``|k3|/k`` at nodes that are dense at grazing, and cubics through the four around each place.

    Attributes
    ----------
    most : array, shape (n_frequency,)
        The last node of each frequency.
    rows : complex array, shape (n_frequency * n_nodes, n_values)
    """

    most: RealArray
    rows: ComplexArray

    def at(self, which: IndexArray, place: RealArray) -> ComplexArray:
        """Return values, shape (n_values, n), by indices of frequencies and places, 0 to the last node."""
        first = np.clip(place.astype(int) - 1, 0, _NODES - 4)
        t, start = place - first, which * _NODES + first
        weights = (-(t - 1) * (t - 2) * (t - 3) / 6, t * (t - 2) * (t - 3) / 2,
                   -t * (t - 1) * (t - 3) / 2, t * (t - 1) * (t - 2) / 6)  # fmt: skip
        return np.asarray(sum(weight[:, None] * self.rows[start + i] for i, weight in enumerate(weights))).T

    def place(self, which: IndexArray, normal: RealArray) -> RealArray:
        """Return the places of values of ``|k3|/k``."""
        return np.asarray(np.sqrt(np.minimum(normal / self.most[which], 1.0)) * (_NODES - 1))


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
        self._is_rough = self._rough_between()

    def answers(self, which: IndexArray, wavenumber: RealArray, *, slow: bool) -> tuple[ComplexArray, ComplexArray]:
        """Return what a pressure of 1 Pa on each leaf does.

        Parameters
        ----------
        which : array of int, shape (n,)
            Frequencies, by their indices.
        wavenumber : array, shape (n,)
            1/m; all above that of sound, or none.
        slow : bool
            Whether all are above.

        Returns
        -------
        mobility : complex array, shape (n_leaves, n_leaves, n)
            Velocities of the leaves, m/(s Pa); symmetric.
        passed : complex array, shape (n_leaves, n)
            Pressures behind the stack.
        """
        table = self._slow if slow else self._radiating
        square = (wavenumber / self._sound[which]) ** 2 - 1
        normal = np.maximum(np.sqrt(np.maximum(square if slow else -square, 0.0)), _FIRST_NODE)
        place = table.place(which, normal)
        mobility, passed = self._interpolated(table, which, place, normal)
        if not slow:
            rough = self._is_rough[which, np.minimum(place.astype(int), _NODES - 2)]
            if np.any(rough):
                mobility[..., rough], passed[:, rough] = self.solved(which[rough], wavenumber[rough])
        return mobility, passed

    def _interpolated(
        self, table: _Table, which: IndexArray, place: RealArray, normal: RealArray
    ) -> tuple[ComplexArray, ComplexArray]:
        values = table.at(which, place) / normal
        impedance = np.empty((len(self._leaves), len(self._leaves), len(normal)), dtype=complex)
        rows, columns = self._pairs
        impedance[rows, columns] = impedance[columns, rows] = values[:-1]
        mobility = _inverse(impedance)
        return mobility, values[-1] * mobility[-1]

    def _rough_between(self) -> BoolArray:
        """Tell between which nodes of waves that radiate interpolation fails, shape (n_frequency, n_nodes - 1)."""
        shape = (len(self._frequency), _NODES - 1)
        which = np.repeat(np.arange(shape[0]), shape[1])
        place = np.tile(np.arange(shape[1]) + 0.5, shape[0])
        normal = np.maximum((place / shape[1]) ** 2, _FIRST_NODE)
        mobility, passed = self._interpolated(self._radiating, which, place, normal)
        exact, behind = self.solved(which, self._sound[which] * np.sqrt(1 - normal**2))
        # one leaf may move another next to nothing, through a thick layer: that is small beside what both do themselves
        size = np.sqrt(np.abs(np.einsum("iin->in", exact)))
        off = np.max(np.abs(mobility - exact) / (size[:, None] * size), axis=(0, 1))
        off = np.maximum(off, np.max(np.abs(passed - behind), axis=0) / np.max(np.abs(behind), axis=0))
        return np.asarray(off > _ROUGH).reshape(shape)

    def _tabled(self, most: RealArray, *, slow: bool) -> _Table:
        """Return impedances of the leaves, and pressure behind over the last leaf's velocity, times ``|k3|/k``."""
        normal = np.maximum(most[:, None] * np.linspace(0, 1, _NODES) ** 2, _FIRST_NODE).ravel()
        which = np.repeat(np.arange(len(most)), _NODES)
        mobility, passed = self.solved(which, self._sound[which] * np.sqrt(1 + (1 if slow else -1) * normal**2))
        behind = passed[-1] / mobility[-1, -1]
        return _Table(most, (normal * np.concatenate([_inverse(mobility)[self._pairs], behind[None]])).T)

    def solved(self, which: IndexArray, wavenumber: RealArray) -> tuple[ComplexArray, ComplexArray]:
        """Return what `answers` returns, without interpolation."""
        wave = Wave(self._frequency[which], wavenumber, self._stack.ambient.gas)
        system, n = between_gas(self._stack, wave), len(self._leaves)
        mobility = np.empty((n, n, len(which)), dtype=complex)
        passed = np.empty((n, len(which)), dtype=complex)
        for i, leaf in enumerate(self._leaves):
            behind = System(_MOVED, system.layers[leaf.first :], system.tail, _from(leaf, system))
            answer = solve_or_explain(behind, self._stack, wave)
            assert answer.reflected is not None  # of a port
            assert answer.transmitted is not None  # by validation
            moved = 1 / (answer.reflected + self._in_front(leaf, system, wave))
            for j, other in enumerate(self._leaves[i:], start=i):
                at = other.first - leaf.first
                mobility[i, j] = mobility[j, i] = moved * front_velocity(behind, at, answer.layers[at])
            passed[i] = moved * answer.transmitted
        return mobility, passed

    def _in_front(self, leaf: Leaf, system: System, wave: Wave) -> ComplexArray:
        """Return the impedance of what lies in front of a leaf, Pa s/m."""
        assert isinstance(system.head, HalfSpace)
        if not leaf.first:
            return np.asarray(system.head.impedance)
        before = [mirrored(layer) for layer in reversed(system.layers[: leaf.first])]
        ahead = System(_MOVED, before, system.head, tuple(reversed(system.contacts[: leaf.first + 1])))
        answer = solve_or_explain(ahead, self._stack, wave)
        assert answer.reflected is not None  # of a port
        return answer.reflected


def front_velocity(system: System, index: int, coefficients: ComplexArray) -> ComplexArray:
    """Return the normal velocity of the front of a layer, by the layer's index and the coefficients of its waves."""
    layer = system.layers[index]
    return normal_velocity(layer, face_states(layer, coefficients)[0])


def _from(leaf: Leaf, system: System) -> tuple[Contact, ...]:
    """Return the contacts of a system from the front of a leaf on."""
    return ("bonded", *system.contacts[leaf.first + 1 :])


def _inverse(matrices: ComplexArray) -> ComplexArray:
    """Return the inverses of entry-first matrices."""
    n = len(matrices)
    if n == 1:
        return 1 / matrices
    if n == 2:
        (a, b), (c, d) = matrices
        inverse = np.empty_like(matrices)
        over = 1 / (a * d - b * c)
        inverse[0, 0], inverse[0, 1], inverse[1, 0], inverse[1, 1] = d * over, -b * over, -c * over, a * over
        return inverse
    work = np.empty((n, 2 * n, *matrices.shape[2:]), dtype=complex)
    work[:, :n] = -np.eye(n)[(..., *(None,) * (matrices.ndim - 2))]
    work[:, n:] = matrices
    return solve_small(work)
