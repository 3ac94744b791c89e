"""Structural links between the leaves of a wall, studs and ties: what they carry from leaf to leaf.

A link pulls at both leaves with one force, ``F = (v1 - v2) / (Y1 + Y2 + i w C)``, v1 and v2 the motions of the leaves
without it, Y the mobilities of endless plates, C its compliance. The force drives the leaf behind along a line or at a
point, which radiates: near the link below its critical frequency, everywhere above.

B. H. Sharp, Noise Control Eng. 11 (1978) 53-63, has rigid links, J. L. Davy 1991 their compliance (T. E. Vigran,
Building Acoustics (2008), eqs. 8.26 and 8.27). Motions and radiation are theirs where leaves are limp and far above the
resonance of the cavity; here they are those of the stack itself, by its layers, at every frequency and angle.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from multilayer.arrays import ComplexArray, IndexArray, RealArray
from multilayer.errors import InputError
from multilayer.layers.base import Layer
from multilayer.layers.elastic_plate import ElasticPlate
from multilayer.layers.elastic_solid import ElasticSolid
from multilayer.matrix.faces import Faces
from multilayer.matrix.small import multiply
from multilayer.matrix.solve import HalfSpace, Solution, System
from multilayer.matrix.wave import Wave
from multilayer.media.validity import warn_outside
from multilayer.models import Model
from multilayer.response.chunks import in_chunks
from multilayer.response.diffuse_field import WeightingName, weighting_function
from multilayer.response.finite_size import Window, finite_transmission, radiation_at
from multilayer.response.quadrature import NODES, Tolerance, integrate
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack
from multilayer.units import Length, Unit

Mistake = tuple[tuple[str | int, ...], str, Any]
_EXACT = Tolerance(absorption=1.0, transmission=2e-3)
_PANELS = 64


class _Links(Model):
    """Links of one kind between two leaves."""

    name: str | None = None
    between: tuple[str | int, str | int]
    spacing: Length


class LineLinks(_Links):
    """Studs: lines along which two leaves are held together.

    Fields: `between` (a layer of each leaf), `spacing` of the lines (m), `compliance` (m2/N, of a piece of unit length:
    how far its two flanges give way under unit force per length; 0 of wood).
    """

    kind: Literal["line"] = "line"
    compliance: Annotated[float, Field(ge=0), Unit("m^2/N")] = 0.0


class PointLinks(_Links):
    """Ties: points at which two leaves are held together.

    Fields: `between` (a layer of each leaf), `spacing` (m, of a square grid), `compliance` (m/N, of each; 0 of a bolt).
    """

    kind: Literal["point"] = "point"
    compliance: Annotated[float, Field(ge=0), Unit("m/N")] = 0.0


Links = Annotated[LineLinks | PointLinks, Field(discriminator="kind")]


@dataclass(frozen=True)
class _Leaf:
    """Plates that lie upon each other, by the indices of the first and the last."""

    first: int
    last: int

    def of(self, stack: Stack) -> tuple[Layer, ...]:
        return stack.layers[self.first : self.last + 1]

    def mass_and_stiffness(self, stack: Stack, wave: Wave) -> tuple[RealArray, ComplexArray]:
        """Return mass per area, kg/m2, and bending stiffness, N m, of plates that slip on each other."""
        mass, stiffness = np.zeros(1), np.zeros(1, dtype=complex)
        for plate in self.of(stack):
            assert isinstance(plate, ElasticPlate | ElasticSolid)  # by validation
            mass = mass + plate.density * plate.thickness
            modulus = plate.complex_modulus(wave)
            stiffness = stiffness + modulus * plate.thickness**3 / (12 * (1 - plate.poisson_ratio**2))
        return mass, stiffness


def _leaf(stack: Stack, key: str | int) -> _Leaf:
    """Return the leaf to which a layer belongs.

    Raises
    ------
    InputError
        When there is no such layer, or it is no plate.
    """
    at = stack.index(key)
    first = last = at
    if isinstance(stack.layers[at], ElasticPlate):
        while first > 0 and isinstance(stack.layers[first - 1], ElasticPlate):
            first -= 1
        while last < len(stack.layers) - 1 and isinstance(stack.layers[last + 1], ElasticPlate):
            last += 1
    if not isinstance(stack.layers[at], ElasticPlate | ElasticSolid):
        kind = stack.layers[at].type
        raise InputError(f"links hold plates together, and {key} is '{kind}'; name an elastic_plate or elastic_solid")
    beside = [stack.layers[i] for i in (first - 1, last + 1) if 0 <= i < len(stack.layers)]
    if any(isinstance(layer, ElasticPlate | ElasticSolid) for layer in beside):
        raise InputError(
            f"{key} lies on a solid; a leaf with links is one elastic_solid, or any number of elastic_plate"
        )
    return _Leaf(first, last)


def _leaves(stack: Stack, links: _Links) -> tuple[_Leaf, _Leaf]:
    """Return the two leaves, from the sound on, that some links connect; raises InputError as `_leaf`."""
    front, back = sorted((_leaf(stack, key) for key in links.between), key=lambda leaf: leaf.first)
    if front == back:
        raise InputError("these are one leaf: links connect two, with a cavity between them")
    return front, back


def wrong_links(stack: Stack, links: Sequence[LineLinks | PointLinks]) -> Iterator[Mistake]:
    """Give path, text and value of what is wrong with the links of a stack."""
    held: dict[tuple[str, float], dict[_Leaf, set[_Leaf]]] = {}  # by lines, which leaves hang together
    for i, these in enumerate(links):
        try:
            front, back = _leaves(stack, these)
        except InputError as error:
            yield ("links", i, "between"), str(error), these.between
            continue
        together = held.setdefault((these.kind, these.spacing), {})
        one, other = (together.get(leaf, {leaf}) for leaf in (front, back))
        if one is other or front in other:
            text = "these leaves are held together already by links of this kind and spacing, that is on the same lines"
            yield ("links", i, "between"), f"{text}; leave these out, or give them another spacing", these.between
        together.update(dict.fromkeys(one | other, one | other))
    if links and stack.termination != "ambient":
        text = "links are computed of walls between two rooms; write 'termination: ambient'"
        yield ("links",), text, stack.termination
    if links and not stack.isotropic_in_plane:
        yield ("links",), "links are computed of stacks that are isotropic in their plane alone", None


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
    row = faces.family.index("v3")
    matrix = faces.back if behind else faces.front
    return np.asarray(multiply(matrix[row : row + 1], coefficients[:, None])[0, 0])


def _bridges(stack: Stack, links: Sequence[LineLinks | PointLinks], frequency: RealArray) -> list[_Bridge]:
    """Return the links of a stack at some frequencies; links of one kind and spacing lie on the same lines."""
    groups: dict[tuple[str, float], list[LineLinks | PointLinks]] = {}
    for these in links:
        groups.setdefault((these.kind, these.spacing), []).append(these)
    return [_bridge(stack, group, frequency) for group in groups.values()]


def _bridge(stack: Stack, links: Sequence[LineLinks | PointLinks], frequency: RealArray) -> _Bridge:
    gas, omega = stack.ambient.gas, 2 * np.pi * frequency
    wave = Wave(frequency, np.zeros_like(frequency), gas)
    pairs = [_leaves(stack, these) for these in links]
    mobility: dict[_Leaf, ComplexArray] = {}
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


def _radiated(stack: Stack, leaf: _Leaf, links: LineLinks | PointLinks, frequency: RealArray) -> RealArray:
    """Return the power that a force of 1 N (or N/m) on a leaf at each link radiates behind; see `_Bridge.radiated`.

    A line force has the same pressure in each wavenumber along x1, a point force in each of the plane: the layers from
    the leaf on make of it the pressure behind, p = T/(1 + R). By the angle a of the radiated wave, with b the spacing,

        line: k/(pi b) int |p|^2 cos^2 a da,    point: k^2/(2 pi b^2) int |p|^2 cos^2 a sin a da.
    """
    k = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    is_line = links.kind == "line"

    def integrand(which: IndexArray, angle: RealArray) -> RealArray:
        wave = Wave(frequency[which], k[which] * np.sin(angle), stack.ambient.gas)
        radiated = np.abs(_through(_system(stack, wave), leaf.first, stack, wave)) ** 2 * np.cos(angle) ** 2
        radiated *= 1.0 if is_line else np.sin(angle)
        nothing = np.zeros_like(angle)
        return np.array([np.ones_like(angle), nothing, radiated, nothing, nothing])

    rows, _ = integrate(integrand, len(frequency), np.pi / 2, _EXACT, _PANELS, 2)
    per_link = k / np.pi if is_line else k**2 / (2 * np.pi)
    return np.asarray(per_link / links.spacing ** (1 if is_line else 2) * rows[2])


def _through(system: System, first: int, stack: Stack, wave: Wave) -> ComplexArray:
    """Return the pressure behind the wall over that on the front of a layer, with nothing before it."""
    behind = replace(system, layers=system.layers[first:], contacts=("bonded", *system.contacts[first + 1 :]))
    solution = solve_or_explain(behind, stack, wave)
    assert solution.reflected is not None  # between half-spaces
    assert solution.transmitted is not None
    return np.asarray(solution.transmitted / (1 + solution.reflected))


def _system(stack: Stack, wave: Wave) -> System:
    gas = stack.ambient.gas
    return build_system(stack, wave, HalfSpace(wave_impedance(wave, gas.density, gas.sound_speed)))


def linked_transmission(
    stack: Stack,
    links: Sequence[LineLinks | PointLinks],
    frequency: RealArray,
    angle: float | None = None,
    *,
    max_angle: float = 78.0,
    weighting: WeightingName = "uniform",
    window: Window | None = None,
) -> RealArray:
    """Return the power that a stack with links between its leaves transmits, over the power that arrives.

    Parameters
    ----------
    stack : Stack
        Between half-spaces of its ambient gas, isotropic in its plane; its fields hold numbers. A leaf is an
        `elastic_solid`, or `elastic_plate` upon each other.
    links : sequence of LineLinks or PointLinks
        Those of one kind and spacing lie on the same lines or points, so that forces go through a leaf between them.
    frequency : array, shape (n_frequency,)
        Hz.
    angle : float, optional
        Of a plane wave, degrees; a diffuse field when left out.
    max_angle, weighting
        Of the diffuse field, as of `diffuse_field`.
    window : Window, optional
        Size of the wall; it corrects the wave that goes on as it came.

    Returns
    -------
    array, shape (n_frequency,)

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

    def compute(piece: RealArray) -> RealArray:
        bridges, gas = _bridges(stack, links, piece), stack.ambient.gas
        k = 2 * np.pi * piece / gas.sound_speed
        driven = {leaf for bridge in bridges for leaf in bridge.driven}
        upper = float(np.sin(np.deg2rad(max_angle if angle is None else angle)))
        radiation = None if window is None else radiation_at(window, k, float(np.max(k)) * upper, 3 * len(NODES))

        def tau(which: IndexArray, s: RealArray) -> RealArray:
            wave, cosine = Wave(piece[which], k[which] * np.sqrt(s), gas), np.sqrt(1 - s)
            system = _system(stack, wave)
            solution = solve_or_explain(system, stack, wave)
            assert solution.transmitted is not None  # by validation
            through = {leaf: _through(system, leaf, stack, wave) for leaf in driven}
            pressure, other = solution.transmitted, np.zeros(s.shape)
            for bridge in bridges:
                specular, pulled = bridge.carried(system, solution, which, through)
                radiated = np.sum(bridge.radiated[:, which] * np.abs(pulled) ** 2, axis=0) / cosine
                pressure = pressure + specular
                other += np.maximum(radiated - np.abs(specular) ** 2, 0.0)
            onward = np.abs(pressure) ** 2
            if radiation is not None:
                onward = finite_transmission(onward, radiation(which, wave.kx.real), cosine)
            return np.asarray(onward + other)

        everything = np.arange(len(piece))
        if angle is not None:
            return tau(everything, np.full(len(piece), upper**2))
        relative = weighting_function(weighting)

        def integrand(which: IndexArray, s: RealArray) -> RealArray:
            weight, nothing = relative(np.rad2deg(np.arcsin(np.sqrt(s)))), np.zeros_like(s)
            return np.array([weight, nothing, weight * tau(which, s), nothing, nothing])

        rows, _ = integrate(integrand, len(piece), upper**2, _EXACT, _PANELS)
        return np.asarray(rows[2] / rows[0])

    return np.concatenate(in_chunks(compute, stack, np.asarray(frequency, dtype=float), 2 * len(NODES)))
