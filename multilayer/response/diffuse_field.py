"""Response to a diffuse field: plane waves from all directions up to a largest angle."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, IndexArray, RealArray
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
)
from multilayer.response.quadrature import NODES, Tolerance, integrate
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
        Size of the panel: corrects transmission (Rhazi & Atalla) and absorption (Thomasson), see `finite_size`.
        Infinite when left out.
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
        For a largest angle out of range, a weighting of another name, or arrays in the stack.

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
    if not 0 < max_angle <= 90:
        raise InputError(f"a largest angle of {max_angle:g} degrees is not allowed; it must be above 0 and at most 90")
    if has_arrays(stack):
        raise InputError("a diffuse field takes one stack at a time; its fields must hold numbers, no arrays")
    f, weight = np.asarray(frequency, dtype=float), weighting_function(weighting)
    upper, speed = float(np.sin(np.deg2rad(max_angle)) ** 2), stack.ambient.gas.sound_speed
    allowed, turned_alike = Tolerance(tolerance, tolerance_db * np.log(10) / 10), stack.isotropic_in_plane

    def compute(piece: RealArray) -> list[RealArray]:
        some = np.atleast_1d(piece)
        radiation = None if window is None else _radiation(window, 2 * np.pi * some / speed, upper)
        directions = _Directions(stack, some, weight, radiation, upper, allowed, max_panels)
        rows, taken = directions.over_angles() if turned_alike else directions.over_azimuths()
        whole, *means = rows
        return [*(mean / whole for mean in means), taken]

    n_directions = 2 * len(NODES) * (1 if turned_alike else _FIRST_PANELS * len(NODES))
    parts = in_chunks(compute, stack, f, n_directions, workers)
    alpha, tau, alpha_error, tau_error, angles = (np.concatenate(p).reshape(f.shape) for p in zip(*parts, strict=True))
    through = not np.all(np.isnan(tau))
    with np.errstate(divide="ignore", invalid="ignore"):
        loss, loss_error = -10 * np.log10(tau), 10 / np.log(10) * tau_error / tau
    poor = (alpha_error > tolerance) | ((loss_error > tolerance_db) if through else False)
    if np.any(poor):
        worst = (
            f"{np.count_nonzero(poor)} of {poor.size} frequencies, worst error {np.max(alpha_error):.1g} in absorption"
        )
        warnings.warn(f"diffuse field: {worst} after {max_panels} panels of angles", ValidityWarning, stacklevel=2)
    return DiffuseField(
        f, max_angle, alpha, tau if through else None, loss if through else None,
        alpha_error, loss_error if through else None, angles,
    )  # fmt: skip


def _gaussian(angle: RealArray) -> RealArray:
    return np.asarray(np.exp(-2 * np.deg2rad(angle) ** 2))


_WEIGHTINGS: dict[str, Weighting] = {"uniform": np.ones_like, "gaussian": _gaussian}


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
class _Directions:
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

    def over_angles(self) -> tuple[RealArray, RealArray]:
        """Return integrals over s at azimuth 0, and the number of directions, per frequency."""
        everything = np.arange(len(self.frequency))
        return self._over_angles(everything, np.zeros(len(everything)), self.tolerance)

    def over_azimuths(self) -> tuple[RealArray, RealArray]:
        """Return integrals over s and over half a turn of the azimuth, and the number of directions, per frequency.

        Each integral gets half of the tolerance. Integrals over s are smooth in the azimuth, but for a step where
        coincidence passes the largest angle, to which panels are halved.
        """
        n = len(self.frequency)
        directions, half = np.zeros(n), self.tolerance.halved

        def integrand(which: IndexArray, azimuth: RealArray) -> RealArray:
            rows, taken = self._over_angles(which.ravel(), azimuth.ravel(), half, first=_FIRST_PANELS)
            np.add.at(directions, which.ravel(), taken)
            return rows.reshape(len(rows), *which.shape)

        many = _MANY_DIRECTIONS * self.max_panels * len(NODES)
        rows, _ = integrate(
            integrand, n, _HALF_TURN, half, self.max_panels, _FIRST_PANELS, exhausted=lambda: directions > many
        )
        return rows, directions

    def _over_angles(
        self, which: IndexArray, azimuth: RealArray, tolerance: Tolerance, first: int = 1
    ) -> tuple[RealArray, RealArray]:
        """Return integrals over s at pairs of frequencies, by their indices, and azimuths."""

        def integrand(pairs: IndexArray, s: RealArray) -> RealArray:
            alpha, tau = self._response(which[pairs], s, azimuth[pairs])
            weight = self.weighting(np.rad2deg(np.arcsin(np.sqrt(s))))
            exact = np.zeros_like(s)
            return np.array([weight, weight * alpha, weight * tau, exact, exact])

        return integrate(integrand, len(which), self.upper, tolerance, self.max_panels, first)

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
        cosine, radiation = np.sqrt(1 - s), self.radiation(which, wave.kx)
        return finite_absorption(reflection, radiation, cosine), finite_transmission(tau, radiation, cosine)
