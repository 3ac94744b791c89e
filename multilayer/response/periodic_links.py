"""Lines that hold two leaves at equal distances: the wall as a periodic whole.

A plane wave of the trace wavenumbers kx, across the lines, and ky, along them, meets a wall whose lines lie at every
``x = m b``. By Floquet's theorem all lines pull with one force per length but for the phase ``exp(-i kx m b)``, so that
the forces are, by Poisson's sum, pressures ``F/b`` of all harmonics ``q_n = kx + 2 pi n/b`` on the leaves (D. J. Mead,
J. Sound Vib. 190 (1996) 495-524). With the velocity Y_ab of leaf b for a unit pressure on leaf a, of the stack with all
its layers and the gas on both sides at the wavenumber ``kappa_n = sqrt(q_n^2 + ky^2)``, lines i between the leaves a_i
and b_i obey

    i w C_i F_i + sum_j (1/b) sum_n (Y_aa - Y_ab - Y_ba + Y_bb)_ij(kappa_n) F_j = v_a - v_b,

v the motions without lines. Each harmonic slower than sound stays at the wall; the others radiate behind it. The sum
over n converges as that of plates alone, of which it is known in closed form; the rest falls much faster.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.errors import InputError
from multilayer.matrix.couplings import Contact
from multilayer.matrix.faces import mirrored
from multilayer.matrix.families import FLUID
from multilayer.matrix.solve import HalfSpace, Port, System
from multilayer.matrix.wave import Wave
from multilayer.response.fields import face_states, normal_velocity
from multilayer.response.links import Leaf, LineLinks, leaves
from multilayer.response.system import between_gas, solve_or_explain, wave_impedance
from multilayer.stack import Stack

_FARTHEST = 1.5  # wavenumber of the last harmonic over that of the shortest bending waves
_MORE = 1  # harmonics beyond it
_TOO_MANY = 500  # harmonics of either sign
_BESIDE = 1e-9  # of grazing, where a harmonic neither radiates nor decays
_MOVED = Port(FLUID, given=(1,), answers=(0,))  # a leaf that moves with 1 m/s; its pressure answers


class PeriodicLinks:
    """What goes through a stack with lines at equal distances, all waves between them included.

    Parameters
    ----------
    stack : Stack
        Its leaves with lines are of `elastic_plate`.
    links : sequence of LineLinks
        Of one spacing.
    frequency : array, shape (n_frequency,)
        Hz.

    Raises
    ------
    InputError
        When lines are so far apart, in wavelengths, that there are more than 500 harmonics of either sign.

    Notes
    -----
    Lines hold the leaves' normal motions together and nothing else: their mass and their resistance to rotation are
    left out. Beyond all waves that radiate, and 1.5 times the wavenumber of the shortest bending waves, the leaves are
    taken as plates alone.
    """

    def __init__(self, stack: Stack, links: Sequence[LineLinks], frequency: RealArray) -> None:
        self._stack, self._frequency, self._spacing = stack, frequency, links[0].spacing
        pairs = [leaves(stack, these) for these in links]
        self._leaves = sorted({leaf for pair in pairs for leaf in pair}, key=lambda leaf: leaf.first)
        # rows of motions that each line hinders: that of its front leaf less that of its back leaf
        self._apart = np.array([[float(leaf == front) - float(leaf == back) for leaf in self._leaves]
                                for front, back in pairs])  # fmt: skip
        self._compliance = np.diag([these.compliance for these in links])
        omega = 2 * np.pi * frequency
        at_rest = Wave(frequency, np.zeros_like(frequency), stack.ambient.gas)
        plates = [leaf.mass_and_stiffness(stack, at_rest) for leaf in self._leaves]
        self._mass = np.array([np.broadcast_to(mass, omega.shape) for mass, _ in plates])
        self._stiffness = np.array([np.broadcast_to(stiffness, omega.shape) for _, stiffness in plates])
        shortest = float(np.max((self._mass * omega**2 / np.abs(self._stiffness)) ** 0.25))
        grazing = float(np.max(omega)) / stack.ambient.gas.sound_speed  # of the wave, and of what radiates
        reach = max(_FARTHEST * shortest, grazing) + grazing
        self._most = int(np.ceil(reach * self._spacing / (2 * np.pi))) + _MORE
        if self._most > _TOO_MANY:
            text = f"periodic lines {self._spacing:g} m apart take too many harmonics at {frequency.max():g} Hz"
            raise InputError(f"{text}; leave 'periodic' out: single ones are as good where lines are so far apart")

    def through(self, which: IndexArray, wave: Wave) -> tuple[RealArray, RealArray, RealArray]:
        """Return the power that goes on as it came, that into other directions, and the first without links.

        As `SingleLinks.through`; the azimuth of the wave is that from the normal of the lines.
        """
        gas, turn = wave.ambient, np.deg2rad(wave.azimuth)
        across, along = wave.kx.real * np.cos(turn), wave.kx.real * np.sin(turn)
        mobility = _on_diagonal(self._of_plates_at_lines(which, across, along))
        n, shape = len(self._apart), np.broadcast_shapes(across.shape, wave.omega.shape)
        specular_sent, incident = np.zeros((n, *shape), dtype=complex), np.ones(shape)
        scattered = np.zeros((n, n, *shape), dtype=complex)  # power into other directions, of the lines' forces
        for order in range(-self._most, self._most + 1):
            q = across + 2 * np.pi * order / self._spacing
            kappa, grazing = np.hypot(q, along), wave.omega / gas.sound_speed
            is_grazing = np.abs(kappa - grazing) < _BESIDE * grazing
            harmonic = Wave(wave.frequency, np.where(is_grazing, (1 + _BESIDE) * grazing, kappa), gas)
            answer, passed = self._answers(harmonic)
            mobility = mobility + (answer - _on_diagonal(self._of_plates(which, harmonic.kx.real))) / self._spacing
            sent = -np.tensordot(self._apart, passed, 1) / self._spacing  # pressure behind, of unit forces
            conductance = np.real(1 / wave_impedance(harmonic, gas.density, gas.sound_speed))
            if order:
                scattered += conductance * sent[:, None].conj() * sent
            else:
                specular_sent, incident = sent, conductance
        free, onward = self._without_lines(wave)
        hindering = np.einsum("ia,ab...,jb->...ij", self._apart, mobility, self._apart)
        hindering += 1j * wave.omega[..., None, None] * self._compliance
        hindered = np.einsum("ia,a...->...i", self._apart, free)
        forces = np.moveaxis(np.linalg.solve(hindering, hindered[..., None])[..., 0], -1, 0)
        specular = np.abs(onward + np.sum(specular_sent * forces, axis=0)) ** 2
        other = np.einsum("i...,ij...,j...->...", forces.conj(), scattered, forces).real / incident
        return np.asarray(specular), np.asarray(other), np.abs(onward) ** 2

    def _of_plates(self, which: IndexArray, k: RealArray) -> ComplexArray:
        """Return velocity over pressure of the leaves as plates in empty space, shape (n_leaves, *k.shape)."""
        omega = 2 * np.pi * self._frequency[which]
        return np.asarray(1j * omega / (self._stiffness[:, which] * k**4 - self._mass[:, which] * omega**2))

    def _of_plates_at_lines(self, which: IndexArray, across: RealArray, along: RealArray) -> ComplexArray:
        """Return the sum of `_of_plates` over all harmonics, divided by the spacing.

        By partial fractions, and ``sum_n 1/(q_n^2 + a^2) = b/(2 a) sinh(a b)/(cosh(a b) - cos(kx b))``.
        """
        omega, b = 2 * np.pi * self._frequency[which], self._spacing
        stiffness, mass = self._stiffness[:, which], self._mass[:, which]
        square = np.sqrt(mass * omega**2 / stiffness)  # of the bending wavenumber
        total: ComplexArray = np.zeros(1, dtype=complex)
        for sign in (-1, 1):
            decay = np.sqrt(along**2 + sign * square)
            fading = np.exp(-decay * b)
            total = total - sign * (1 - fading**2) / (1 + fading**2 - 2 * fading * np.cos(across * b)) / (2 * decay)
        return np.asarray(1j * omega / (2 * stiffness * square) * total)

    def _answers(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
        """Return what a pressure of 1 Pa on each leaf does in the stack without lines.

        Returns
        -------
        mobility : complex array, shape (n_leaves, n_leaves, ...)
            Velocities of the leaves, m/(s Pa); symmetric.
        passed : complex array, shape (n_leaves, ...)
            Pressures behind the stack.
        """
        system, n = between_gas(self._stack, wave), len(self._leaves)
        mobility: list[list[ComplexArray]] = [[np.zeros(1, dtype=complex)] * n for _ in range(n)]
        passed = []
        for i, leaf in enumerate(self._leaves):
            behind = System(_MOVED, system.layers[leaf.first :], system.tail, _from(leaf, system))
            answer = solve_or_explain(behind, self._stack, wave)
            assert answer.reflected is not None  # of a port
            assert answer.transmitted is not None  # by validation
            own = 1 / (answer.reflected + self._in_front(leaf, system, wave))
            for j, other in enumerate(self._leaves[i:], start=i):
                at = other.first - leaf.first
                mobility[i][j] = mobility[j][i] = own * _velocity(behind, at, answer.layers[at])
            passed.append(own * answer.transmitted)
        return np.array(mobility), np.array(passed)

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

    def _without_lines(self, wave: Wave) -> tuple[ComplexArray, ComplexArray]:
        """Return velocities of the leaves, shape (n_leaves, ...), and the pressure behind, for a wave of 1 Pa."""
        system = between_gas(self._stack, wave)
        solution = solve_or_explain(system, self._stack, wave)
        assert solution.transmitted is not None  # by validation
        moved = [_velocity(system, leaf.first, solution.layers[leaf.first]) for leaf in self._leaves]
        return np.array(moved), solution.transmitted


def _from(leaf: Leaf, system: System) -> tuple[Contact, ...]:
    """Return the contacts of a system from the front of a leaf on."""
    return ("bonded", *system.contacts[leaf.first + 1 :])


def _velocity(system: System, index: int, coefficients: ComplexArray) -> ComplexArray:
    layer = system.layers[index]
    return normal_velocity(layer, face_states(layer, coefficients)[0])


def _on_diagonal(values: ComplexArray) -> ComplexArray:
    """Return diagonal matrices, shape (n, n, ...), of values of shape (n, ...)."""
    return np.asarray(np.eye(len(values))[(..., *(None,) * (values.ndim - 1))] * values)
