"""The strongest free wave along a stack, and the thin plate that has the same one."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.chebyshev import chebder, chebpts1, chebval, chebvander

from multilayer.arrays import ArrayLike, BoolArray, ComplexArray, RealArray
from multilayer.errors import InputError, ValidityWarning
from multilayer.frames import Frame, Tabular, over
from multilayer.layers.base import Layer
from multilayer.layers.patches import Patches
from multilayer.matrix.solve import Solution, System
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import frequency_axis, has_arrays, in_chunks
from multilayer.response.fields import face_states, lost_power, normal_pressure, normal_velocity
from multilayer.response.system import behind_gas, solve_or_explain
from multilayer.stack import FluidHalfSpace, Stack

_SLOWEST, _FASTEST = 1e3, 1e-2  # wavenumbers looked at, over that of sound in the ambient gas
_PER_DECADE = 60  # of them
_DEGREE = 8
_REACH, _LEAST_REACH = 0.12, 0.01  # of the real axis on either side of a wavenumber, as a share of it
_BEYOND = 2.0  # reaches that a series is good for
_ROUGH = 1e-4
_FINER = 25  # wavenumbers between two of the grid
_ROUNDS = 8
_NEWTON = 30
_STEP = 1e-4  # of the frequency, for the group speed
_SLOW = np.array(0.1)  # Hz, at which a layer moves as one mass


@dataclass(frozen=True, repr=False)
class FreeWaves(Tabular):
    """The strongest free wave of a stack without its gas; arrays of shape ``(n_frequency,)``.

    NaN where there is none: where it decays within a few of its lengths, as about the resonance of a plate on a foam,
    or where two waves are too close to be told apart.

    Attributes
    ----------
    frequency : array
        Hz.
    wavenumber : complex array
        Along the layers, rad/m; the imaginary part is negative, the wave decays along its way.
    phase_speed, group_speed : array
        m/s.
    mass : float
        Of all layers, kg/m2; of a layer whose frame does not move, that of the gas in its room.
    bending_stiffness : array
        N m, of the thin plate of this mass that has a free wave of the same length.
    loss_factor : array
        Of the wave: the power that is lost over w times its energy, which the group speed carries.
    layer_loss_factors : array, shape (n_layers, n_frequency)
        What each layer adds to the loss factor.
    layers : tuple of str
        Their names, or indices.
    """

    frequency: RealArray
    wavenumber: ComplexArray
    phase_speed: RealArray
    group_speed: RealArray
    mass: float
    bending_stiffness: RealArray
    loss_factor: RealArray
    layer_loss_factors: RealArray
    layers: tuple[str, ...]

    @property
    def frame(self) -> Frame:
        """The wave over frequency."""
        names = ("wavenumber", "phase_speed", "group_speed", "bending_stiffness", "loss_factor")
        values = {name: getattr(self, name) for name in names}
        units = {"frequency": "Hz", "wavenumber": "rad/m", "bending_stiffness": "N m"}
        units |= {"phase_speed": "m/s", "group_speed": "m/s"}
        return over({"frequency": self.frequency}, values, units, {"mass": self.mass})


def free_waves(stack: Stack, frequency: ArrayLike) -> FreeWaves:
    """Return the strongest wave that runs along a stack by itself, and the plate that is equivalent to the stack.

    Half-spaces in front and behind are left out; a rigid wall behind stays.

    Parameters
    ----------
    stack : Stack
        Without arrays in its fields, isotropic in its plane.
    frequency : array, shape (n_frequency,) or ()
        Hz.

    Raises
    ------
    InputError
        For arrays in the stack or a layer that is not isotropic in its plane; where no wave runs along the stack at any
        of the frequencies.

    Notes
    -----
    A free wave is a zero of the stack's impedance Z(k), pressure over normal velocity of its front face. Of all
    wavenumbers at which the reactance turns from that of a mass to that of a stiffness, that of the largest residue of
    k/Z is taken: the wave that takes most of the power of a force on the front face. Of a plate it is the bending wave,
    of a thick one Lamb's A0. The impedance is an analytic function of k but for its poles; from
    values on the real axis about the zero, a polynomial continues it to the complex zero.

    Equivalent plate: ``D = w^2 m / Re(k)^4``. Loss factor: ``-2 Im(k) c_g / w``, c_g the group speed Re(dw/dk); of a
    thin plate it is that of its modulus. It is divided among the layers by the power that each loses, as
    `response.power_balance` has it, when a pressure of this wavenumber drives the stack.
    """
    if has_arrays(stack):
        raise InputError("free waves take one stack at a time; its fields must hold numbers, no arrays")
    if not stack.isotropic_in_plane:
        raise InputError("free waves of a stack that is not isotropic in its plane differ by direction; take it apart")
    f = frequency_axis(frequency)
    bare = _without_gas(stack)
    parts = in_chunks(lambda piece: _waves(bare, piece), stack, f, len(_grid()))
    k, group, shares = (np.concatenate(part, axis=-1) for part in zip(*parts, strict=True))
    if not np.any(np.isfinite(k)):
        text = "no wave runs along the stack by itself, or it decays within a few of its lengths"
        raise InputError(f"{text}, at any of the frequencies")
    omega = 2 * np.pi * f
    mass = sum(_mass(layer, stack) for layer in stack.layers)
    loss = -2 * k.imag * group / omega
    return FreeWaves(
        frequency=f,
        wavenumber=k,
        phase_speed=omega / k.real,
        group_speed=group,
        mass=mass,
        bending_stiffness=omega**2 * mass / k.real**4,
        loss_factor=loss,
        layer_loss_factors=shares * loss,
        layers=tuple(layer.name or str(i) for i, layer in enumerate(stack.layers)),
    )


def _without_gas(stack: Stack) -> Stack:
    if stack.termination == "ambient" or isinstance(stack.termination, FluidHalfSpace):
        return stack.model_copy(update={"termination": "free"})
    return stack


def _mass(layer: Layer, stack: Stack) -> float:
    """Return the mass of a layer of a stack, kg/m2: as its fields tell it, of the gas where it holds nothing else."""
    if isinstance(layer, Patches):
        return sum(patch.share * sum(_mass(inner, stack) for inner in patch.layers) for patch in layer.patches)
    mass: Any = layer.mass_per_area
    if layer.stands_still:
        mass = mass or stack.ambient.gas.density * layer.depth
    elif mass is None:
        alone = stack.model_copy(update={"layers": (layer,), "contacts": (), "termination": "free"})
        mass = _unwarned_impedance(alone, _SLOW, np.array(0.0)).imag / (2 * np.pi * _SLOW)
    return float(mass)


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def _waves(stack: Stack, frequency: RealArray) -> tuple[ComplexArray, RealArray, RealArray]:
    """Return wavenumbers, group speeds and the layers' shares in the losses."""
    start = _strongest(stack, frequency)
    k, group = (np.full(len(frequency), np.nan, dtype=kind) for kind in (complex, float))
    shares = np.full((len(stack.layers), len(frequency)), np.nan)
    if np.any(there := np.isfinite(start)):
        k[there], group[there] = _zero(stack, frequency[there], start[there])
    if np.any(there := np.isfinite(k)):
        shares[:, there] = _shares_of_layers(stack, frequency[there], k[there].real)
    return k, group, shares


