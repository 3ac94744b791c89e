"""The field inside a stack, and where its power goes."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.layers.base import Layer
from multilayer.matrix.couplings import Contact
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import FLUID, POROELASTIC, Family
from multilayer.matrix.solve import HalfSpace, Solution, System, solve
from multilayer.matrix.wave import Wave
from multilayer.response.system import build_system, made_once, wave_impedance
from multilayer.stack import Stack


@dataclass(frozen=True)
class LayerState:
    """The state through one layer, for an incident pressure of 1 Pa at the front face of the stack.

    Attributes
    ----------
    layer : str
        Its name, or its index.
    components : tuple of str
        What the first axis of `values` holds: velocities in m/s (v1 along the layers, v3 into the stack; s the frame,
        f the pore fluid), stresses in Pa (for pores s33f = -porosity * pressure), pressure p in Pa.
    position : array, shape (n_points,)
        Distance from the front face of the stack, m.
    values : complex array, shape (n_components, n_points, ...)
        Trailing axes as in `PlaneWave.reflection`.
    """

    layer: str
    components: tuple[str, ...]
    position: RealArray
    values: ComplexArray

    def __getitem__(self, component: str) -> ComplexArray:
        return np.asarray(self.values[self.components.index(component)])


@dataclass(frozen=True)
class PowerBalance:
    """Where the incident power goes, as shares of it.

    Attributes
    ----------
    reflected, transmitted : array, shape (...)
        `transmitted` is zero without a half-space behind.
    dissipated : array, shape (n_layers, ...)
        In each layer.
    layers : tuple of str
        Names or indices of the layers.
    """

    reflected: RealArray
    transmitted: RealArray
    dissipated: RealArray
    layers: tuple[str, ...]

    @property
    def residual(self) -> RealArray:
        """What is missing from 1; rounding errors only."""
        return np.asarray(1 - self.reflected - self.transmitted - self.dissipated.sum(axis=0))


def fields(
    stack: Stack, frequency: ArrayLike, angle: ArrayLike = 0.0, points: int = 21, *, azimuth: ArrayLike = 0.0
) -> list[LayerState]:
    """Return velocities and stresses through the thickness of every layer.

    Parameters
    ----------
    stack : Stack
    frequency, angle, azimuth : array
        As for `plane_wave`.
    points : int
        Positions per layer, both faces included, at least 2. A layer that is no homogeneous slab (a thin plate, a
        screen) has its two faces only, both at the same place.

    Notes
    -----
    Each layer is solved as ``points - 1`` bonded slices: no exponential grows, however thick the layer.
    """
    wave = Wave.incident(frequency, angle, stack.ambient.gas, azimuth)
    slices = [layer.sliced(max(points, 2) - 1) for layer in stack.at_rest()]
    faces_of = made_once(wave)
    faces = [[faces_of(cut) for cut in cuts] for cuts in slices]
    contacts: list[Contact] = []
    for contact, cuts in zip(stack.interfaces, slices, strict=False):
        contacts += [contact, *(["bonded"] * (len(cuts) - 1))]  # type: ignore[list-item]
    contacts.append(stack.interfaces[-1])
    system = build_system(stack, wave, _incident(wave))
    solution = solve(replace(system, layers=[face for group in faces for face in group], contacts=contacts))
    return _collect(stack, slices, faces, solution)


def _incident(wave: Wave) -> HalfSpace:
    return HalfSpace(wave_impedance(wave, wave.ambient.density, wave.ambient.sound_speed))


def _collect(
    stack: Stack, slices: list[tuple[Layer, ...]], faces: list[list[Faces]], solution: Solution
) -> list[LayerState]:
    coefficients = iter(solution.layers)
    start, layer_states = 0.0, []
    for i, (cuts, group) in enumerate(zip(slices, faces, strict=True)):
        states, back = [], None
        for face in group:
            front, back = face_states(face, next(coefficients))
            states.append(front)
        assert back is not None
        inside = len(cuts) > 1 or cuts[0].composes
        depth = float(sum(np.max(getattr(cut, "thickness", 0.0)) for cut in cuts)) if inside else 0.0
        values = np.stack(np.broadcast_arrays(*states, back), axis=1)
        position = start + np.linspace(0, depth, len(cuts) + 1)
        layer_states.append(LayerState(stack.layers[i].name or str(i), group[0].family.components, position, values))
        start += depth
    return layer_states


def face_states(face: Faces, coefficients: ComplexArray) -> tuple[ComplexArray, ComplexArray]:
    """Return the states at the front and at the back of a layer, each of shape (n_state, ...)."""
    column = coefficients[:, None]
    return face.states.at_front(column)[:, 0], face.states.at_back(column)[:, 0]


def power_balance(
    stack: Stack, frequency: ArrayLike, angle: ArrayLike = 0.0, *, azimuth: ArrayLike = 0.0
) -> PowerBalance:
    """Return how the power of an incident plane wave divides into reflection, transmission and each layer's losses.

    Parameters
    ----------
    stack : Stack
    frequency, angle, azimuth : array
        As for `plane_wave`.

    Notes
    -----
    The loss of a layer is the difference of the normal power fluxes at its two faces, by the power pairs of its state
    family; contacts pass power on unchanged.
    """
    wave = Wave.incident(frequency, angle, stack.ambient.gas, azimuth)
    system = build_system(stack, wave, _incident(wave))
    solution = solve(system)
    assert isinstance(system.head, HalfSpace)
    incident = 0.5 * np.real(1 / np.asarray(system.head.impedance))
    lost = [lost_power(face, c) / incident for face, c in zip(system.layers, solution.layers, strict=True)]
    assert solution.reflected is not None
    return PowerBalance(
        reflected=np.abs(solution.reflected) ** 2,
        transmitted=np.asarray(_transmitted(system, solution) / incident),
        dissipated=np.stack(np.broadcast_arrays(*lost)),
        layers=tuple(layer.name or str(i) for i, layer in enumerate(stack.layers)),
    )


def _transmitted(system: System, solution: Solution) -> Any:
    if solution.transmitted is None or not isinstance(system.tail, HalfSpace):
        return 0.0
    return 0.5 * np.abs(solution.transmitted) ** 2 * np.real(1 / np.asarray(system.tail.impedance))


def normal_velocity(layer: Faces, state: ComplexArray) -> ComplexArray:
    """Return the volume velocity per area that a state carries through a face, m/s."""
    if layer.family is POROELASTIC:
        frame, pores = state[layer.family.index("v3s")], state[layer.family.index("v3f")]
        return np.asarray((1 - layer.porosity) * frame + layer.porosity * pores)
    return np.asarray(state[layer.family.index("v3")])


def normal_pressure(layer: Faces, state: ComplexArray) -> ComplexArray:
    """Return the pressure that balances a state at a face, Pa, of frame and pores together."""
    if layer.family is FLUID:
        return np.asarray(state[layer.family.index("p")])
    stresses = ("s33s", "s33f") if layer.family is POROELASTIC else ("s33",)
    return np.asarray(-sum(state[layer.family.index(stress)] for stress in stresses))


def lost_power(face: Faces, coefficients: ComplexArray) -> RealArray:
    """Return the power per area that a layer loses, W/m2: what comes in at its front less what leaves at its back."""
    front, back = face_states(face, coefficients)
    return power_flux(face.family, front) - power_flux(face.family, back)


def power_flux(family: Family, state: ComplexArray) -> RealArray:
    """Return the power per area that a state carries along axis 3, W/m2; `state` of shape (n_state, ...)."""
    pairs = (0.5 * sign * np.real(state[stress] * np.conj(state[v])) for v, stress, sign in family.power_pairs)
    return np.asarray(sum(pairs))
