"""From a stack to the system that the kernel solves."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from multilayer.arrays import BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError, Problem
from multilayer.layers.base import LAYERS, Layer
from multilayer.matrix.couplings import CouplingError, couple, slips_anyway
from multilayer.matrix.faces import Faces
from multilayer.matrix.families import FLUID, Family
from multilayer.matrix.solve import HalfSpace, Port, Solution, System, Void, Wall, solve
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root
from multilayer.paths import extremes
from multilayer.stack import FluidHalfSpace, Stack

_PLAIN = (str, bool, int, float, complex, type(None))


def build_system(stack: Stack, wave: Wave, head: HalfSpace | Wall | Port, tail: Port | None = None) -> System:
    """Return the system of `stack` in the field `wave`, excited by `head`.

    Parameters
    ----------
    stack : Stack
    wave : Wave
    head : HalfSpace, Wall or Port
    tail : Port, optional
        In place of the stack's termination. A fluid there bears no shear, whatever the contact with a termination.

    Raises
    ------
    CouplingError
        When two neighbours cannot touch as the stack says, naming both.
    InputError
        When the numbers of a layer overflow, or divide by nothing.
    """
    layers: list[Faces] = []
    faces_of = made_once(wave)
    for i, layer in enumerate(stack.at_rest(on_base=isinstance(head, Wall))):
        try:
            layers.append(faces_of(layer))
        except (ArithmeticError, np.linalg.LinAlgError) as error:  # of single numbers; arrays become inf or nan
            if not has_extremes(stack):  # then its formulae are wrong, perhaps a plugin's
                raise
            text = f"layer {layer.name or i} cannot be computed: its numbers are too large or too small ({error})"
            raise refusal(stack, text) from None
    interfaces = stack.interfaces
    for i, (front, back) in enumerate(pairwise(layers), start=1):
        try:
            couple(front.family, back.family, interfaces[i])
            if interfaces[i] == "slip":
                _refuse_slip_of_fluid(stack.layers[i - 1 : i + 1], (front.family, back.family))
        except CouplingError as error:
            raise CouplingError(f"layers {_label(stack, i - 1)} and {_label(stack, i)}: {error}") from None
    if tail is None:
        end = _tail(stack, wave)
        if isinstance(end, HalfSpace) and interfaces[-1] == "slip":
            last = _label(stack, len(layers) - 1)
            raise CouplingError(f"layer {last} and the termination: {slips_anyway(layers[-1].family, FLUID)}")
        return System(head, layers, end, interfaces)
    return System(head, layers, tail, (*interfaces[:-1], "bonded") if tail.family == FLUID else interfaces)


def _label(stack: Stack, i: int) -> str:
    return stack.layers[i].name or f"{i} ({stack.layers[i].type})"


def _refuse_slip_of_fluid(layers: Sequence[Layer], families: tuple[Family, Family]) -> None:
    """Refuse to put a fluid, or a sheet with pores, on the frame of a poroelastic layer: these do not press on it."""
    if any(family == FLUID and not layer.lies_on_frames for layer, family in zip(layers, families, strict=True)):
        raise CouplingError(slips_anyway(*families))


def made_once(wave: Wave) -> Callable[[Layer], Faces]:
    """Return a function that gives the face matrices of layers, the same ones for layers that are alike.

    Layers must live as long as the function does.
    """
    made: dict[Any, Faces] = {}
    shape = np.broadcast_shapes(*map(np.shape, (wave.frequency, wave.kx, wave.azimuth, wave.ambient.impedance)))

    def faces(layer: Layer) -> Faces:
        key = _all_but_name(layer)
        if key not in made:
            made[key] = _faces(layer, wave, shape)
        return made[key]

    return faces


def _faces(layer: Layer, wave: Wave, shape: tuple[int, ...]) -> Faces:
    """Return the face matrices of a layer, whose type may be a plugin's, for waves of a shape."""
    faces: object = layer.faces(wave)
    if not isinstance(faces, Faces):
        what = f"what its 'faces' returns is of type {type(faces).__name__}"
        raise _at_fault(layer, f"{what}, and must be multilayer.matrix.faces.Faces")
    try:
        faces = faces.computed
        misshapen = _misshapen(layer, faces, shape)
    except np.linalg.LinAlgError:
        raise
    except ValueError as error:  # arrays that do not go together: those of its fields may be at fault
        if (room := _room(layer, shape)) is None:
            raise
        misshapen = f"arrays of its 'faces' do not go together ({error}), and must broadcast to {room}"
    if misshapen:
        raise _at_fault(layer, misshapen)
    return faces


def _at_fault(layer: Layer, text: str) -> InputError:
    """Return the error of a layer whose type does something wrong."""
    name = f"layer {layer.name}: " if layer.name else ""
    return InputError(f"{name}layer type '{layer.type}' of {_origin(layer)} is at fault, not the stack: {text}")


def _origin(layer: Layer) -> str:
    return " and ".join(LAYERS.origins(layer.type)) or type(layer).__qualname__


