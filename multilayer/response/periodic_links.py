"""Lines that hold two leaves at equal distances: the wall as a periodic whole.

A plane wave of the trace wavenumbers kx, across the lines, and ky, along them, meets a wall whose lines lie at every
``x = n b``, and on them fasteners at every ``y = m s``. By Floquet's theorem all fasteners pull with one force but for
the phase ``exp(-i kx n b - i ky m s)``, so that the forces are, by Poisson's sum, pressures ``F/b`` of all harmonics
``q_n = kx + 2 pi n/b``, ``r_m = ky + 2 pi m/s`` on the leaves, F the force per length of a line (D. J. Mead, J.
Sound Vib. 190 (1996) 495-524; of points, B. R. Mace, J. Sound Vib. 192 (1996) 629). With the velocity Y_ab of leaf b
for a unit pressure on leaf a, of the stack with all its layers and the gas on both sides at the wavenumber
``kappa = sqrt(q_n^2 + r_m^2)``, lines i between the leaves a_i and b_i obey

    i w C_i F_i + sum_j (1/b) sum_nm (Y_aa - Y_ab - Y_ba + Y_bb)_ij(kappa_nm) F_j = v_a - v_b,

v the motions without lines. Lines that hold all along have r_0 = ky alone. Each harmonic slower than sound stays at the
wall; the others radiate behind it. The sums converge as those of plates alone, of which that over n is known in closed
form; the rest falls much faster.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, IndexArray, RealArray
from multilayer.errors import InputError
from multilayer.matrix.wave import Wave
from multilayer.response.driven_leaves import Answers, DrivenLeaves
from multilayer.response.links import LineLinks, leaves
from multilayer.response.system import wave_impedance
from multilayer.stack import Stack

_FARTHEST = 1.5  # wavenumber of the last harmonic over that of the shortest waves, of bending or sound
_PLATES = 4.0  # the same along lines with fasteners, of plates alone; what is beyond follows in closed form
_TOO_MANY = 500  # harmonics of either sign, of lines that hold all along
_TOO_MANY_POINTS = 20_000  # harmonics, of fasteners
_BESIDE = 1e-9  # of grazing, where a harmonic neither radiates nor decays


@dataclass
class _Sums:
    """Sums over harmonics, added to as these are computed, of n waves that arrive.

    Attributes
    ----------
    mobility : complex array, shape (n_leaves, n_leaves, n)
        Velocities of the leaves at the lines for unit forces per length there, times the spacing, beyond those of
        plates alone.
    free : complex array, shape (n_leaves, n)
        Velocities of the leaves without lines, for a wave of 1 Pa that arrives.
    onward : complex array, shape (n,)
        Pressure behind without lines, of that wave.
    sent : complex array, shape (n_lines, n)
        Pressures behind, in the direction of the wave that arrives, of unit forces.
    incident : array, shape (n,)
        Power of a wave of 1 Pa that arrives.
    scattered : complex array, shape (n_lines, n_lines, n)
        Power into other directions, a quadratic form of the forces.
    """

    mobility: ComplexArray
    free: ComplexArray
    onward: ComplexArray
    sent: ComplexArray
    incident: RealArray
    scattered: ComplexArray

    @classmethod
    def none(cls, n_leaves: int, n_lines: int, n: int) -> _Sums:
        """Return sums of no harmonics."""
        shapes = (n_leaves, n_leaves, n), (n_leaves, n), (n,), (n_lines, n), (n_lines, n_lines, n)
        mobility, free, onward, sent, scattered = (np.zeros(shape, dtype=complex) for shape in shapes)
        return cls(mobility, free, onward, sent, np.ones(n), scattered)


class PeriodicLinks:
    """What goes through a stack with lines at equal distances, all waves between them included.

    Parameters
    ----------
    stack : Stack
        Its leaves with lines are of `elastic_plate`.
    links : sequence of LineLinks
        Of one spacing, and fasteners of one.
    frequency : array, shape (n_frequency,)
        Hz.

    Raises
    ------
    InputError
        When lines or fasteners are so far apart, in wavelengths, that there are too many harmonics.

    Notes
    -----
    Lines hold the leaves' normal motions together, all along or at their fasteners, and nothing else: their mass and
    their resistance to bending and rotation are left out. Beyond 1.5 times the wavenumber of the shortest waves, of
    bending or sound, the leaves are taken as plates alone.
    """

    def __init__(self, stack: Stack, links: Sequence[LineLinks], frequency: RealArray) -> None:
        self._stack, self._frequency = stack, frequency
        self._spacing, self._fasteners = links[0].spacing, links[0].fasteners
        pairs = [leaves(stack, these) for these in links]
        self._leaves = sorted({leaf for pair in pairs for leaf in pair}, key=lambda leaf: leaf.first)
        # rows of motions that each line hinders: that of its front leaf less that of its back leaf
        self._apart = np.array([[float(leaf == front) - float(leaf == back) for leaf in self._leaves]
                                for front, back in pairs])  # fmt: skip
        self._compliance = np.diag([these.compliance for these in links])
        omega = 2 * np.pi * frequency
        at_rest = Wave(frequency, np.zeros_like(frequency), stack.ambient.gas)
        every = [np.broadcast_arrays(omega, *leaf.mass_and_stiffness(stack, at_rest))[1:] for leaf in self._leaves]
        # leaves that are alike are computed once as plates alone
        alike = [next(j for j, other in enumerate(every) if np.array_equal(plate, other)) for plate in every]
        kept, self._kinds = np.unique(alike, return_inverse=True)
        self._mass, self._stiffness = (np.array([every[i][part] for i in kept]) for part in (0, 1))
        self._shortest = np.max((self._mass * omega**2 / np.abs(self._stiffness)) ** 0.25, axis=0)
        self._rigidity, self._inertia = self._stiffness / (1j * omega), 1j * omega * self._mass
        self._sound = omega / stack.ambient.gas.sound_speed
        self._farthest = _FARTHEST * np.maximum(self._shortest, self._sound)
        self._most = int(np.ceil(float((self._farthest + self._sound).max()) * self._spacing / (2 * np.pi)))
        self._most_along = self._harmonics_along()
        self._refuse_too_many()
        self._driven = DrivenLeaves(stack, self._leaves, frequency, self._farthest)

    def _harmonics_along(self) -> int:
        """Return how many harmonics of either sign there are along the lines."""
        if self._fasteners is None:
            return 0
        reach = np.max(np.maximum(_PLATES * self._shortest + self._sound, self._farthest))
        return int(np.ceil(float(reach) * self._fasteners / (2 * np.pi)))

    def _refuse_too_many(self) -> None:
        text = f"take too many harmonics at {self._frequency.max():g} Hz"
        if self._most > _TOO_MANY:
            text = f"periodic lines {self._spacing:g} m apart {text}"
            raise InputError(
                f"{text}; leave 'periodic' and 'fasteners' out: single ones are as good where lines are so far apart"
            )
        if self._most * self._most_along > _TOO_MANY_POINTS / 4:
            text = f"fasteners {self._fasteners:g} m apart on lines {self._spacing:g} m apart {text}"
            raise InputError(f"{text}; leave 'periodic' and 'fasteners' out, and write links of kind: point")

    def through(self, which: IndexArray, wave: Wave) -> tuple[RealArray, RealArray, RealArray]:
        """Return the power that goes on as it came, that into other directions, and the first without links.

        As `SingleLinks.through`; the azimuth of the wave is that from the normal of the lines.
        """
        turn = np.deg2rad(wave.azimuth)
        across, along = wave.kx.real * np.cos(turn), wave.kx.real * np.sin(turn)
        shape = np.broadcast_shapes(across.shape, wave.omega.shape)
        which = np.broadcast_to(which, shape).ravel()
        across, along = (np.broadcast_to(values, shape).ravel() for values in (across, along))
        sums, plates = _Sums.none(len(self._leaves), len(self._apart), len(which)), self._of_plates_beyond(which)
        for turns in range(-self._most_along, self._most_along + 1):
            r = along + (2 * np.pi * turns / self._fasteners if self._fasteners else 0.0)
            plates = plates + self._of_plates_at_lines(which, across, r)
            for order in range(-self._most, self._most + 1):
                kappa = np.hypot(across + 2 * np.pi * order / self._spacing, r)
                self._add_harmonic(sums, which, kappa, is_specular=not (order or turns))
        mobility, diagonal = sums.mobility / self._spacing, np.arange(len(plates))
        mobility[diagonal, diagonal] += plates
        hindering = np.einsum("ia,abx,jb->xij", self._apart, mobility, self._apart)
        hindering += 2j * np.pi * self._frequency[which, None, None] * self._compliance
        hindered = np.einsum("ia,ax->xi", self._apart, sums.free)
        forces = np.linalg.solve(hindering, hindered[..., None])[..., 0].T
        specular = np.abs(sums.onward + np.sum(sums.sent * forces, axis=0)) ** 2
        other = np.einsum("ix,ijx,jx->x", forces.conj(), sums.scattered, forces).real / sums.incident
        return specular.reshape(shape), other.reshape(shape), np.abs(sums.onward.reshape(shape)) ** 2

    def _add_harmonic(self, sums: _Sums, which: IndexArray, kappa: RealArray, *, is_specular: bool) -> None:
        """Add what the leaves do in a harmonic beyond what they would do as plates alone, and what radiates."""
        is_near = kappa <= self._farthest[which]
        is_slow = (kappa > (1 - _BESIDE) * self._sound[which]) & (not is_specular)
        if np.any(slow := is_near & is_slow):
            points, there, slow_kappa = _chosen(slow, which, kappa)
            self._add_mobility(sums, points, there, slow_kappa, self._driven.mobility(there, slow_kappa))
        if np.any(fast := is_near & ~is_slow):
            points, there, fast_kappa = _chosen(fast, which, kappa)
            answers = self._driven.answers(there, fast_kappa)
            self._radiate(sums, points, there, fast_kappa, answers, is_specular=is_specular)
            self._add_mobility(sums, points, there, fast_kappa, answers.mobility)

    def _add_mobility(
        self, sums: _Sums, points: slice | IndexArray, there: IndexArray, kappa: RealArray, mobility: ComplexArray
    ) -> None:
        """Add mobilities, which it changes, beyond those of the plates alone."""
        plates = self._of_plates(there, kappa)
        for i, kind in enumerate(self._kinds):
            mobility[i, i] -= plates[kind]
        sums.mobility[..., points] += mobility

    def _radiate(
        self,
        sums: _Sums,
        points: slice | IndexArray,
        there: IndexArray,
        kappa: RealArray,
        answers: Answers,
        *,
        is_specular: bool,
    ) -> None:
        """Add what harmonics that are faster than sound send on; of the wave that arrives, what it does, too."""
        gas = self._stack.ambient.gas
        sent = -np.tensordot(self._apart, answers.passed, 1) / self._spacing
        harmonic = Wave(self._frequency[there], kappa, gas)
        conductance = np.real(1 / wave_impedance(harmonic, gas.density, gas.sound_speed))
        if is_specular:
            sums.free[:, points] = answers.blocked * answers.mobility[0]
            sums.onward[points] = answers.blocked * answers.passed[0]
            sums.sent[:, points], sums.incident[points] = sent, conductance
        else:
            sums.scattered[..., points] += conductance * sent[:, None].conj() * sent

    def _of_plates(self, which: IndexArray, k: RealArray) -> ComplexArray:
        """Return velocity over pressure of leaves as plates in empty space, shape (n_kinds, *k.shape)."""
        return np.asarray(1 / (self._rigidity[:, which] * k**4 + self._inertia[:, which]))

    def _of_plates_at_lines(self, which: IndexArray, across: RealArray, along: RealArray) -> ComplexArray:
        """Return the sum of `_of_plates` over all harmonics, divided by the spacing, of every leaf.

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
        return np.asarray(1j * omega / (2 * stiffness * square) * total)[self._kinds]

    def _of_plates_beyond(self, which: IndexArray) -> ComplexArray:
        """Return the sum of `_of_plates_at_lines` over all harmonics along the lines that are not summed.

        Far beyond the bending wavenumber that is ``i w / (4 D |r|^3)``; Euler and Maclaurin's sum from there on.
        """
        if self._fasteners is None:
            return np.zeros((len(self._kinds), len(which)), dtype=complex)
        cubes = (self._fasteners / (2 * np.pi)) ** 3 / (self._most_along + 0.5) ** 2
        return np.asarray(2j * np.pi * self._frequency[which] / (4 * self._stiffness[:, which]) * cubes)[self._kinds]


def _chosen(
    is_chosen: BoolArray, which: IndexArray, kappa: RealArray
) -> tuple[slice | IndexArray, IndexArray, RealArray]:
    """Return the places of what is chosen, a slice where that is all, with its frequencies and wavenumbers."""
    points: slice | IndexArray = slice(None) if np.all(is_chosen) else np.flatnonzero(is_chosen)
    return points, which[points], kappa[points]
