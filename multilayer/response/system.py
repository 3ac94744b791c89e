"""From a stack to the system that the kernel solves."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.errors import InputError
from multilayer.matrix.couplings import CouplingError, couple
from multilayer.matrix.solve import HalfSpace, Solution, System, Void, Wall, solve
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root
from multilayer.stack import FluidHalfSpace, Stack


def build_system(stack: Stack, wave: Wave, head: HalfSpace | Wall) -> System:
    """Return the system of `stack` in the field `wave`, excited by `head`.

    Raises
    ------
    CouplingError
        When two neighbours cannot touch as the stack says, naming both.
    """
    layers = [layer.faces(wave) for layer in stack.at_rest(on_base=isinstance(head, Wall))]
    interfaces = stack.interfaces
    for i, (front, back) in enumerate(pairwise(layers), start=1):
        try:
            couple(front.family, back.family, interfaces[i])
        except CouplingError as error:
            first, second = (stack.layers[j].name or f"{j} ({stack.layers[j].type})" for j in (i - 1, i))
            raise CouplingError(f"layers {first} and {second}: {error}") from None
    return System(head, layers, _tail(stack, wave), interfaces)


def solve_or_explain(system: System) -> Solution:
    """Return the solution of `system`.

    Raises
    ------
    InputError
        When there is none that is finite.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        try:
            solution = solve(system)
        except np.linalg.LinAlgError:
            raise InputError(_NO_RESPONSE) from None
    if not all(np.all(np.isfinite(coefficients)) for coefficients in solution.layers):
        raise InputError(_NO_RESPONSE)
    return solution


_NO_RESPONSE = (
    "the stack has no finite response here: an undamped resonance lies at a frequency asked for, "
    "or nothing between the base and a rigid termination gives way"
)


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
