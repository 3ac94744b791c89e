"""Reflection, transmission and surface impedance for a plane wave."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray, frequencies
from multilayer.frames import Frame, Tabular, over
from multilayer.matrix.solve import HalfSpace, Solution, System
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import in_chunks
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack


@dataclass(frozen=True, repr=False)
class PlaneWave(Tabular):
    """Response of a stack to a plane wave; arrays of shape ``(..., *frequency.shape, *angle.shape, *azimuth.shape)``.

    Attributes
    ----------
    frequency, angle, azimuth : array
        Hz and degrees, as asked.
    reflection : complex array
        Reflected over incident pressure at the front face.
    transmission : complex array or None
        Transmitted pressure at the back face over incident pressure at the front face; None without a half-space
        behind.
    surface_impedance : complex array
        Pressure over normal velocity at the front face, Pa s/m.
    absorption : array
        1 - abs(reflection)^2: what does not come back, be it dissipated or transmitted.
    transmission_loss : array or None
        dB, from the ratio of transmitted to incident power.
    """

    frequency: RealArray
    angle: RealArray
    reflection: ComplexArray
    transmission: ComplexArray | None
    surface_impedance: ComplexArray
    absorption: RealArray
    transmission_loss: RealArray | None
    azimuth: RealArray | float = 0.0

    @property
    def frame(self) -> Frame:
        """The response over (samples,) frequency and angle, and azimuth where it was asked for."""
        along: dict[str, RealArray] = {"frequency": self.frequency, "angle": self.angle}
        if np.ndim(self.azimuth) or self.azimuth != 0:
            along["azimuth"] = np.asarray(self.azimuth)
        names = [item.name for item in fields(self) if item.name not in ("frequency", "angle", "azimuth")]
        values = {name: getattr(self, name) for name in names}
        units = {"frequency": "Hz", "surface_impedance": "Pa s/m", "transmission_loss": "dB"}
        return over(along, values, units | dict.fromkeys(("angle", "azimuth"), "degree"))


def plane_wave(
    stack: Stack, frequency: ArrayLike, angle: ArrayLike = 0.0, workers: int = 1, *, azimuth: ArrayLike = 0.0
) -> PlaneWave:
    """Return the response of `stack` to plane waves arriving through its ambient gas.

    Parameters
    ----------
    stack : Stack
        Its fields may hold arrays (`Stack.replaced`) that broadcast against frequency and angle.
    frequency : array
        Hz, above 0.
    angle : array
        Degrees from the normal, from 0 to below 90. Every angle meets every frequency.
    workers : int
        Threads that share a long frequency axis.
    azimuth : array
        Degrees about the normal, added to the azimuths of layers that are not isotropic in their plane. Every azimuth
        meets every angle.

    Raises
    ------
    InputError
        For frequencies, angles or azimuths out of range.
    CouplingError
        When two neighbours cannot touch as the stack says.

    Notes
    -----
    Conventions of time exp(+i w t): a rigid wall has reflection +1, and the transmission holds no propagation phase
    through the stack's own thickness.
    """
    f = frequencies(frequency)
    n_directions = np.size(angle) * np.size(azimuth)
    parts = in_chunks(lambda piece: _plane_wave(stack, piece, angle, azimuth), stack, f, n_directions, workers)
    return parts[0] if len(parts) == 1 else joined(parts)


def joined(parts: Sequence[PlaneWave]) -> PlaneWave:
    """Return responses at consecutive pieces of the frequency axis as one."""
    names = [field.name for field in fields(PlaneWave) if field.name not in ("angle", "azimuth")]
    columns = {name: [getattr(part, name) for part in parts] for name in names}
    joined: dict[str, Any] = {
        name: None if values[0] is None else np.concatenate(values) for name, values in columns.items()
    }
    return PlaneWave(angle=parts[0].angle, azimuth=parts[0].azimuth, **joined)


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def _plane_wave(stack: Stack, frequency: RealArray, angle: ArrayLike, azimuth: ArrayLike) -> PlaneWave:
    wave = Wave.incident(frequency, angle, stack.ambient.gas, azimuth)
    system = build_system(stack, wave, HalfSpace(front_impedance(wave)))
    return plane_wave_of(system, solve_or_explain(system, stack, wave), wave, frequency, angle)


def plane_wave_of(system: System, solution: Solution, wave: Wave, frequency: RealArray, angle: ArrayLike) -> PlaneWave:
    """Return the response from the solution of a system in the field `wave`, that of `frequency` and `angle`."""
    front = front_impedance(wave)
    reflection, transmission = solution.reflected, solution.transmitted
    assert reflection is not None  # the head is a half-space
    loss = None
    if transmission is not None and isinstance(system.tail, HalfSpace):
        power = np.abs(transmission) ** 2 * np.real(1 / system.tail.impedance) / np.real(1 / front)
        with np.errstate(divide="ignore"):  # no power at all is an infinite loss, not a mistake
            loss = -10 * np.log10(power)
    return PlaneWave(
        frequency=frequency,
        angle=np.asarray(angle, dtype=float),
        reflection=reflection,
        transmission=transmission,
        surface_impedance=_surface_impedance(front, reflection),
        absorption=1 - np.abs(reflection) ** 2,
        transmission_loss=loss,
        azimuth=np.asarray(wave.azimuth, dtype=float),
    )


def front_impedance(wave: Wave) -> ComplexArray:
    """Return the wave impedance of the ambient gas, Pa s/m."""
    return wave_impedance(wave, wave.ambient.density, wave.ambient.sound_speed)


def _surface_impedance(front: ComplexArray, reflection: ComplexArray) -> ComplexArray:
    with np.errstate(divide="ignore", invalid="ignore"):  # a rigid surface has an infinite impedance
        return np.where(reflection == 1, np.inf, front * (1 + reflection) / (1 - reflection))
