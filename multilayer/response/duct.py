"""The least attenuated mode of a rectangular duct that is lined by a stack."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray
from multilayer.errors import InputError
from multilayer.frames import Frame, Tabular, over
from multilayer.matrix.solve import solve
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import decaying_root
from multilayer.response.chunks import frequency_axis, has_arrays, in_chunks
from multilayer.response.fields import face_states, normal_pressure, normal_velocity
from multilayer.response.system import behind_gas
from multilayer.stack import Stack
from multilayer.units import DB_PER_NEPER

Lined = Literal["one side", "both sides"]

# where Newton's method starts: products of k3 and the height, and wavenumbers along the duct over that of free air
_ACROSS = (np.arange(9)[:, None] * np.pi / 2 - 1j * np.array([0.0, 0.6, 1.5])).ravel()
_ALONG = (np.geomspace(0.5, 4, 10)[:, None] * (1 - 1j * np.array([0.02, 0.1, 0.3, 0.7]))).ravel()
_ROUNDS = 40
_LONGEST = 0.5  # step, over the wavenumber
_ALIKE = 1e-7  # wavenumbers of two rounds; two modes that meet are known to the root of rounding
_FIRST, _ROUNDING = 1e-4, 1e-14  # first and last step, over the wavenumber


@dataclass(frozen=True, repr=False)
class DuctMode(Tabular):
    """The least attenuated mode of a lined duct; arrays of shape ``(n_frequency,)``.

    Attributes
    ----------
    frequency : array
        Hz.
    wavenumber : complex array
        Along the duct, rad/m; the imaginary part is negative or 0, the mode decays along its way.
    attenuation : array
        dB/m.
    phase_speed : array
        m/s.
    """

    frequency: RealArray
    wavenumber: ComplexArray
    attenuation: RealArray
    phase_speed: RealArray

    @property
    def frame(self) -> Frame:
        """The mode over frequency."""
        values = {name: getattr(self, name) for name in ("wavenumber", "attenuation", "phase_speed")}
        units = {"frequency": "Hz", "wavenumber": "rad/m", "attenuation": "dB/m", "phase_speed": "m/s"}
        return over({"frequency": self.frequency}, values, units)


def duct_mode(
    stack: Stack, frequency: ArrayLike, height: float, lined: Lined = "both sides", mach: float = 0.0
) -> DuctMode:
    """Return the least attenuated mode of a rectangular duct whose lining is a stack.

    Parameters
    ----------
    stack : Stack
        The lining on a rigid wall, its first layer at the airway; isotropic in its plane, without arrays in its fields.
    frequency : array, shape (n_frequency,) or ()
        Hz.
    height : float
        Of the airway across the lining, m: between lining and rigid wall, or between two linings.
    lined : str
        ``one side``, or ``both sides``, which are alike and face each other. The other two walls are rigid.
    mach : float
        Of a uniform flow in the airway, above -1 and below 1; above 0 where sound goes with the flow.

    Raises
    ------
    InputError
        For arrays in the stack, a layer that is not isotropic in its plane, a stack that does not end at a rigid wall,
        a height or Mach number out of range, and at frequencies so high or low that no mode is found.

    Notes
    -----
    The wave runs along in the lining's layers, too (bulk reaction): its impedance Z = p / v3 is taken at the complex
    wavenumber kx along the duct. With h the height, or half of it where both sides are lined,

        ``k3 h tan(k3 h) = i k0 h (rho c / Z) (1 - M kx / k0)^2``,  ``k3^2 = (k0 - M kx)^2 - kx^2``

    (M. L. Munjal, Acoustics of Ducts and Mufflers, 2nd ed. 2014, chapter 6; with flow, pressure and displacement are
    continuous at the lining, after Ingard and Myers). Of all kx below the real axis it is that nearest to it: what is
    left at some distance, whatever the source. A short lining, or one in which several modes decay alike, takes away
    other amounts; so do its ends. The secant method finds it from 67 starts at every frequency. Pressure and velocity
    of the face are those for unit pressure at the wall: of fluids they are entire functions of kx, without poles that
    lead searches astray. Where airway or lining are many wavelengths deep, a mode that decays little more may be taken
    for it.
    """
    f = _checked(stack, frequency, height, mach)
    if lined not in ("one side", "both sides"):
        raise InputError(f"a duct is lined on 'one side' or on 'both sides', not {lined!r}")
    h = height if lined == "one side" else height / 2
    parts = in_chunks(lambda piece: _wavenumbers(stack, piece, h, mach), stack, f, len(_ACROSS) + len(_ALONG))
    k = np.concatenate(parts)
    return DuctMode(f, k, -DB_PER_NEPER * k.imag, 2 * np.pi * f / k.real)


def unfit_lining(stack: Stack) -> str:
    """Return why a stack cannot line a duct; empty where it can."""
    if not stack.isotropic_in_plane:
        return "a duct is computed with linings that are isotropic in their plane alone"
    if stack.termination != "rigid":
        return "the lining of a duct ends at a wall that keeps sound in: write 'termination: rigid'"
    return ""


def _checked(stack: Stack, frequency: ArrayLike, height: float, mach: float) -> RealArray:
    if has_arrays(stack):
        raise InputError("a duct takes one stack at a time; its fields must hold numbers, no arrays")
    if lack := unfit_lining(stack):
        raise InputError(lack)
    if not (np.isfinite(height) and height > 0):
        raise InputError(f"the height of a duct must be above 0 m, not {height:g}")
    if not -1 < mach < 1:
        raise InputError(f"the Mach number of the flow in a duct lies between -1 and 1, not at {mach:g}")
    return frequency_axis(frequency)


@np.errstate(all="ignore")  # searches that run away are dropped
def _wavenumbers(stack: Stack, frequency: RealArray, h: float, mach: float) -> ComplexArray:
    """Return the wavenumbers of the least attenuated modes, shape (n_frequency,)."""
    free = 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    across = _ACROSS[:, None] * np.maximum(1, free * h / np.max(_ACROSS.real))  # over all modes that are cut on
    root = decaying_root(1 - (1 - mach**2) * (across / (free * h)) ** 2)
    along = np.broadcast_to(_ALONG[:, None], (len(_ALONG), len(free)))
    last: ComplexArray = np.concatenate([(root - mach) / (1 - mach**2), along])  # wavenumbers over that of free air
    x: ComplexArray = last * (1 + _FIRST)
    before = _mismatch(stack, frequency, last, h, mach)
    for _ in range(_ROUNDS):
        here = _mismatch(stack, frequency, x, h, mach)
        step = -here * (x - last) / (here - before)
        step = np.where(here == 0, 0, step) * np.minimum(1, _LONGEST * np.abs(x) / np.abs(step))
        found = np.abs(step) < _ALIKE * np.abs(x)
        moves = np.isfinite(step) & (np.abs(step) > _ROUNDING * np.abs(x))
        last, before, x = np.where(moves, x, last), np.where(moves, here, before), np.where(moves, x + step, x)
        if not np.any(moves):
            break
    x = np.where(np.abs(x.imag) < _ALIKE * np.abs(x), x.real, x)
    if mach == 0:  # what runs one way runs the other way, too
        x = np.where((x.imag > 0) | ((x.imag == 0) & (x.real < 0)), -x, x)
    onward = (x.imag < 0) | ((x.imag == 0) & (x.real > 0))
    decay = np.where(found & onward, -x.imag, np.inf)
    least = np.take_along_axis(x, np.argmin(decay, axis=0)[None], axis=0)[0]
    if not np.all(there := np.isfinite(np.min(decay, axis=0))):
        raise InputError(f"no mode of the duct was found at {frequency[~there][0]:.6g} Hz")
    return np.asarray(free * least)


def _mismatch(stack: Stack, frequency: RealArray, x: ComplexArray, h: float, mach: float) -> ComplexArray:
    """Return what is zero of a mode, by its wavenumber over that of free air; even in that across the airway."""
    gas = stack.ambient.gas
    free = 2 * np.pi * frequency / gas.sound_speed
    wave = Wave(frequency, np.where(np.isfinite(x), x, 1.0) * free, gas)
    system = behind_gas(stack, wave)
    layers = solve(system).layers
    front, back = face_states(system.layers[0], layers[0])[0], face_states(system.layers[-1], layers[-1])[1]
    at_back = normal_pressure(system.layers[-1], back)
    pressure = normal_pressure(system.layers[0], front) / gas.impedance / at_back
    velocity = normal_velocity(system.layers[0], front) / at_back
    carried = 1 - mach * x
    turn = free * h * np.sqrt(carried**2 - x**2)
    return np.asarray(turn * np.sin(turn) * pressure - 1j * free * h * carried**2 * np.cos(turn) * velocity)
