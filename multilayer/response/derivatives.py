"""Derivatives of responses by fields of a stack's layers: all of them for the price of about three solutions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from multilayer.arrays import ArrayLike, ComplexArray, RealArray, frequencies
from multilayer.errors import InputError, suggest
from multilayer.frames import Array, Frame, Tabular, over
from multilayer.matrix.solve import HalfSpace, Wall
from multilayer.matrix.wave import Wave
from multilayer.response.base_motion import BaseMotion, velocity_of_top
from multilayer.response.chunks import POINTS, in_chunks
from multilayer.response.diffuse_field import (
    DiffuseField,
    DiffuseSetting,
    Directions,
    Rays,
    Weighting,
    WeightingName,
    angle_of,
)
from multilayer.response.finite_size import Window, finite_absorption_slope, finite_transmission
from multilayer.response.linearised import Variations, linearised, real_fields
from multilayer.response.plane_wave import PlaneWave, front_impedance, joined, plane_wave_of
from multilayer.response.quadrature import KRONROD, NODES, nodes
from multilayer.stack import Stack
from multilayer.units import DB_PER_NEPER

_SOLUTIONS = 2  # as many arrays are held at once as of so many solutions
_RAYS = POINTS // (_SOLUTIONS * len(NODES))


@dataclass(frozen=True, repr=False)
class Derivatives(Tabular):
    """Derivatives of a response; arrays of shape (n_fields, ...), ... that of the response's.

    Attributes
    ----------
    fields : tuple of str
        Dotted paths of what the derivatives are by, in SI units.
    by_differences : tuple of str
        Fields of layers whose medium is unknown, as a plugin's may be: their derivatives are differences of fourth
        order of whole responses.
    """

    fields: tuple[str, ...]
    by_differences: tuple[str, ...]

    def by(self, field: str) -> dict[str, Array]:
        """Return the derivatives of every quantity by one field, by the quantity's name.

        Raises
        ------
        InputError
            When there is no derivative by it.
        """
        if field not in self.fields:
            raise InputError(f"there is no derivative by '{field}'; {suggest(field, self.fields)}")
        place = self.fields.index(field)
        return {name: values[place] for name, values in self._values.items()}

    @property
    def _values(self) -> dict[str, Array]:
        """The derivatives by the quantity's name."""
        own = [item.name for item in fields(self) if item.name not in ("fields", "by_differences", "response")]
        return {name: value for name in own if (value := getattr(self, name)) is not None}

    def _over(self, along: Mapping[str, RealArray]) -> Frame:
        """Return the derivatives over fields and the coordinates of the response, samples before both."""
        inner = sum(np.ndim(array) for array in along.values())
        values = {name: np.moveaxis(value, 0, -1 - inner) for name, value in self._values.items()}
        return over({"field": np.array(self.fields), **along}, values, {"frequency": "Hz", "angle": "degree"})


@dataclass(frozen=True, repr=False)
class PlaneWaveDerivatives(Derivatives):
    """Derivatives of a stack's response to a plane wave; see `Derivatives` and `PlaneWave`.

    Attributes
    ----------
    response : PlaneWave
        The response itself.
    reflection, surface_impedance, absorption : array
        Derivatives, the first two complex.
    transmission, transmission_loss : array or None
        Derivatives, the second in dB per unit; None without a half-space behind.
    """

    response: PlaneWave
    reflection: ComplexArray
    transmission: ComplexArray | None
    surface_impedance: ComplexArray
    absorption: RealArray
    transmission_loss: RealArray | None

    @property
    def frame(self) -> Frame:
        """The derivatives over fields, (samples,) frequency and angle."""
        along = {name: array for name, (_, array) in self.response.frame.coordinates.items()}
        return self._over(along)