def _misshapen(layer: Layer, faces: Faces, shape: tuple[int, ...]) -> str:
    """Return what is wrong with the shapes of a layer's face matrices; empty where nothing is."""
    n, states = faces.family.size, faces.states
    expected = {"front": (states.front, (n, n)), "back": (states.back, (n, n)), "decay": (states.decay, (n // 2, 1))}
    shapes = []
    for name, (array, size) in expected.items():
        if array is None:
            continue
        if not isinstance(array, np.ndarray) or array.shape[:2] != size:
            what = f"of shape {array.shape}" if isinstance(array, np.ndarray) else f"of type {type(array).__name__}"
            return (
                f"the matrix '{name}' of its 'faces' is {what}, and must be an array of shape {(*size, *shape)}: "
                f"{size} of the family '{faces.family.name}', then frequencies and angles"
            )
        shapes.append(array.shape[2:])
    if all(given == shape for given in shapes):
        return ""
    given = np.broadcast_shapes(shape, *shapes)
    room = _room(layer, shape)
    if room is None or np.broadcast_shapes(given, room) == room:
        return ""
    return f"matrices of its 'faces' have the shape {given} over frequencies and angles, and must have {room}"


def _room(layer: Layer, shape: tuple[int, ...]) -> tuple[int, ...] | None:
    """Return the shape of waves and of a layer's fields together; None where that is unknown, or these do not fit."""
    fields = [value for value in vars(layer).values() if not isinstance(value, _PLAIN)]
    if layer.__pydantic_private__ or not all(isinstance(value, np.ndarray) for value in fields):
        return None
    try:
        return np.broadcast_shapes(shape, *(np.shape(value) for value in fields))
    except ValueError:
        return None


def _all_but_name(layer: Layer) -> tuple[Any, ...]:
    """Return what tells a layer's response from that of others: plain fields by value, all else by identity."""
    fields = (value for name, value in vars(layer).items() if name != "name")
    plain = (value if isinstance(value, _PLAIN) else id(value) for value in fields)
    return type(layer), *plain, id(layer) if layer.__pydantic_private__ else None


def behind_gas(stack: Stack, wave: Wave) -> System:
    """Return the system of `stack` behind a half-space of the gas' impedance at normal incidence.

    That impedance is real at every trace wavenumber: it drives evanescent waves, and those that decay along the stack.
    """
    return build_system(stack, wave, HalfSpace(wave.ambient.impedance))


def between_gas(stack: Stack, wave: Wave) -> System:
    """Return the system of `stack` behind a half-space of its ambient gas, from which the wave arrives."""
    gas = wave.ambient
    return build_system(stack, wave, HalfSpace(wave_impedance(wave, gas.density, gas.sound_speed)))


def solve_or_explain(system: System, stack: Stack, wave: Wave) -> Solution:
    """Return the solution of `system`, that of `stack` in the field `wave`.

    Raises
    ------
    InputError
        When there is none that is finite, with the first such frequency, and the layer if its matrices are not.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        try:
            solution = solve(system)
        except np.linalg.LinAlgError:
            raise refusal(stack, _no_response(stack, system)) from None
    refuse_infinite(solution, stack, wave, system)
    return solution


def refuse_infinite(solution: Solution, stack: Stack, wave: Wave, system: System) -> None:
    """Refuse a solution that is not finite everywhere.

    Raises
    ------
    InputError
        With the first such frequency, and the layer if its matrices are not.
    """
    for coefficients in solution.layers:
        if not np.all(finite := np.isfinite(coefficients)):
            raise refusal(stack, _no_response(stack, system), _first(wave.frequency, ~np.all(finite, axis=0)))


def _no_response(stack: Stack, system: System) -> str:
    """Return why there is no response: a layer whose face matrices are not finite, if there is such a one."""
    text = "the stack has no finite response here:"
    is_whole = len(system.layers) == len(stack.layers)  # others are a part of the stack
    for i, faces in enumerate(system.layers if is_whole else ()):
        if not all(np.all(np.isfinite(matrix)) for matrix in faces.states.matrices()):
            layer = stack.layers[i]
            what = f"layer {layer.name or i} gives numbers that are not finite; its values are too large or too small"
            return f"{text} {what}, or the formulae of its type '{layer.type}' ({_origin(layer)}) are wrong"
    return (
        f"{text} an undamped resonance lies at a frequency asked for, or nothing between the base and a rigid "
        "termination gives way"
    )


def _first(frequency: RealArray, wrong: BoolArray) -> float:
    """Return the frequency, Hz, of the first point that is wrong."""
    return float(np.broadcast_to(frequency, np.broadcast_shapes(wrong.shape, frequency.shape))[wrong].ravel()[0])


_EXTREME = 5.0  # decades from what is usual


def has_extremes(stack: Stack) -> bool:
    """Tell whether a stack holds numbers that are far from what is usual."""
    return any(decades >= _EXTREME for _, _, decades in extremes(stack)[:1])


def refusal(stack: Stack, text: str, frequency: float | None = None) -> InputError:
    """Return the error of a stack that cannot be computed, placed at its most extreme field if some are extreme.

    Parameters
    ----------
    stack : Stack
    text : str
        What is wrong.
    frequency : float, optional
        Hz, where it is.
    """
    if frequency is not None:
        text = f"{text} (at {frequency:.6g} Hz)"
    if not has_extremes(stack):
        return InputError(text)
    path, shown, _ = extremes(stack)[0]
    return InputError(Problem(f"{text}; the most extreme value is {shown}: is it meant?", path))


def _tail(stack: Stack, wave: Wave) -> HalfSpace | Wall | Void:
    match stack.termination:
        case "rigid":
            return Wall()
        case "free":
            return Void()
        case "ambient":
            return HalfSpace(wave_impedance(wave, wave.ambient.density, wave.ambient.sound_speed))
        case FluidHalfSpace() as fluid:
            density = wave.ambient.density if fluid.density is None else fluid.density
            speed = wave.ambient.sound_speed if fluid.sound_speed is None else fluid.sound_speed
            return HalfSpace(wave_impedance(wave, density, speed))
    raise AssertionError(stack.termination)


def wave_impedance(wave: Wave, density: float, sound_speed: float) -> ComplexArray:
    """Return omega rho / k3, Pa s/m, of a fluid half-space; k3 decays away from the stack beyond grazing."""
    k3 = decaying_root((wave.omega / sound_speed) ** 2 - wave.kx**2)
    return np.asarray(wave.omega * density / k3)
