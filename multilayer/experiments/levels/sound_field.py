"""Sound fields, and the mean power that a stack lets through or absorbs in one, over bands and directions.

Of many samples of a stack at once, with directions laid beforehand: closer where plates are known to let most through.
`response.diffuse_field` halves panels of angles until one stack is known to 0.01 dB; here a few dozen directions for
each of several frequencies per band stand for it, which is known to some tenths of a decibel and smooth in all
parameters, as an inverse problem wants it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Literal, NamedTuple

import numpy as np

from multilayer.arrays import ComplexArray, IndexArray, Numeric, RealArray
from multilayer.layers.base import ElasticLayer, Layer
from multilayer.layers.poroelastic import Poroelastic
from multilayer.matrix.solve import HalfSpace
from multilayer.matrix.wave import Wave
from multilayer.media.elastic import flexural_rigidity
from multilayer.media.gas import Gas
from multilayer.response.finite_size import Window, finite_absorption, finite_transmission, radiation_at
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack

Quantity = Literal["transmission_loss", "absorption"]

_EVEN, _CLOSE = 12, 8  # directions spread evenly over sin^2 of the angle, and about each ridge
_GOLDEN = 0.6180339887498949  # fractions of multiples of it are spread evenly
_LEAST_WIDTH = 0.004  # of a ridge, relative
_ALIKE = 0.05  # relative distance of coincidences that need one set of directions
_COSINES = 97  # at which the radiation of a finite panel is tabulated
_SIDES = np.geomspace(0.25, 64.0, 17)  # m; of panels of unknown size
_AIR_STIFFNESS = 1.2e5  # Pa, of the gas between two plates, between isothermal and adiabatic


@dataclass(frozen=True)
class SoundField:
    """Plane waves from many directions, or from a single one.

    Fields may hold arrays of shape (m, 1), one row for each sample.

    Attributes
    ----------
    angle : float or array
        Degrees from the normal: the largest one of a diffuse field, or that of a single wave.
    is_diffuse : bool
    concentration : float or array
        b of the relative intensity exp(-b theta^2), theta in radians: 0 of a uniform field.
    tilt : float or array, shape (m, n_waves)
        x of a further relative intensity exp(x (s - 1/2)), s = sin^2 of the angle over its largest value.
    window : Window, optional
        The panel's size; infinite when left out.
    side : array, optional
        Of a square panel, m, in place of `window`.
    """

    angle: Numeric
    is_diffuse: bool = True
    concentration: Numeric = 0.0
    tilt: Numeric = 0.0
    window: Window | None = None
    side: RealArray | None = None


class Ridges(NamedTuple):
    """Where a stack has narrow maxima over the angle: layers by their indices."""

    plates: tuple[int, ...]
    cavities: tuple[tuple[int, int], ...]

    @classmethod
    def of(cls, stack: Stack, frequency: float) -> Ridges:
        """Return the ridges of a stack: a coincidence of every plate unlike the others, and every gap between two.

        Parameters
        ----------
        stack : Stack
        frequency : float
            Hz; about the middle of the data.
        """
        plates = plates_of(stack)
        wave = Wave(np.array([frequency]), np.zeros(1), stack.ambient.gas)
        kept: dict[int, float] = {}
        for index in plates:
            at = float(_coincidence(stack.layers[index], wave)[0].item())
            if all(abs(np.log(at / other)) > _ALIKE for other in kept.values()):
                kept[index] = at
        pairs = tuple((a, b) for a, b in pairwise(plates) if b > a + 1)
        return cls(tuple(kept), pairs)

    @property
    def n_directions(self) -> int:
        """Number of directions at each frequency of a diffuse field."""
        return _EVEN + _CLOSE * (len(self.plates) + len(self.cavities))


def plates_of(stack: Stack) -> list[int]:
    """Return the indices of the layers that are plates or solids without pores."""
    return [
        index
        for index, layer in enumerate(stack.layers)
        if isinstance(layer, ElasticLayer) and not isinstance(layer, Poroelastic) and hasattr(layer, "density")
    ]


def surface_density(layer: Layer) -> Numeric:
    """Return the mass per area of a plate, kg/m2."""
    density, thickness = (getattr(layer, name) for name in ("density", "thickness"))
    mass: Numeric = density * thickness
    return mass


def bending_stiffness(layer: ElasticLayer, wave: Wave) -> ComplexArray:
    """Return the complex bending stiffness of a plate per width, N m, at the frequencies of a wave."""
    thickness = getattr(layer, "thickness")  # noqa: B009
    modulus = np.asarray(layer.complex_modulus(wave), dtype=complex)
    return np.asarray(flexural_rigidity(modulus, layer.poisson_ratio, thickness))


def _coincidence(layer: Layer, wave: Wave) -> tuple[RealArray, RealArray]:
    """Return sin^2 of the angle of coincidence, and its half width, each of shape (..., n)."""
    assert isinstance(layer, ElasticLayer)
    gas, omega = wave.ambient, wave.omega
    mass, stiffness = surface_density(layer), bending_stiffness(layer, wave)
    s = gas.sound_speed**2 * np.sqrt(mass / np.abs(stiffness)) / omega
    loss = stiffness.imag / stiffness.real
    return np.asarray(s), np.asarray(s * np.maximum(loss / 2 + gas.impedance / (omega * mass), _LEAST_WIDTH))


def mean_power(
    quantity: Quantity,
    stack: Stack,
    sound: SoundField,
    nodes: RealArray,
    ridges: Ridges,
    as_met: Callable[[Stack], Stack] = lambda stack: stack,
) -> RealArray:
    """Return the transmitted or absorbed share of the incident power, shape (m, n), averaged over field and bands.

    Parameters
    ----------
    quantity : {'transmission_loss', 'absorption'}
        The transmitted share for the first.
    stack : Stack
        Its fields may hold arrays of shape (m, 1).
    sound : SoundField
    nodes : array, shape (n, p)
        Frequencies that stand for each datum, Hz.
    ridges : Ridges
    as_met : callable
        Gives the stack that the waves meet, whose fields may hold arrays of shape (m, n_waves) over
        `wave_frequencies`; directions are laid for the stack that it is given.
    """
    gas, frequency = stack.ambient.gas, nodes.ravel()
    if sound.is_diffuse:
        s, weight = _directions(stack, sound, frequency, ridges, by_cosine=quantity == "absorption")
    else:
        s = np.full((1, 1, frequency.size), _square_of_sine(sound.angle))
        weight = np.ones(s.shape)
    flat = s.reshape(s.shape[0], -1)
    share = _share(quantity, as_met(stack), sound, flat, frequency, gas)
    tilt = np.asarray(sound.tilt)
    if tilt.any():
        weight = weight * np.exp(tilt * (flat / _square_of_sine(sound.angle) - 0.5)).reshape(-1, *s.shape[1:])
    parts = np.broadcast_arrays(share.reshape(-1, *s.shape[1:]), weight)
    per_node = np.sum(parts[0] * parts[1], axis=1) / np.sum(parts[1], axis=1)
    return np.asarray(np.mean(per_node.reshape(-1, *nodes.shape), axis=-1))


def _square_of_sine(angle: Numeric) -> RealArray:
    return np.asarray(np.sin(np.deg2rad(np.asarray(angle, dtype=float))) ** 2)


def wave_frequencies(nodes: RealArray, sound: SoundField, ridges: Ridges) -> RealArray:
    """Return the frequency of every wave, Hz, shape (n_waves,): direction after direction."""
    return np.tile(nodes.ravel(), ridges.n_directions if sound.is_diffuse else 1)


def _directions(
    stack: Stack, sound: SoundField, frequency: RealArray, ridges: Ridges, *, by_cosine: bool
) -> tuple[RealArray, RealArray]:
    """Return sin^2 of the angles and their weights, each of shape (m, directions, frequencies).

    Directions are spread evenly over sin^2, or over the cosine: absorption of a finite sample grows as one over the
    cosine towards grazing incidence.

    Directions of several densities at once, each with the weight one over their sum: the balance heuristic of E. Veach
    & L. J. Guibas, Proc. SIGGRAPH 95 (1995) 419-428, with points laid evenly in place of random ones.
    """
    wave = Wave(frequency, np.zeros_like(frequency), stack.ambient.gas)
    upper = np.atleast_2d(_square_of_sine(sound.angle))[:, None]
    shift = np.mod((np.arange(frequency.size) + 0.5) * _GOLDEN, 1.0)

    def even(count: int) -> RealArray:
        return np.asarray((np.arange(count)[:, None] + shift) / count)

    most = upper / (1 + np.sqrt(1 - upper))  # 1 - cosine, to all digits for the smallest angles, too
    points = [1 - (1 - even(_EVEN) * most) ** 2 if by_cosine else upper * even(_EVEN)]
    peaks = []
    for centre, width in _peaks(stack, wave, ridges):
        c, w = (np.atleast_2d(values)[:, None, :] for values in (centre, width))
        low, high = np.arctan(-c / w), np.arctan((upper - c) / w)
        points.append(np.clip(c + w * np.tan(low + even(_CLOSE) * (high - low)), 0.0, upper))
        peaks.append((c, w, high - low))
    m = max(part.shape[0] for part in points)
    s = np.concatenate([np.broadcast_to(part, (m, *part.shape[1:])) for part in points], axis=1)
    spread = 1 / (2 * np.sqrt(1 - s) * most) if by_cosine else 1 / upper
    density = _EVEN * spread + sum(_CLOSE * w / ((s - c) ** 2 + w**2) / turn for c, w, turn in peaks)
    weight = 1 / np.broadcast_to(density, s.shape)
    concentration = np.asarray(sound.concentration, dtype=float)
    if concentration.any():
        weight = weight * np.exp(-np.atleast_2d(concentration)[:, None] * np.arcsin(np.sqrt(s)) ** 2)
    return s, weight


def _peaks(stack: Stack, wave: Wave, ridges: Ridges) -> list[tuple[RealArray, RealArray]]:
    """Return centres and widths of the ridges, in sin^2 of the angle, shape (..., n)."""
    found = [_coincidence(stack.layers[index], wave) for index in ridges.plates]
    for a, b in ridges.cavities:
        depth = sum(getattr(layer, "thickness", 0.0) for layer in stack.layers[a + 1 : b])
        masses = [surface_density(stack.layers[index]) for index in (a, b)]
        square = _AIR_STIFFNESS / depth * (1 / masses[0] + 1 / masses[1]) / wave.omega**2
        found.append((np.asarray(1 - square), np.asarray(0.05 + 0.1 * square)))
    return found


@np.errstate(all="ignore")  # what is not finite is no response, and told as such
def _share(
    quantity: Quantity, stack: Stack, sound: SoundField, s: RealArray, frequency: RealArray, gas: Gas
) -> RealArray:
    """Return the transmitted or absorbed share of the power of every wave, shape (m, n_waves)."""
    count = s.shape[-1] // frequency.size
    f = np.tile(frequency, count)
    azimuth: RealArray | float = 0.0
    if not stack.isotropic_in_plane:  # directions about the normal are spread along with those from it
        azimuth = 180 * np.mod((np.arange(f.size) + 0.5) * _GOLDEN**2, 1.0)
    wave = Wave(f, 2 * np.pi * f / gas.sound_speed * np.sqrt(s), gas, azimuth)
    front = wave_impedance(wave, gas.density, gas.sound_speed)
    system = build_system(stack, wave, HalfSpace(front))
    solution = solve_or_explain(system, stack, wave)
    reflection, transmitted = solution.reflected, solution.transmitted
    assert reflection is not None  # the head is a half-space
    cosine = np.sqrt(1 - s)
    if quantity == "absorption":
        if sound.window is None and sound.side is None:
            return np.asarray(1 - np.abs(reflection) ** 2)
        return finite_absorption(reflection, _radiation(sound, s, frequency, gas), cosine)
    assert transmitted is not None
    assert isinstance(system.tail, HalfSpace)
    share = np.asarray(np.abs(transmitted) ** 2 * np.real(1 / np.asarray(system.tail.impedance)) / np.real(1 / front))
    if sound.window is None and sound.side is None:
        return share
    return finite_transmission(share, _radiation(sound, s, frequency, gas).real, cosine)


def _radiation(sound: SoundField, s: RealArray, frequency: RealArray, gas: Gas) -> ComplexArray:
    """Return the radiation impedance of the panel over rho c at every wave, shape (m, n_waves)."""
    wavenumbers = tuple((2 * np.pi * frequency / gas.sound_speed).tolist())
    which = np.tile(np.arange(frequency.size), s.shape[-1] // frequency.size)
    if sound.side is None:
        assert sound.window is not None
        return _interpolated(_table(sound.window, wavenumbers), which, s)
    at = np.interp(np.log(np.ravel(sound.side)), np.log(_SIDES), np.arange(len(_SIDES)))
    below = np.minimum(at.astype(int), len(_SIDES) - 2)
    tables = {int(i): _table(Window(float(_SIDES[i]), float(_SIDES[i])), wavenumbers) for i in {*below, *(below + 1)}}
    rows = np.broadcast_to(s, (len(at), s.shape[-1]))
    mixed = []
    for position, first, row in zip(at, below, rows, strict=True):
        ends = (_interpolated(tables[int(i)], which, row[None]) for i in (first, first + 1))
        near, far = ends
        mixed.append(near + (position - first) * (far - near))
    return np.concatenate(mixed)


@lru_cache(maxsize=64)
def _table(window: Window, wavenumbers: Sequence[float]) -> ComplexArray:
    """Return the radiation impedance times the cosine over evenly spaced cosines, shape (n_wavenumbers, n_cosines)."""
    k0 = np.array(wavenumbers)
    cosine = np.linspace(0.0, 1.0, _COSINES)
    which, at = np.broadcast_arrays(np.arange(k0.size)[:, None], np.sqrt(1 - cosine**2))
    values = radiation_at(window, k0, float(k0.max()), _COSINES)(which, k0[:, None] * at)
    return np.asarray(values)


def _interpolated(table: ComplexArray, which: IndexArray, s: RealArray) -> ComplexArray:
    """Return the values of a table at wavenumbers by their indices, shape (n,), and sin^2 of angles, shape (m, n)."""
    position = np.sqrt(1 - s) * (_COSINES - 1)
    below = np.minimum(position.astype(int), _COSINES - 2)
    low, high = table[which, below], table[which, below + 1]
    return np.asarray(low + (position - below) * (high - low))