def plane_wave_derivatives(
    stack: Stack,
    fields: Sequence[str] | None,
    frequency: ArrayLike,
    angle: ArrayLike = 0.0,
    workers: int = 1,
    *,
    azimuth: ArrayLike = 0.0,
) -> PlaneWaveDerivatives:
    """Return the response of `stack` to plane waves, and its derivatives by fields of its layers.

    Parameters
    ----------
    stack : Stack
    fields : sequence of str or None
        Dotted paths, as ``layers.foam.thickness`` or ``layers.rubber.young_modulus.order``, of fields that hold real
        numbers; None for all quantities of all layers.
    frequency, angle, workers, azimuth
        As in `plane_wave`.

    Raises
    ------
    InputError
        For a path that leads nowhere or to what is no real number of a layer; and as `plane_wave`.
    CouplingError
        When two neighbours cannot touch as the stack says.

    Notes
    -----
    From the adjoint system; see ``docs/theory/stacks.md``.
    """
    paths, f = real_fields(stack, fields), frequencies(frequency)
    variations = Variations(stack, paths)

    @np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
    def compute(piece: RealArray) -> PlaneWaveDerivatives:
        wave = Wave.incident(piece, angle, stack.ambient.gas, azimuth)
        front = front_impedance(wave)
        found = linearised(variations, wave, HalfSpace(front))
        response = plane_wave_of(found.system, found.solution, wave, piece, angle)
        return _of_plane_wave(response, front, found.slopes, paths, found.by_differences)

    n_directions = _SOLUTIONS * np.size(angle) * np.size(azimuth)
    parts = in_chunks(compute, stack, f, n_directions, workers)
    if len(parts) == 1:
        return parts[0]
    columns: dict[str, Any] = dict.fromkeys(("transmission", "transmission_loss"))
    for name in parts[0]._values:
        columns[name] = np.concatenate([part._values[name] for part in parts], axis=1)
    return PlaneWaveDerivatives(paths, parts[0].by_differences, joined([part.response for part in parts]), **columns)


def _of_plane_wave(
    response: PlaneWave, front: ComplexArray, slopes: ComplexArray, paths: tuple[str, ...], differences: tuple[str, ...]
) -> PlaneWaveDerivatives:
    reflection, change = response.reflection, slopes[:, 0]
    through = slopes[:, 1] if response.transmission is not None else None
    loss = None
    if through is not None:
        assert response.transmission is not None
        loss = -DB_PER_NEPER * np.real(through / response.transmission)
    return PlaneWaveDerivatives(
        paths, differences, response, change, through,
        surface_impedance=2 * front / (1 - reflection) ** 2 * change,
        absorption=-2 * np.real(np.conj(reflection) * change),
        transmission_loss=loss,
    )  # fmt: skip


@dataclass(frozen=True, repr=False)
class BaseMotionDerivatives(Derivatives):
    """Derivatives of a stack's motion on a shaken base; see `Derivatives` and `BaseMotion`.

    Attributes
    ----------
    response : BaseMotion
        The response itself.
    transmissibility : complex array
        Derivatives.
    """

    response: BaseMotion
    transmissibility: ComplexArray

    @property
    def frame(self) -> Frame:
        """The derivatives over fields (, samples) and frequency."""
        return self._over({"frequency": self.response.frequency})


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def base_motion_derivatives(stack: Stack, fields: Sequence[str] | None, frequency: ArrayLike) -> BaseMotionDerivatives:
    """Return how the back face of `stack` follows its shaken front face, and the derivatives by fields of its layers.

    Parameters
    ----------
    stack, frequency
        As in `base_motion`.
    fields : sequence of str or None
        As in `plane_wave_derivatives`.

    Raises
    ------
    InputError, CouplingError
        As `plane_wave_derivatives`.
    """
    paths = real_fields(stack, fields)
    wave = Wave.incident(frequency, 0.0, stack.ambient.gas)
    found = linearised(Variations(stack, paths, on_base=True), wave, Wall())
    response = BaseMotion(np.asarray(frequency, dtype=float), velocity_of_top(found.system, found.solution))
    return BaseMotionDerivatives(paths, found.by_differences, response, found.slopes[:, 0])


@dataclass(frozen=True, repr=False)
class DiffuseFieldDerivatives(Derivatives):
    """Derivatives of a stack's response to a diffuse field; see `Derivatives` and `DiffuseField`.

    Attributes
    ----------
    response : DiffuseField
        The response itself.
    absorption : array
        Derivatives.
    transmission_coefficient, transmission_loss : array or None
        Derivatives, the second in dB per unit; None without a half-space behind.
    """

    response: DiffuseField
    absorption: RealArray
    transmission_coefficient: RealArray | None
    transmission_loss: RealArray | None

    @property
    def frame(self) -> Frame:
        """The derivatives over fields and frequency."""
        return self._over({"frequency": self.response.frequency})


