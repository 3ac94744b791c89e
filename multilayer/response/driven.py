"""Response of a stack to a pressure on its front face of any spectrum of wavenumbers, above grazing included."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, fields
from functools import cached_property
from itertools import pairwise

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, IndexArray, RealArray, frequencies
from multilayer.errors import InputError, ValidityWarning
from multilayer.frames import Frame, Tabular, over
from multilayer.matrix.solve import HalfSpace
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import has_arrays, in_chunks
from multilayer.response.excitations import Excitation, PointForce
from multilayer.response.fields import face_states, normal_velocity
from multilayer.response.finite_size import Window, half_space_behind, radiation_at
from multilayer.response.quadrature import NODES, integrate_rows
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack

_DECADES = 6  # of wavenumbers above grazing
_FIRST_AZIMUTHS, _MOST_AZIMUTHS = 16, 256  # of a whole turn
_MUCH_SLOWER, _MUCH_SHORTER = 2.0, 60.0  # waves than sound; rad across a panel
_USELESS = 0.1  # an error of this share is no result
# rows of the integrals: what S drives, then the mobility
_FRONT, _BACK, _RADIATED, _RADIATED_IN_FRONT, _INPUT, _REACTIVE = range(6)
_ROWS = 6


@dataclass(frozen=True)
class Transfer:
    """Response to a blocked pressure of 1 Pa on the front face, of one wavenumber; arrays of the shape of the wave.

    Attributes
    ----------
    front, back : complex array
        Normal velocities of the two faces, m/(s Pa).
    radiation_in_front, radiation : array
        Radiation resistances of the half-spaces in front and behind, Pa s/m: 0 for waves slower than sound, and
        behind a stack without a half-space.
    """

    front: ComplexArray
    back: ComplexArray
    radiation_in_front: RealArray
    radiation: RealArray


def transfer(stack: Stack, wave: Wave) -> Transfer:
    """Return how a stack answers a blocked pressure of 1 Pa on its front face.

    Parameters
    ----------
    stack : Stack
    wave : Wave
        Of any trace wavenumber but those of grazing waves.

    Notes
    -----
    A wave of pressure p that arrives through the gas in front is a blocked pressure of 2 p, in which the gas then loads
    the face by its own wave impedance; that holds for evanescent waves, of an imaginary impedance, alike. So the gas in
    front is always part of the answer.
    """
    front = wave_impedance(wave, wave.ambient.density, wave.ambient.sound_speed)
    system = build_system(stack, wave, HalfSpace(front))
    solution = solve_or_explain(system, stack, wave)
    # velocities of the layers: in front of a stiff one the two waves in the gas cancel to the last digits
    first, last = system.layers[0], system.layers[-1]
    radiation: RealArray = np.zeros(1)
    if isinstance(system.tail, HalfSpace):
        radiation = np.real(np.asarray(system.tail.impedance))
    return Transfer(
        normal_velocity(first, face_states(first, solution.layers[0])[0]) / 2,
        normal_velocity(last, face_states(last, solution.layers[-1])[1]) / 2,
        np.real(front),
        radiation,
    )


@dataclass(frozen=True, repr=False)
class Driven(Tabular):
    """Response of a stack to an excitation; arrays of shape ``(*frequency.shape)``, power spectral densities one-sided.

    Of an excitation that covers the face, all is per square metre; of one at a point, it is integrated over the whole
    infinite face.

    Attributes
    ----------
    frequency : array
        Hz, as asked.
    radiated_power : array or None
        Into the half-space behind, W/Hz or W/(m2 Hz); None without one.
    radiated_in_front : array
        Into the ambient gas in front, W/Hz or W/(m2 Hz).
    input_power : array
        That the excitation gives to stack and gas, W/Hz or W/(m2 Hz).
    front_velocity, back_velocity : array
        Mean squared normal velocities of the faces, (m/s)2/Hz; integrated over the face, m2 (m/s)2/Hz, at a point.
    radiation_efficiency : array or None
        `radiated_power` over that of a piston of the velocity of the back face; None without a half-space behind.
    input_mobility : complex array or None
        Mean velocity of the excited disc over the force, m/(N s); None of an excitation that covers the face.
    error : array
        Estimated error of the integrals, as a share of each.
    """

    frequency: RealArray
    radiated_power: RealArray | None
    radiated_in_front: RealArray
    input_power: RealArray
    front_velocity: RealArray
    back_velocity: RealArray
    radiation_efficiency: RealArray | None
    input_mobility: ComplexArray | None
    error: RealArray

    @property
    def frame(self) -> Frame:
        """The response over frequency."""
        values = {item.name: getattr(self, item.name) for item in fields(self) if item.name != "frequency"}
        return over({"frequency": self.frequency}, values, {"frequency": "Hz", "input_mobility": "m/(N s)"})


def driven(
    stack: Stack,
    frequency: ArrayLike,
    excitation: Excitation,
    *,
    window: Window | None = None,
    tolerance: float = 1e-3,
    max_panels: int = 200,
    workers: int = 1,
) -> Driven:
    """Return the response of an infinite stack to a pressure on its front face.

    Parameters
    ----------
    stack : Stack
        Without arrays in its fields, with losses.
    frequency : array, shape (n_frequency,) or ()
        Hz.
    excitation : Excitation
        See `response.excitations`.
    window : Window, optional
        Size of the panel in its baffle, at whose edges waves slower than sound radiate; infinite when left out. Only
        the radiation behind feels it: the motion is that of the infinite stack.
    tolerance : float
        Largest estimated error of every integral, as a share of it.
    max_panels : int
        Panels of 15 wavenumbers at most, in each interval.
    workers : int
        Threads.

    Raises
    ------
    InputError
        For arrays in the stack; where a force at a point moves the face without bound; where free waves without losses
        leave the integrals without a value.

    Warns
    -----
    ValidityWarning
        When some frequency does not reach the tolerance.

    Notes
    -----
    With the transfer function Y(k) of a blocked pressure (`transfer`) and the spectrum S(k) of the excitation,
    ``velocity = int abs(Y)^2 S dk``, ``power = int Re(Z) abs(Y)^2 S dk`` and ``mobility = int Y S dk / S(0)``
    over the plane of wavenumbers, divided by (2 pi)^2; the mobility is that of a unit force on the disc of the
    excitation. Intervals end where waves graze, in front and behind, and at peaks of the spectrum; in each, ``k = a +
    (b - a) sin^2(pi x/2)`` takes away the roots at its ends. Decades of wavenumbers are added until they add no more.
    Panels are halved as those of a diffuse field. Where a layer is not isotropic in its plane, the azimuths of a whole
    turn are doubled in number until the mean over them stays.

    With a window, Re(Z) behind is that of a wave of wavenumber k within a rectangle (`radiation_impedance`; M. Villot,
    C. Guigou & L. Gagliardini, J. Sound Vib. 245 (2001) 433-455): the finite panel has as much energy as the infinite
    stack, and radiates by it. Waves much slower than sound and much shorter than the panel are taken to radiate by its
    edges alone, as ``2 (a + b) k0^2/(pi a b (k^2 - k0^2)^(3/2))``, the part of that integral that does not oscillate.

    The excitation acts as a pressure does: on a poroelastic front by area on frame and pores, and it moves a fluid.
    """
    if has_arrays(stack):
        raise InputError("a prescribed excitation takes one stack at a time; its fields must hold numbers, no arrays")
    f = frequencies(frequency)

    def compute(piece: RealArray) -> tuple[RealArray, RealArray]:
        integrals = _Wavenumbers(stack, np.atleast_1d(piece), excitation, window, tolerance, max_panels)
        return integrals.over_plane()

    parts = in_chunks(compute, stack, f, 8 * len(NODES), workers)
    rows = np.concatenate([part for part, _ in parts], axis=1).reshape(_ROWS, *f.shape)
    error = np.concatenate([part for _, part in parts]).reshape(f.shape)
    if np.any(error > tolerance):
        text = f"{np.count_nonzero(error > tolerance)} of {error.size} frequencies, worst error {np.max(error):.1g}"
        warnings.warn(f"prescribed excitation: {text} of the integrals over wavenumbers", ValidityWarning, stacklevel=2)
    return _as_driven(stack, f, excitation, rows, error)


def input_mobility(stack: Stack, frequency: ArrayLike, radius: float | None = None) -> ComplexArray:
    """Return the velocity of a disc of the front face over a force spread evenly over it, m/(N s).

    Parameters
    ----------
    stack : Stack
    frequency : array, shape (n_frequency,) or ()
        Hz.
    radius : float, optional
        m; a point when left out, which only faces that bend as thin plates bear.

    Raises
    ------
    InputError
        As `driven`.
    """
    mobility = driven(stack, frequency, PointForce(radius=radius)).input_mobility
    assert mobility is not None
    return mobility


def _as_driven(stack: Stack, frequency: RealArray, excitation: Excitation, rows: RealArray, error: RealArray) -> Driven:
    mobility = None
    if not excitation.per_area:
        # per squared force, as the mobility of a linear front is
        at_rest = excitation.spectrum(frequency, np.zeros_like(frequency), stack.ambient.gas)
        mobility = (rows[_INPUT] + 1j * rows[_REACTIVE]) / at_rest
        rows = rows * excitation.softened(frequency, mobility)
    behind = half_space_behind(stack)
    return Driven(
        frequency,
        None if behind is None else rows[_RADIATED],
        rows[_RADIATED_IN_FRONT],
        rows[_INPUT],
        rows[_FRONT],
        rows[_BACK],
        None if behind is None else rows[_RADIATED] / (behind[0] * behind[1] * rows[_BACK]),
        mobility,
        error,
    )


class _FiniteRadiation:
    """Radiation resistance of a rectangle that waves of any wavenumber move, Pa s/m.

    Attributes
    ----------
    largest : float
        Wavenumber beyond which waves are taken to radiate by the edges alone, rad/m.
    """

    def __init__(self, window: Window, sound: RealArray, impedance: float) -> None:
        self._window, self._sound, self._impedance = window, sound, impedance
        self.largest = max(_MUCH_SLOWER * float(np.max(sound)), _MUCH_SHORTER / min(window.width, window.height))
        self._near = radiation_at(window, sound, self.largest, 20 * len(NODES))

    def resistance(self, which: IndexArray, k: RealArray) -> RealArray:
        """Return the resistance for indices of frequencies and wavenumbers, two arrays of one shape."""
        efficiency = np.empty(k.shape)
        near = k <= self.largest
        if np.any(near):
            efficiency[near] = self._near(which[near], k[near]).real
        sound, far = self._sound[which[~near]], k[~near]
        edges = 2 * (self._window.width + self._window.height) / (np.pi * self._window.area)
        efficiency[~near] = edges * sound**2 / (far**2 - sound**2) ** 1.5
        return self._impedance * np.maximum(efficiency, 0.0)  # 0 but for rounding


@dataclass(frozen=True)
class _Wavenumbers:
    """Integrals over the plane of wavenumbers, all frequencies side by side."""

    stack: Stack
    frequency: RealArray
    excitation: Excitation
    window: Window | None
    tolerance: float
    max_panels: int

    @cached_property
    def _radiation(self) -> _FiniteRadiation | None:
        """The radiation behind a panel of finite size; None for an infinite one, or without a half-space behind."""
        behind = half_space_behind(self.stack)
        if self.window is None or behind is None:
            return None
        density, speed = behind
        return _FiniteRadiation(self.window, 2 * np.pi * self.frequency / speed, density * speed)

    def over_plane(self) -> tuple[RealArray, RealArray]:
        """Return the integrals, shape (6, n_frequency), and their errors as shares, shape (n_frequency,)."""
        n = len(self.frequency)
        if self.stack.isotropic_in_plane:
            rows, sizes, errors = self._over_wavenumbers(np.arange(n), None)
            return rows, self._shares(sizes, errors)
        azimuths = np.arange(_FIRST_AZIMUTHS) * 360.0 / _FIRST_AZIMUTHS
        rows, sizes, errors = self._means(azimuths)
        while len(azimuths) < _MOST_AZIMUTHS:
            between = azimuths + 180.0 / len(azimuths)
            more = self._means(between)
            change = np.abs(more[0] - rows) / 2
            rows, sizes, errors = ((old + new) / 2 for old, new in zip((rows, sizes, errors), more, strict=True))
            azimuths = np.sort(np.concatenate([azimuths, between]))
            if np.all(change <= self.tolerance * sizes):
                break
        return rows, self._shares(sizes, errors + change)

    def _means(self, azimuths: RealArray) -> tuple[RealArray, RealArray, RealArray]:
        n = len(self.frequency)
        which = np.repeat(np.arange(n), len(azimuths))
        parts = self._over_wavenumbers(which, np.tile(azimuths, n))
        rows, sizes, errors = (np.mean(part.reshape(_ROWS, n, -1), axis=-1) for part in parts)
        return rows, sizes, errors

    def _shares(self, sizes: RealArray, errors: RealArray) -> RealArray:
        share = np.max(np.divide(errors, sizes, out=np.zeros_like(errors), where=sizes > 0), axis=0)
        if not np.all(share <= _USELESS):
            worst = float(self.frequency[np.argmax(share)])
            text = f"the integral over wavenumbers has no value at {worst:.6g} Hz: free waves of the stack have no "
            raise InputError(text + "losses (give its layers a loss_factor), or its front cannot move at all")
        return np.asarray(share)

    def _over_wavenumbers(self, which: IndexArray, azimuth: RealArray | None) -> tuple[RealArray, RealArray, RealArray]:
        """Return integrals over the wavenumber, their sizes and errors, for frequencies by their indices."""
        totals = np.zeros((3, _ROWS, len(which)))
        ends = self._ends(self.frequency[which])
        first_decade, going = len(ends) - 1 - _DECADES, np.arange(len(which))
        for number, (low, high) in enumerate(pairwise(ends)):
            there = going[high[going] > low[going]]  # breaks may coincide
            direction = None if azimuth is None else azimuth[there]
            parts = self._interval(which[there], direction, low[there], high[there], totals[1][:, there])
            totals[:, :, there] += parts
            if number >= first_decade:
                going = there[np.any(parts[1] > 0.1 * self.tolerance * totals[1][:, there], axis=0)]
            if not len(going):
                return totals[0], totals[1], totals[2]
        text = f"a force moves this front face without bound (at {self.frequency[which[going[0]]]:.6g} Hz); "
        text += "give the force the radius of the disc that it acts on, and begin with a plate or a solid: a fluid, "
        text += "that in pores, too, gives way to the edge of any disc"
        raise InputError(text)

    def _ends(self, frequency: RealArray) -> list[RealArray]:
        """Return the ends of intervals of wavenumbers, each of the shape of `frequency`: breaks, and then decades."""
        gas, behind = self.stack.ambient.gas, half_space_behind(self.stack)
        speeds = [gas.sound_speed, *([behind[1]] if behind else [])]
        breaks = [2 * np.pi * frequency / speed for speed in speeds] + self.excitation.breaks(frequency)
        if self._radiation is not None:
            breaks.append(np.full_like(frequency, self._radiation.largest))
        inner = np.sort(np.stack([np.zeros_like(frequency), *breaks]), axis=0)
        return [*inner, *(inner[-1] * 10.0 ** (decade + 1) for decade in range(_DECADES))]

    def _interval(
        self, which: IndexArray, azimuth: RealArray | None, low: RealArray, high: RealArray, floor: RealArray
    ) -> RealArray:
        def integrand(items: IndexArray, x: RealArray) -> RealArray:
            span = (high - low)[items][:, None]
            k = low[items][:, None] + span * np.sin(0.5 * np.pi * x) ** 2
            stretch = span * 0.5 * np.pi * np.sin(np.pi * x)
            frequency = np.broadcast_to(self.frequency[which[items]][:, None], x.shape)
            direction = None if azimuth is None else np.broadcast_to(azimuth[items][:, None], x.shape)
            rows = self._densities(frequency, k, direction)
            if self._radiation is not None:
                index = np.broadcast_to(which[items][:, None], x.shape)
                rows[_RADIATED] = rows[_BACK] * self._radiation.resistance(index, k)
            return np.asarray(rows * (stretch * k / (2 * np.pi)))

        # errors of the intervals add up
        parts = integrate_rows(integrand, np.arange(len(which)), floor, self.tolerance / 4, self.max_panels)
        return np.asarray(np.stack(parts))

    @np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
    def _densities(self, frequency: RealArray, k: RealArray, azimuth: RealArray | None) -> RealArray:
        """Return what is integrated, shape (6, *k.shape)."""
        gas = self.stack.ambient.gas
        answer = transfer(self.stack, Wave(frequency, k, gas, 0.0 if azimuth is None else azimuth))
        if azimuth is None:
            spectrum = self.excitation.spectrum(frequency, k, gas)
        else:
            spectrum = self.excitation.towards(frequency, k, azimuth, gas)
        front, back = np.abs(answer.front) ** 2, np.abs(answer.back) ** 2
        rows = [front, back, answer.radiation * back, answer.radiation_in_front * front]
        rows += [answer.front.real, answer.front.imag]
        return np.asarray(spectrum * np.stack(np.broadcast_arrays(*rows)))
