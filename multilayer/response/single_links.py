"""Links that do not know of each other: what studs and ties carry from leaf to leaf, each by itself.

A link pulls at both leaves with one force, ``F = (v1 - v2) / (Y1 + Y2 + i w C)``, v1 and v2 the motions of the leaves
without it, Y the mobilities of endless plates, C its compliance. The force drives the leaf behind along a line or at a
point, which radiates: near the link below its critical frequency, everywhere above.

B. H. Sharp, Noise Control Eng. 11 (1978) 53-63, has rigid links, J. L. Davy 1991 their compliance (T. E. Vigran,
Building Acoustics (2008), eqs. 8.26 and 8.27). Motions and radiation are theirs where leaves are limp and far above the
resonance of the cavity; here they are those of the stack itself, by its layers, at every frequency and angle.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.matrix.faces import Faces
from multilayer.matrix.solve import Solution, System
from multilayer.matrix.wave import Wave
from multilayer.media.validity import warn_outside
from multilayer.response.links import Leaf, LineLinks, PointLinks, leaves
from multilayer.response.quadrature import LINKED, LINKED_PANELS, integrate
from multilayer.response.system import between_gas, solve_or_explain
from multilayer.stack import Stack


class SingleLinks:
    """What goes through a stack with links, each taken as if it were alone.

    Parameters
    ----------
    stack : Stack
    links : sequence of LineLinks or PointLinks
        Those of one kind and spacing lie on the same lines or points.
    frequency : array, shape (n_frequency,)
        Hz.

    Warns
    -----
    ValidityWarning
        When the spacing is below half a bending wavelength of a leaf.

    Notes
    -----
    The links' forces, spread evenly, send on a wave in the direction of the one that arrives, which adds to the
    airborne one by pressure. What else they radiate goes into other directions and adds by power: all that single links
    radiate, less that wave. A leaf is taken as endless: waves that run along it from link to link count as lost.
    """

    def __init__(self, stack: Stack, links: Sequence[LineLinks | PointLinks], frequency: RealArray) -> None:
        self._stack, self._frequency = stack, frequency
        self._bridges = _bridges(stack, links, frequency)

    def through(self, which: IndexArray, wave: Wave) -> tuple[RealArray, RealArray, RealArray]:
        """Return the power that goes on as it came, that into other directions, and the first without links.

        Of a plane wave of power 1.

        Parameters
        ----------
        which : array of int
            Frequencies, by their indices.
        wave : Wave
            Of these frequencies, below grazing.
        """
        stack = self._stack
        system = between_gas(stack, wave)
        solution = solve_or_explain(system, stack, wave)
        assert solution.transmitted is not None  # by validation
        driven = {leaf for bridge in self._bridges for leaf in bridge.driven}
        through = {leaf: _through(system, leaf, stack, wave) for leaf in driven}
        k = wave.omega / wave.ambient.sound_speed
        cosine = np.sqrt(1 - (wave.kx.real / k) ** 2)
        pressure, other = solution.transmitted, np.zeros(cosine.shape)
        for bridge in self._bridges:
            specular, pulled = bridge.carried(system, solution, which, through)
            radiated = np.sum(bridge.radiated[:, which] * np.abs(pulled) ** 2, axis=0) / cosine
            pressure = pressure + specular
            other += np.maximum(radiated - np.abs(specular) ** 2, 0.0)
        return np.asarray(np.abs(pressure) ** 2), other, np.abs(solution.transmitted) ** 2


def line_mobility(mass: RealArray, stiffness: ComplexArray, omega: RealArray) -> ComplexArray:
    """Return velocity over force per length of an endless plate driven along a line, m2/(N s).

    ``(1 - i) w / (4 D k^3)``, k^4 = m w^2 / D: L. Cremer, M. Heckl & B. A. T. Petersson, Structure-Borne Sound (2005).

    Parameters
    ----------
    mass : array
        kg/m2.
    stiffness : complex array
        N m.
    omega : array
        rad/s.
    """
    wavenumber = (mass * omega**2 / stiffness) ** 0.25
    return np.asarray((1 - 1j) * omega / (4 * stiffness * wavenumber**3))


def point_mobility(mass: RealArray, stiffness: ComplexArray, omega: RealArray) -> ComplexArray:
    """Return velocity over force of an endless plate driven at a point, m/(N s): ``1 / (8 sqrt(D m))``."""
    return np.asarray(1 / (8 * np.sqrt(stiffness * mass)) + 0 * omega)


@dataclass(frozen=True)
class _Bridge:
    """Links on the same lines or points, at some frequencies; those that share a leaf pull at it together.

    Attributes
    ----------
    ends : tuple of (int, int)
        Of each link, the layers whose facing sides it holds.
    impedances : complex array, shape (n_frequency, n_links, n_links)
        Forces from the motions that the links hinder.
    pulls : array, shape (n_driven, n_links)
        Which forces add up on each leaf behind a link.
    radiated : array, shape (n_driven, n_frequency)
        Power behind the wall, per area, over that of a wave of 1 Pa at right angles, for a force of 1 N (or N/m).
    driven : tuple of int
        First layers of the leaves behind a link.
    density : float
        Lines per length (1/m), or points per area (1/m2).
    """

    ends: tuple[tuple[int, int], ...]
    impedances: ComplexArray
    pulls: RealArray
    radiated: RealArray
    driven: tuple[int, ...]
    density: float

    def carried(
        self, system: System, solution: Solution, which: IndexArray, through: Mapping[int, ComplexArray]
    ) -> tuple[ComplexArray, ComplexArray]:
        """Return what the links do to a wave that arrives with 1 Pa.

        Parameters
        ----------
        system, solution
            The layers without links.
        which : array of int
            Frequencies of the points that were solved.
        through : mapping
            Pressure behind over pressure on a leaf, in the wave's own direction, by the leaf's first layer.

        Returns
        -------
        specular : complex array
            Pressure behind of the links' forces spread over the wall: the wave that they send on as it came, Pa.
        pulled : complex array, shape (n_driven, ...)
            Force on each leaf behind a link, N or N/m.
        """
        hindered = np.array([
            _normal(system.layers[front], solution.layers[front], behind=True)
            - _normal(system.layers[back], solution.layers[back], behind=False)
            for front, back in self.ends
        ])  # fmt: skip
        forces = np.einsum("...ij,j...->i...", self.impedances[which], hindered)
        pulled = np.asarray(np.einsum("ki,i...->k...", self.pulls, forces))
        sent = [self.density * through[leaf] * force for leaf, force in zip(self.driven, pulled, strict=True)]
        return np.asarray(np.sum(sent, axis=0)), pulled


def _normal(faces: Faces, coefficients: ComplexArray, *, behind: bool) -> ComplexArray:
    """Return v3 at a face of a layer, m/s."""
    at = faces.states.at_back if behind else faces.states.at_front
    return np.asarray(at(coefficients[:, None])[faces.family.index("v3"), 0])


def _bridges(stack: Stack, links: Sequence[LineLinks | PointLinks], frequency: RealArray) -> list[_Bridge]:
    """Return the links of a stack at some frequencies; links of one kind and spacing lie on the same lines."""
    groups: dict[tuple[str, float], list[LineLinks | PointLinks]] = {}
    for these in links:
        groups.setdefault((these.kind, these.spacing), []).append(these)
    return [_bridge(stack, group, frequency) for group in groups.values()]


def _bridge(stack: Stack, links: Sequence[LineLinks | PointLinks], frequency: RealArray) -> _Bridge:
    gas, omega = stack.ambient.gas, 2 * np.pi * frequency
    wave = Wave(frequency, np.zeros_like(frequency), gas)
    pairs = [leaves(stack, these) for these in links]
    mobility: dict[Leaf, ComplexArray] = {}
    for leaf in {leaf for pair in pairs for leaf in pair}:
        mass, stiffness = leaf.mass_and_stiffness(stack, wave)
        of_kind = line_mobility if links[0].kind == "line" else point_mobility
        mobility[leaf] = np.broadcast_to(of_kind(mass, stiffness, omega), omega.shape)
        wavelength = 2 * np.pi * (np.abs(stiffness) / (mass * omega**2)) ** 0.25
        waves = np.broadcast_to(links[0].spacing / wavelength, omega.shape)
        warn_outside("the theory of links", "spacing / bending wavelength of a leaf", waves, 0.5, np.inf, frequency)
    n = len(links)
    hindering = np.zeros((len(frequency), n, n), dtype=complex)
    for i, (front, back) in enumerate(pairs):
        hindering[:, i, i] += 1j * omega * links[i].compliance
        for j, other in enumerate(pairs):
            for leaf, sign in ((front, 1), (back, -1)):
                for other_leaf, other_sign in zip(other, (1, -1), strict=True):
                    if leaf == other_leaf:
                        hindering[:, i, j] += sign * other_sign * mobility[leaf]
    driven = list(dict.fromkeys(back for _, back in pairs))
    pulls = np.array([[float(back == leaf) - float(front == leaf) for front, back in pairs] for leaf in driven])
    radiated = np.array([_radiated(stack, leaf, links[0], frequency) for leaf in driven])
    ends = tuple((front.last, back.first) for front, back in pairs)
    density = 1 / links[0].spacing ** (1 if links[0].kind == "line" else 2)
    return _Bridge(
        ends, np.linalg.inv(hindering).astype(complex), pulls, radiated, tuple(leaf.first for leaf in driven), density
    )


def _radiated(stack: Stack, leaf: Leaf, links: LineLinks | PointLinks, frequency: RealArray) -> RealArray:
    """Return the power that a force of 1 N (or N/m) on a leaf at each link radiates behind; see `_Bridge.radiated`.

    A line force has the same pressure in each wavenumber along x1, a point force in each of the plane: the layers from
    the leaf on make of it the pressure behind, p = T/(1 + R). By the angle a of the radiated wave, with b the spacing,

        line: k/(pi b) int |p|^2 cos^2 a da,    point: k^2/(2 pi b^2) int |p|^2 cos^2 a sin a da.
    """
    k = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    is_line = links.kind == "line"

    def integrand(which: IndexArray, angle: RealArray) -> RealArray:
        wave = Wave(frequency[which], k[which] * np.sin(angle), stack.ambient.gas)
        radiated = np.abs(_through(between_gas(stack, wave), leaf.first, stack, wave)) ** 2 * np.cos(angle) ** 2
        radiated *= 1.0 if is_line else np.sin(angle)
        nothing = np.zeros_like(angle)
        return np.array([np.ones_like(angle), nothing, radiated, nothing, nothing])

    rows, _ = integrate(integrand, len(frequency), np.pi / 2, LINKED, LINKED_PANELS, 2)
    per_link = k / np.pi if is_line else k**2 / (2 * np.pi)
    return np.asarray(per_link / links.spacing ** (1 if is_line else 2) * rows[2])


def _through(system: System, first: int, stack: Stack, wave: Wave) -> ComplexArray:
    """Return the pressure behind the wall over that on the front of a layer, with nothing before it."""
    behind = replace(system, layers=system.layers[first:], contacts=("bonded", *system.contacts[first + 1 :]))
    solution = solve_or_explain(behind, stack, wave)
    assert solution.reflected is not None  # between half-spaces
    assert solution.transmitted is not None
    return np.asarray(solution.transmitted / (1 + solution.reflected))