def diffuse_field_derivatives(
    stack: Stack,
    fields: Sequence[str] | None,
    frequency: ArrayLike,
    max_angle: float = 78.0,
    *,
    weighting: Weighting | WeightingName = "uniform",
    window: Window | None = None,
    tolerance_db: float = 0.01,
    tolerance: float = 1e-4,
    max_panels: int = 64,
    workers: int = 1,
) -> DiffuseFieldDerivatives:
    """Return absorption and transmission loss in a diffuse field, and their derivatives by fields of the layers.

    Parameters
    ----------
    fields : sequence of str or None
        As in `plane_wave_derivatives`.
    stack, frequency, max_angle, weighting, window, tolerance_db, tolerance, max_panels, workers
        As in `diffuse_field`.

    Raises
    ------
    InputError, CouplingError
        As `diffuse_field` and `plane_wave_derivatives`.

    Warns
    -----
    ValidityWarning
        When some frequency does not reach the tolerance.

    Notes
    -----
    The derivatives are those of the quadrature: of the mean over the directions that the response itself takes.
    """
    paths, f = real_fields(stack, fields), frequencies(frequency)
    setting = DiffuseSetting(stack, max_angle, weighting, window, tolerance_db, tolerance, max_panels)
    variations = Variations(stack, paths)
    unknown: set[str] = set()

    def compute(piece: RealArray) -> tuple[list[RealArray], RealArray]:
        rays: list[Rays] = []
        directions = setting.directions(np.atleast_1d(piece))
        (whole, *means), taken = directions.integrals(rays)
        slopes = np.zeros((2, len(paths), len(whole)))
        for some in rays:
            for first in range(0, len(some.which), _RAYS):
                unknown.update(_add_slopes(directions, variations, some[first : first + _RAYS], slopes))
        return [*(mean / whole for mean in means), taken], slopes / whole

    parts = in_chunks(compute, stack, f.ravel(), setting.n_directions, workers)
    response = setting.result(f, [means for means, _ in parts])
    alpha, tau = np.concatenate([slopes for _, slopes in parts], axis=-1).reshape(2, len(paths), *f.shape)
    through = response.transmission_coefficient
    return DiffuseFieldDerivatives(
        paths, tuple(path for path in paths if path in unknown), response, alpha,
        transmission_coefficient=None if through is None else tau,
        transmission_loss=None if through is None else -DB_PER_NEPER / 2 * tau / through,
    )  # fmt: skip


@np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
def _add_slopes(directions: Directions, variations: Variations, rays: Rays, slopes: RealArray) -> tuple[str, ...]:
    """Add the derivatives of absorption and transmission along some directions, weighed; return `by_differences`."""
    gas, s = directions.stack.ambient.gas, nodes(rays.low, rays.high)
    frequency = directions.frequency[rays.which][:, None]
    kx = 2 * np.pi * frequency / gas.sound_speed * np.sqrt(s)
    wave = Wave(frequency, kx, gas, rays.azimuth[:, None])
    found = linearised(variations, wave, HalfSpace(front_impedance(wave)))
    reflected, transmitted, tail = found.solution.reflected, found.solution.transmitted, found.system.tail
    assert reflected is not None
    # of |r|^2 and tau
    returned, through = 2 * np.real(np.conj(reflected) * found.slopes[:, 0]), np.zeros((len(found.slopes), *s.shape))
    if transmitted is not None and isinstance(tail, HalfSpace):
        power = np.real(1 / np.asarray(tail.impedance)) / np.real(1 / front_impedance(wave))
        through = 2 * np.real(np.conj(transmitted) * found.slopes[:, 1]) * power
    absorbed = -returned
    if directions.radiation is not None:
        cosine = np.sqrt(1 - s)
        radiation = directions.radiation(np.broadcast_to(rays.which[:, None], s.shape), kx)
        absorbed = finite_absorption_slope(reflected, found.slopes[:, 0], radiation, cosine)
        through = finite_transmission(through, radiation.real, cosine)
    weight = rays.weight[:, None] * KRONROD * directions.weighting(angle_of(s))
    for total, slope in zip(slopes, (absorbed, through), strict=True):
        np.add.at(total.T, rays.which, np.sum(weight * slope, axis=-1).T)
    return found.by_differences