def _impedance(stack: Stack, frequency: RealArray, k: RealArray) -> ComplexArray:
    """Return pressure over normal velocity of the front face."""
    system, solution = _driven(stack, frequency, k)
    front = face_states(system.layers[0], solution.layers[0])[0]
    return np.asarray(normal_pressure(system.layers[0], front) / normal_velocity(system.layers[0], front))


def _unwarned_impedance(stack: Stack, frequency: RealArray, k: RealArray) -> ComplexArray:
    """Return the impedance at frequencies that nobody asked for: whether models hold there matters to nobody."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ValidityWarning)
        return _impedance(stack, frequency, k)


def _driven(stack: Stack, frequency: RealArray, k: RealArray) -> tuple[System, Solution]:
    """Solve the stack behind a half-space that drives it at any wavenumber."""
    wave = Wave(np.asarray(frequency), k, stack.ambient.gas)
    system = behind_gas(stack, wave)
    return system, solve_or_explain(system, stack, wave)


def _grid() -> RealArray:
    """Return the wavenumbers that are looked at, over that of sound."""
    return np.asarray(np.geomspace(_FASTEST, _SLOWEST, round(_PER_DECADE * np.log10(_SLOWEST / _FASTEST))))


def _strongest(stack: Stack, frequency: RealArray) -> RealArray:
    """Return the real wavenumbers of the waves that take the most power of a force on the front face; NaN for none."""
    k = _grid()[:, None] * 2 * np.pi * frequency / stack.ambient.gas.sound_speed
    reactance = _impedance(stack, frequency, k).imag
    there = np.any(_turns(reactance), axis=0)
    for _ in range(2):  # waves may lie close beside each other
        low, high = _strongest_turn(k, reactance)
        k = low + (high - low) * np.linspace(0, 1, _FINER)[:, None]
        reactance = _impedance(stack, frequency, k).imag
    low, high = _strongest_turn(k, reactance)
    return np.where(there, 0.5 * (low + high), np.nan)


def _turns(reactance: RealArray) -> BoolArray:
    return np.asarray((reactance[:-1] > 0) & (reactance[1:] <= 0))


def _strongest_turn(k: RealArray, reactance: RealArray) -> tuple[RealArray, RealArray]:
    """Return the two neighbours along the first axis between which the reactance turns, and that least steeply.

    The power of a point force that a wave takes is the residue of k/Z at its wavenumber.
    """
    middle, slope = 0.5 * (k[:-1] + k[1:]), np.diff(reactance, axis=0) / np.diff(k, axis=0)
    residue = np.where(_turns(reactance), middle / np.abs(slope), -1.0)
    which, each = np.argmax(residue, axis=0), np.arange(k.shape[-1])
    return k[which, each], k[which + 1, each]


def _zero(stack: Stack, frequency: RealArray, start: RealArray) -> tuple[ComplexArray, RealArray]:
    """Return the complex zeros of the impedance near real wavenumbers, and the group speeds there.

    On each round a Chebyshev series through values about the last zero's real part is solved by Newton's method. Where
    its last coefficients tell of a pole nearby, the next one is shorter.
    """
    x = chebpts1(_DEGREE + 1)
    fit = np.linalg.inv(chebvander(x, _DEGREE))
    zero, reach = start.astype(complex), np.full(len(start), _REACH)
    for _ in range(_ROUNDS):
        centre, span = zero.real, reach * zero.real
        nodes = centre + span * x[:, None]
        series = fit @ _impedance(stack, frequency, nodes)
        slope = chebder(series)
        t = np.zeros(len(centre), dtype=complex)
        for _ in range(_NEWTON):
            step = chebval(t, series, tensor=False) / chebval(t, slope, tensor=False)
            t -= step / np.maximum(1, np.abs(step))  # no leaps
        zero = centre + span * t
        rough = np.max(np.abs(series[-2:]), axis=0) > _ROUGH * np.max(np.abs(series), axis=0)
        wanted = np.clip(3 * np.abs(zero.imag / zero.real), _LEAST_REACH, _REACH)
        reach = np.where(rough, reach / 4, np.minimum(wanted, reach))
    above, below = (fit @ _unwarned_impedance(stack, frequency * (1 + sign * _STEP), nodes) for sign in (1, -1))
    by_frequency = chebval(t, above - below, tensor=False) / (4 * np.pi * frequency * _STEP)
    group = np.real(-chebval(t, slope, tensor=False) / span / by_frequency)
    good = ~rough & (np.abs(t) < _BEYOND) & (np.abs(step) < _ROUGH) & (group > 0)
    return np.where(good, zero, np.nan), np.where(good, group, np.nan)


def _shares_of_layers(stack: Stack, frequency: RealArray, k: RealArray) -> RealArray:
    """Return the shares of the layers in the losses, shape (n_layers, n_frequency); zeros where nothing is lost."""
    system, solution = _driven(stack, frequency, k)
    lost = [lost_power(face, c) for face, c in zip(system.layers, solution.layers, strict=True)]
    each = np.stack(np.broadcast_arrays(*lost, frequency)[:-1])
    whole = each.sum(axis=0)
    return np.asarray(np.divide(each, whole, out=np.zeros_like(each), where=whole > 0))
