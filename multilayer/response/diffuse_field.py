"""Response to a diffuse field: plane waves from all directions up to a largest angle."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields, replace
from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, BoolArray, IndexArray, RealArray, frequencies
from multilayer.errors import InputError, ValidityWarning, suggest
from multilayer.frames import Frame, Tabular, over
from multilayer.matrix.solve import HalfSpace
from multilayer.matrix.wave import Wave
from multilayer.response.chunks import has_arrays, in_chunks
from multilayer.response.finite_size import (
    Radiation,
    Window,
    finite_absorption,
    finite_transmission,
    radiation_at,
    refuse_other_fluid,
)
from multilayer.response.quadrature import KRONROD, NODES, Panels, Tolerance, integrate, nodes
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack

Weighting: TypeAlias = Callable[[RealArray], RealArray]
WeightingName: TypeAlias = Literal["uniform", "gaussian"]

# of azimuths to start with: no sector of 10 degrees lies between two of their 30
_FIRST_PANELS = 2
_HALF_TURN = 180.0
_MANY_DIRECTIONS = 1000  # times those of one azimuth: with them most fields have converged, and the others hardly will


@dataclass(frozen=True, repr=False)
class DiffuseField(Tabular):
    """Response of a stack to a diffuse field; arrays of shape ``(*frequency.shape)``.

    Attributes
    ----------
    frequency : array
        Hz, as asked.
    max_angle : float
        Degrees.
    absorption : array
        1 - abs(reflection)^2, averaged over the field.
    transmission_coefficient : array or None
        Transmitted over incident power; None without a half-space behind.
    transmission_loss : array or None
        dB.
    absorption_error, transmission_loss_error : array
        Estimated errors of the quadrature, the second in dB (None without transmission).
    angles : array of int
        Directions that were computed per frequency.
    """

    frequency: RealArray
    max_angle: float
    absorption: RealArray
    transmission_coefficient: RealArray | None
    transmission_loss: RealArray | None
    absorption_error: RealArray
    transmission_loss_error: RealArray | None
    angles: RealArray

    @property
    def frame(self) -> Frame:
        """The response over frequency."""
        values = {
            item.name: getattr(self, item.name) for item in fields(self) if item.name not in ("frequency", "max_angle")
        }
        units = {"frequency": "Hz", "transmission_loss": "dB", "transmission_loss_error": "dB"}
        return over({"frequency": self.frequency}, values, units, {"max_angle": self.max_angle})


def diffuse_field(
    stack: Stack,
    frequency: ArrayLike,
    max_angle: float = 78.0,
    *,
    weighting: Weighting | WeightingName = "uniform",
    window: Window | None = None,
    tolerance_db: float = 0.01,
    tolerance: float = 1e-4,
    max_panels: int = 64,
    workers: int = 1,
) -> DiffuseField:
    """Return absorption and transmission loss in a diffuse field.

    Averaged over the azimuth too where a layer is not isotropic in its plane. The integral stops at `max_angle`, also
    with a `window`.

    Parameters
    ----------
    stack : Stack
        Without arrays in its fields.
    frequency : array, shape (n_frequency,) or ()
        Hz.
    max_angle : float
        Degrees from the normal, above 0 and at most 90: the whole half-space. 78 is customary for infinite panels.
    weighting : str or callable
        Relative intensity by angle: ``uniform``, ``gaussian`` for exp(-2 theta^2), theta in radians (Kang, Ih, Kim &
        Kim, J. Acoust. Soc. Am. 107 (2000) 1413-1420), or a function of the angle in degrees.
    window : Window, optional
        Size of the panel: corrects transmission (Rhazi & Atalla) and absorption (Thomasson; of no use where sound goes
        through), see `finite_size`. Infinite when left out.
    tolerance_db, tolerance : float
        Largest estimated error of the transmission loss (dB) and of the absorption.
    max_panels : int
        Panels of 15 angles at most, per frequency (and azimuth), and of 15 azimuths, per frequency. After 1000 times as
        many directions as one azimuth may take, azimuths are refined no more where the integrals over angles alone miss
        the tolerance.
    workers : int
        Threads.

    Raises
    ------
    InputError
        For a largest angle out of range, a weighting of another name, arrays in the stack, or a window with another
        fluid behind than the ambient gas.

    Warns
    -----
    ValidityWarning
        When some frequency does not reach the tolerance.

    Notes
    -----
    Allard & Atalla 2009, eqs. (11.88) and (12.1): the integral over the angle of ``tau w sin cos`` over that of ``w
    sin cos``, in the variable sin^2, where the weight of the sphere is constant. Gauss-Kronrod panels are halved where
    the two rules disagree, frequency by frequency: coincidence dips of lightly damped plates are narrow. Of a stack
    with a layer that is not isotropic in its plane such integrals are integrated over half a turn of the azimuth by the
    same rules, each with half of the tolerance; their errors add up. A window's radiation is its mean over the azimuth
    all the same, so that the result is the mean over all orientations of the window on the panel.
    """
    setting = DiffuseSetting(stack, max_angle, weighting, window, tolerance_db, tolerance, max_panels)
    f = frequencies(frequency)
    means = in_chunks(setting.means, stack, f.ravel(), setting.n_directions, workers)
    return setting.result(f, means)


@dataclass(frozen=True)
class DiffuseSetting:
    """A stack in a diffuse field; see `diffuse_field`, whose parameters these are."""

    stack: Stack
    max_angle: float
    weighting: Weighting | WeightingName
    window: Window | None
    tolerance_db: float
    tolerance: float
    max_panels: int

    def __post_init__(self) -> None:
        weighting_function(self.weighting)
        if not 0 < self.max_angle <= 90:
            text = f"a largest angle of {self.max_angle:g} degrees is not allowed; it must be above 0 and at most 90"
            raise InputError(text)
        if has_arrays(self.stack):
            raise InputError("a diffuse field takes one stack at a time; its fields must hold numbers, no arrays")
        if self.window is not None:
            refuse_other_fluid(self.stack)

    @property
    def n_directions(self) -> int:
        """About how many directions are solved at once for each frequency."""
        return 2 * len(NODES) * (1 if self.stack.isotropic_in_plane else _FIRST_PANELS * len(NODES))

    def directions(self, frequency: RealArray) -> Directions:
        """Return the integrals over directions at frequencies, Hz, shape (n_frequency,)."""
        upper = float(np.sin(np.deg2rad(self.max_angle)) ** 2)
        wavenumber = 2 * np.pi * frequency / self.stack.ambient.gas.sound_speed
        radiation = None if self.window is None else _radiation(self.window, wavenumber, upper)
        allowed = Tolerance(self.tolerance, self.tolerance_db * np.log(10) / 10)
        return Directions(
            self.stack, frequency, weighting_function(self.weighting), radiation, upper, allowed, self.max_panels
        )

    def means(self, frequency: RealArray) -> list[RealArray]:
        """Return mean absorption, transmission, the errors of both, and the number of directions, per frequency."""
        (whole, *means), taken = self.directions(np.atleast_1d(frequency)).integrals()
        return [*(mean / whole for mean in means), taken]

    def result(self, frequency: RealArray, means: Sequence[Sequence[RealArray]]) -> DiffuseField:
        """Return the response from `means` at consecutive pieces of the frequency axis, and warn where it is poor."""
        alpha, tau, alpha_error, tau_error, angles = (
            np.concatenate(parts).reshape(frequency.shape) for parts in zip(*means, strict=True)
        )
        through = not np.all(np.isnan(tau))
        with np.errstate(divide="ignore", invalid="ignore"):
            loss, loss_error = -10 * np.log10(tau), 10 / np.log(10) * tau_error / tau
        poor = (alpha_error > self.tolerance) | ((loss_error > self.tolerance_db) if through else False)
        if np.any(poor):
            worst = f"worst error {np.max(alpha_error):.1g} in absorption after {self.max_panels} panels of angles"
            text = f"diffuse field: {np.count_nonzero(poor)} of {poor.size} frequencies, {worst}"
            warnings.warn(text, ValidityWarning, stacklevel=3)
        return DiffuseField(
            frequency, self.max_angle, alpha, tau if through else None, loss if through else None,
            alpha_error, loss_error if through else None, angles,
        )  # fmt: skip


def _gaussian(angle: RealArray) -> RealArray:
    return np.asarray(np.exp(-2 * np.deg2rad(angle) ** 2))


_WEIGHTINGS: dict[str, Weighting] = {"uniform": np.ones_like, "gaussian": _gaussian}


def angle_of(s: RealArray) -> RealArray:
    """Return angles of incidence, degrees, by the squares of their sines, over which fields are integrated."""
    return np.asarray(np.rad2deg(np.arcsin(np.sqrt(s))))


def weighting_function(wanted: Weighting | str) -> Weighting:
    """Return the relative intensity by angle, in degrees, that a name or a function stands for."""
    if callable(wanted):
        return wanted
    if wanted not in _WEIGHTINGS:
        raise InputError(f"there is no weighting '{wanted}'; {suggest(wanted, _WEIGHTINGS)}")
    return _WEIGHTINGS[wanted]


def _radiation(window: Window, wavenumber: RealArray, upper: float) -> Radiation:
    # every frequency meets one panel of angles at least, most of them three
    return radiation_at(window, wavenumber, float(np.max(wavenumber, initial=0.0)) * upper**0.5, 3 * len(NODES))


@dataclass(frozen=True)
class Rays:
    """Panels of s = sin^2(angle) at pairs of a frequency and an azimuth; arrays of shape (n_panels,).

    Attributes
    ----------
    which : array of int
        Index of the frequency.
    azimuth : array
        Degrees.
    low, high : array
        Ends in s.
    weight : array
        Of the panel in the integral over all directions, times that of the node (`quadrature.KRONROD`).
    """

    which: IndexArray
    azimuth: RealArray
    low: RealArray
    high: RealArray
    weight: RealArray

    def __getitem__(self, index: slice | BoolArray) -> Rays:
        return Rays(*(getattr(self, item.name)[index] for item in fields(self)))


def _weighed(tried: Sequence[Rays], sectors: Panels) -> Iterator[Rays]:
    """Give those rays whose azimuths are nodes of the accepted sectors, with the weights of these."""
    half = 0.5 * (sectors.high - sectors.low)
    pairs = zip(np.repeat(sectors.which, len(NODES)), nodes(sectors.low, sectors.high).ravel(), strict=True)
    weights = dict(zip(pairs, (half[:, None] * KRONROD).ravel(), strict=True))
    for rays in tried:
        weight = np.array([weights.get(pair, 0.0) for pair in zip(rays.which, rays.azimuth, strict=True)])
        yield replace(rays, weight=rays.weight * weight)[weight > 0]


@dataclass(frozen=True)
class Directions:
    """Integrals over s = sin^2(angle), and over the azimuth where it makes a difference; all frequencies side by side.

    Rows of results are those of `quadrature.Integrand`.
    """

    stack: Stack
    frequency: RealArray
    weighting: Weighting
    radiation: Radiation | None
    upper: float
    tolerance: Tolerance
    max_panels: int

    def integrals(self, rays: list[Rays] | None = None) -> tuple[RealArray, RealArray]:
        """Return the integrals, and the number of directions, per frequency.

        Parameters
        ----------
        rays : list, optional
            Takes the directions that make the integrals.
        """
        if not self.stack.isotropic_in_plane:
            return self._over_azimuths(rays)
        everything = np.arange(len(self.frequency))
        return self._over_angles(everything, np.zeros(len(everything)), self.tolerance, rays=rays)

    def _over_azimuths(self, rays: list[Rays] | None) -> tuple[RealArray, RealArray]:
        """Return integrals over s and over half a turn of the azimuth, and the number of directions, per frequency.

        Each integral gets half of the tolerance. Integrals over s are smooth in the azimuth, but for a step where
        coincidence passes the largest angle, to which panels are halved.
        """
        n = len(self.frequency)
        directions, half = np.zeros(n), self.tolerance.halved
        tried: list[Rays] | None = None if rays is None else []
        sectors: list[Panels] = []

        def integrand(which: IndexArray, azimuth: RealArray) -> RealArray:
            rows, taken = self._over_angles(which.ravel(), azimuth.ravel(), half, first=_FIRST_PANELS, rays=tried)
            np.add.at(directions, which.ravel(), taken)
            return rows.reshape(len(rows), *which.shape)

        many = _MANY_DIRECTIONS * self.max_panels * len(NODES)
        rows, _ = integrate(
            integrand, n, _HALF_TURN, half, self.max_panels, _FIRST_PANELS,
            exhausted=lambda: directions > many, accepted=sectors,
        )  # fmt: skip
        if rays is not None and tried is not None:
            rays += _weighed(tried, Panels.joined(sectors))
        return rows, directions

    def _over_angles(
        self,
        which: IndexArray,
        azimuth: RealArray,
        tolerance: Tolerance,
        first: int = 1,
        rays: list[Rays] | None = None,
    ) -> tuple[RealArray, RealArray]:
        """Return integrals over s at pairs of frequencies, by their indices, and azimuths."""

        def integrand(pairs: IndexArray, s: RealArray) -> RealArray:
            alpha, tau = self._response(which[pairs], s, azimuth[pairs])
            weight = self.weighting(angle_of(s))
            exact = np.zeros_like(s)
            return np.array([weight, weight * alpha, weight * tau, exact, exact])

        accepted: list[Panels] = []
        result = integrate(integrand, len(which), self.upper, tolerance, self.max_panels, first, accepted=accepted)
        if rays is not None:
            panels = Panels.joined(accepted)
            weight = 0.5 * (panels.high - panels.low)
            pairs = panels.which
            rays.append(Rays(which[pairs], azimuth[pairs], panels.low, panels.high, weight))
        return result

    @np.errstate(all="ignore")  # what is not finite is refused, whatever made it so
    def _response(self, which: IndexArray, s: RealArray, azimuth: RealArray) -> tuple[RealArray, RealArray]:
        gas, frequency = self.stack.ambient.gas, self.frequency[which]
        wave = Wave(frequency, 2 * np.pi * frequency / gas.sound_speed * np.sqrt(s), gas, azimuth)
        front = wave_impedance(wave, gas.density, gas.sound_speed)
        system = build_system(self.stack, wave, HalfSpace(front))
        solution = solve_or_explain(system, self.stack, wave)
        assert solution.reflected is not None
        reflection, tau = solution.reflected, np.full(s.shape, np.nan)
        if solution.transmitted is not None and isinstance(system.tail, HalfSpace):
            power = np.real(1 / np.asarray(system.tail.impedance)) / np.real(1 / front)
            tau = np.abs(solution.transmitted) ** 2 * power
        if self.radiation is None:
            return 1 - np.abs(reflection) ** 2, tau
        cosine, radiation = np.sqrt(1 - s), self.radiation(which, wave.kx.real)
        return finite_absorption(reflection, radiation, cosine), finite_transmission(tau, radiation.real, cosine)
