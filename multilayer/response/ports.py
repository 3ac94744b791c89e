"""A stack as others see it from its faces: surface impedance, and admittance, impedance and transfer matrices.

At a face there is one pressure p and one normal velocity v. What touches it there is either

- a ``fluid``: p acts on frame and pores by their areas, v is the volume flow per area, and there is no shear; or
- a ``plate`` that is glued on and moves along axis 3 alone: p is minus the normal stress, frame and pores move with v,
  and nothing moves along the face.

The two make any layer, be it fluid, solid or poroelastic, a two-port between p and v, by the conditions of
`matrix.couplings` (Allard & Atalla 2009, eqs. (11.74), (11.76) and (11.78)). Nothing is left out: what is given at a
face leaves the other half of its state to the layers.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError, show
from multilayer.matrix.faces import mirrored
from multilayer.matrix.families import FLUID, SOLID, Family
from multilayer.matrix.solve import Port, System
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import in_chunks
from multilayer.response.system import build_system, refusal, solve_or_explain
from multilayer.stack import Stack

FaceKind: TypeAlias = Literal["fluid", "plate"]
Drive: TypeAlias = Literal["pressure", "velocity"]


@dataclass(frozen=True)
class _Face:
    """A medium at a face: p is ``sign`` times a component of its state; one more is held, and one answers to that."""

    family: Family
    pressure: str
    sign: int
    held: tuple[str, ...] = ()
    holding: tuple[str, ...] = ()

    def port(self, drive: Drive) -> Port:
        """Return the port at which pressure or velocity is given; the other one answers."""
        given, answer = (self.pressure, "v3") if drive == "pressure" else ("v3", self.pressure)
        index = self.family.index
        return Port(self.family, tuple(map(index, (given, *self.held))), tuple(map(index, (answer, *self.holding))))


_FACES: dict[FaceKind, _Face] = {
    "fluid": _Face(FLUID, "p", 1),
    "plate": _Face(SOLID, "s33", -1, held=("v1",), holding=("s13",)),
}
_LOST = 1e14  # of an impedance times an admittance: all digits are rounding
FACE_KINDS: tuple[FaceKind, ...] = tuple(_FACES)


def surface_impedance(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    trace_wavenumber: ArrayLike | None = None,
    face: FaceKind = "fluid",
) -> ComplexArray:
    """Return pressure over normal velocity at the front face of a stack, its termination behind it, Pa s/m.

    Parameters
    ----------
    stack : Stack
    frequency : array
        Hz.
    angle : array
        Degrees from the normal in the ambient gas, from 0 to below 90. Every angle meets every frequency.
    trace_wavenumber : array, optional
        Wavenumber along the faces in place of angles, rad/m, from 0; any, also beyond that of the gas.
    face : {'fluid', 'plate'}
        What touches the front face. Of a fluid this is the impedance of `plane_wave`.

    Returns
    -------
    complex array
        Of the shape of `frequency` followed by that of `angle` or `trace_wavenumber`; its real part is not below 0.

    Raises
    ------
    InputError
        For values out of range, or a stack without a finite response.
    CouplingError
        When a plate and the first layer, or two layers, cannot touch.
    """
    touching = _face(face)

    def solved(wave: Wave) -> ComplexArray:
        front, _ = _answers(stack, wave, build_system(stack, wave, touching.port("velocity")))
        return touching.sign * front

    return _everywhere(stack, frequency, angle, trace_wavenumber, solved)


def surface_admittance(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    trace_wavenumber: ArrayLike | None = None,
    face: FaceKind = "fluid",
) -> ComplexArray:
    """Return normal velocity over pressure at the front face of a stack, its termination behind it, m/(Pa s).

    The inverse of `surface_impedance`, computed by itself: 0 where the face cannot move.

    Parameters
    ----------
    stack, frequency, angle, trace_wavenumber, face
        As for `surface_impedance`.

    Returns
    -------
    complex array
        As of `surface_impedance`.

    Raises
    ------
    InputError, CouplingError
        As for `surface_impedance`.
    """
    touching = _face(face)

    def solved(wave: Wave) -> ComplexArray:
        front, _ = _answers(stack, wave, build_system(stack, wave, touching.port("pressure")))
        return touching.sign * front  # the pressure is `sign`: 1 over it is the same

    return _everywhere(stack, frequency, angle, trace_wavenumber, solved)


def admittance_matrix(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    trace_wavenumber: ArrayLike | None = None,
    faces: tuple[FaceKind, FaceKind] = ("fluid", "fluid"),
) -> ComplexArray:
    """Return Y of ``[v1; v2] = Y [p1; p2]`` between the two faces of a stack's layers, m/(Pa s).

    Both velocities point **into** the layers, so that Y is symmetric (reciprocity), and of passive layers its Hermitian
    part has no negative eigenvalue. The termination of the stack does not enter.

    Parameters
    ----------
    stack, frequency, angle, trace_wavenumber
        As for `surface_impedance`.
    faces : (str, str)
        What touches the front face (1) and the back face (2).

    Returns
    -------
    complex array, shape (..., 2, 2)

    Raises
    ------
    InputError, CouplingError
        As for `surface_impedance`. Layers without losses have no finite admittance at resonances of two free faces.
    """
    return _matrix(stack, frequency, angle, trace_wavenumber, faces, "pressure")


def impedance_matrix(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    trace_wavenumber: ArrayLike | None = None,
    faces: tuple[FaceKind, FaceKind] = ("fluid", "fluid"),
) -> ComplexArray:
    """Return Z of ``[p1; p2] = Z [v1; v2]`` between the two faces of a stack's layers, Pa s/m.

    The inverse of `admittance_matrix`, with the same signs, computed by itself.

    Parameters
    ----------
    stack, frequency, angle, trace_wavenumber, faces
        As for `admittance_matrix`.

    Returns
    -------
    complex array, shape (..., 2, 2)

    Raises
    ------
    InputError, CouplingError
        As for `surface_impedance`. Layers that keep their thickness, as a thin plate alone, have no such matrix.
    """
    where = (stack, frequency, angle, trace_wavenumber, faces)
    admittance, text = _matrix(*where, "pressure"), "layers that keep their thickness have no impedance matrix"
    try:
        impedance = _matrix(*where, "velocity")
    except InputError as error:
        raise InputError(f"{text}, but an admittance matrix and a transfer matrix ({error})") from None
    sizes = np.abs(impedance).max(axis=(-2, -1)) * np.abs(admittance).max(axis=(-2, -1))
    if np.any(sizes > _LOST):  # the rest of velocities that ought to be alike
        raise InputError(f"{text}, but an admittance matrix and a transfer matrix")
    return impedance


def transfer_matrix(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    *,
    trace_wavenumber: ArrayLike | None = None,
    faces: tuple[FaceKind, FaceKind] = ("fluid", "fluid"),
) -> ComplexArray:
    """Return T of ``[p1; v1] = T [p2; v2]`` from the back face (2) of a stack's layers to the front face (1).

    Both velocities point from the front to the back, as those of `Layer.transfer_matrix`; det T = 1 (reciprocity). T12
    is in Pa s/m, T21 in m/(Pa s).

    Parameters
    ----------
    stack, frequency, angle, trace_wavenumber, faces
        As for `admittance_matrix`.

    Returns
    -------
    complex array, shape (..., 2, 2)

    Raises
    ------
    InputError, CouplingError
        As for `surface_impedance`; also where nothing passes through the layers.
    """
    front, back = map(_face, faces)

    def solved(wave: Wave) -> ComplexArray:
        head = front.port("pressure")
        # the back face without pressure, then without velocity; at the front the pressure is `front.sign`
        v1, v2 = _answers(stack, wave, build_system(stack, wave, head, back.port("pressure")))
        v1_held, s2 = _answers(stack, wave, build_system(stack, wave, head, back.port("velocity")))
        p1, p2 = front.sign, back.sign * s2
        with np.errstate(all="ignore"):
            matrix = _by_rows([[p1 / p2, p1 / v2], [v1_held / p2, v1 / v2]])
        if not np.all(np.isfinite(matrix)):
            raise refusal(stack, "nothing passes through these layers; there is no transfer matrix, but an admittance")
        return matrix

    return _everywhere(stack, frequency, angle, trace_wavenumber, solved, (2, 2))


def _matrix(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike,
    trace_wavenumber: ArrayLike | None,
    faces: tuple[FaceKind, FaceKind],
    drive: Drive,
) -> ComplexArray:
    front, back = map(_face, faces)

    def solved(wave: Wave) -> ComplexArray:
        system = build_system(stack, wave, front.port(drive), back.port(drive))
        turned = System(
            back.port(drive), [mirrored(layer) for layer in reversed(system.layers)], front.port(drive),
            system.contacts[::-1],
        )  # fmt: skip
        # drives and answers one by one: behind a face velocities leave the layers, and enter them here
        first, second = (_answers(stack, wave, each) for each in (system, turned))
        if drive == "pressure":
            rows = [[front.sign * first[0], -back.sign * second[1]], [-front.sign * first[1], back.sign * second[0]]]
        else:
            rows = [[front.sign * first[0], front.sign * second[1]], [back.sign * first[1], back.sign * second[0]]]
        return _by_rows(rows)

    return _everywhere(stack, frequency, angle, trace_wavenumber, solved, (2, 2))


def _by_rows(rows: list[list[ComplexArray]]) -> ComplexArray:
    return np.stack([np.stack(np.broadcast_arrays(*row), axis=-1) for row in rows], axis=-2)


def _face(kind: str) -> _Face:
    if kind not in _FACES:
        raise InputError(f"a face that touches {show(kind)} is not known; allowed: {', '.join(_FACES)}")
    return _FACES[kind]


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def _answers(stack: Stack, wave: Wave, system: System) -> tuple[ComplexArray, ComplexArray]:
    """Return what answers at the front and, where there is a port, at the back."""
    solution = solve_or_explain(system, stack, wave)
    front, back = solution.reflected, solution.transmitted
    assert front is not None  # the head is a port
    if not np.all(np.isfinite(front)):
        raise refusal(
            stack, "what answers at the front face is not finite: nothing there gives way, or nothing resists"
        )
    return front, front if back is None else back


def _everywhere(
    stack: Stack,
    frequency: ArrayLike,
    angle: ArrayLike,
    trace_wavenumber: ArrayLike | None,
    solved: Callable[[Wave], ComplexArray],
    matrix: tuple[int, ...] = (),
) -> ComplexArray:
    """Return what a function gives in all waves, piece by piece of the frequency axis."""
    along = np.asarray(angle if trace_wavenumber is None else trace_wavenumber, dtype=float)

    def piece(part: RealArray) -> ComplexArray:
        wave = _wave(stack, part, along, is_angle=trace_wavenumber is None)
        values = solved(wave)
        samples = values.shape[: max(0, values.ndim - len(matrix) - part.ndim - along.ndim)]
        return np.broadcast_to(values, (*samples, *part.shape, *along.shape, *matrix))

    parts = in_chunks(piece, stack, np.asarray(frequency, dtype=float), along.size)
    return np.array(parts[0]) if len(parts) == 1 else np.concatenate(parts)


def _wave(stack: Stack, frequency: RealArray, along: RealArray, *, is_angle: bool) -> Wave:
    gas = stack.ambient.gas
    if is_angle:
        return Wave.incident(frequency, along, gas)
    if not np.all((along >= 0) & np.isfinite(along)):
        raise InputError("a trace wavenumber is negative or not finite; they are in rad/m, from 0")
    normal = Wave.incident(frequency, 0.0, gas)  # checks the frequencies
    f = normal.frequency.reshape(frequency.shape + (1,) * along.ndim)
    return Wave(f, np.broadcast_to(along, f.shape[: frequency.ndim] + along.shape), gas)
