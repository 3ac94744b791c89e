"""Response to a diffuse field: plane waves from all directions up to a largest angle."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import Literal, TypeAlias

import numpy as np

from multilayer.arrays import ArrayLike, BoolArray, IndexArray, RealArray
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
from multilayer.response.system import build_system, solve_or_explain, wave_impedance
from multilayer.stack import Stack

Weighting: TypeAlias = Callable[[RealArray], RealArray]
WeightingName: TypeAlias = Literal["uniform", "gaussian"]

# Gauss-Kronrod pair of 7 and 15 nodes on [-1, 1] (QUADPACK, Piessens et al. 1983, routine qk15)
_NODES = np.array([
    0.991455371120812639206854697526329, 0.949107912342758524526189684047851, 0.864864423359769072789712788640926,
    0.741531185599394439863864773280788, 0.586087235467691130294144691693137, 0.405845151377397166906606412076961,
    0.207784955007898467600689403773245, 0.0,
])  # fmt: skip
_KRONROD = np.array([
    0.022935322010529224963732008058970, 0.063092092629978553290700663189204, 0.104790010322250183839876322541518,
    0.140653259715525918745189590510238, 0.169004726639267902826583426598550, 0.190350578064785409913256402421014,
    0.204432940075298892414161999234649, 0.209482141084727828012999174891714,
])  # fmt: skip
_GAUSS = np.array([
    0.129484966168869693270611432679082, 0.279705391489276667901467771423780, 0.381830050505118944950369775488975,
    0.417959183673469387755102040816327,
])  # fmt: skip
NODES = np.concatenate([-_NODES, _NODES[-2::-1]])
KRONROD = np.concatenate([_KRONROD, _KRONROD[-2::-1]])
GAUSS = np.zeros(15)
GAUSS[1::2] = np.concatenate([_GAUSS, _GAUSS[-2::-1]])


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
        Angles that were computed per frequency.
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

    Parameters
    ----------
    stack : Stack
        Without arrays in its fields.
    frequency : array, shape (n_frequency,) or ()
        Hz.
    max_angle : float
        Degrees from the normal, above 0 and at most 90; 78 is customary.
    weighting : str or callable
        Relative intensity by angle: ``uniform``, ``gaussian`` for exp(-2 theta^2), theta in radians (Kang, Ih, Kim &
        Kim, J. Acoust. Soc. Am. 107 (2000) 1413-1420), or a function of the angle in degrees.
    window : Window, optional
        Size of the panel: corrects transmission (Rhazi & Atalla) and absorption (Thomasson), see `finite_size`.
        Infinite when left out.
    tolerance_db, tolerance : float
        Largest estimated error of the transmission loss (dB) and of the absorption.
    max_panels : int
        Panels of 15 angles per frequency at most.
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
    the two rules disagree, frequency by frequency: coincidence dips of lightly damped plates are narrow.
    """
    if not 0 < max_angle <= 90:
        raise InputError(f"a largest angle of {max_angle:g} degrees is not allowed; it must be above 0 and at most 90")
    if has_arrays(stack):
        raise InputError("a diffuse field takes one stack at a time; its fields must hold numbers, no arrays")
    f, weight = np.asarray(frequency, dtype=float), _weighting(weighting)
    upper, speed = float(np.sin(np.deg2rad(max_angle)) ** 2), stack.ambient.gas.sound_speed

    def compute(piece: RealArray) -> list[RealArray]:
        some = np.atleast_1d(piece)
        radiation = None if window is None else _radiation(window, 2 * np.pi * some / speed, upper)
        return _Quadrature(stack, some, weight, radiation, tolerance_db, tolerance).integrate(upper, max_panels)

    parts = in_chunks(compute, stack, f, 2 * len(NODES), workers)
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


def _weighting(wanted: Weighting | str) -> Weighting:
    if callable(wanted):
        return wanted
    if wanted not in _WEIGHTINGS:
        raise InputError(f"there is no weighting '{wanted}'; {suggest(wanted, _WEIGHTINGS)}")
    return _WEIGHTINGS[wanted]


def _radiation(window: Window, wavenumber: RealArray, upper: float) -> Radiation:
    # every frequency meets one panel of angles at least, most of them three
    return radiation_at(window, wavenumber, float(np.max(wavenumber, initial=0.0)) * upper**0.5, 3 * len(NODES))


@dataclass(frozen=True)
class _Quadrature:
    """Adaptive integration over s = sin^2(angle), all frequencies side by side."""

    stack: Stack
    frequency: RealArray
    weighting: Weighting
    radiation: Radiation | None
    tolerance_db: float
    tolerance: float

    def integrate(self, upper: float, max_panels: int) -> list[RealArray]:
        """Return means of absorption and transmission, their errors, and the number of angles, per frequency."""
        n = len(self.frequency)
        which, low, high = np.arange(n), np.zeros(n), np.full(n, upper)
        done = np.zeros((5, n))  # sums of: weight, alpha, tau, error of alpha, error of tau
        angles = np.zeros(n)
        panels = np.ones(n)
        while len(which):
            values, errors = self._panels(which, low, high)
            np.add.at(angles, which, len(NODES))
            scale = done.copy()
            for k in range(3):
                np.add.at(scale[k], which, values[k])
            again = self._too_coarse(values, errors, scale[:, which], (high - low) / upper)
            again &= (panels[which] < max_panels) & (high - low > 1e-9 * upper)
            kept = ~again
            for k, part in enumerate((*values, *errors)):
                np.add.at(done[k], which[kept], part[kept])
            np.add.at(panels, which[again], 1)
            middle = 0.5 * (low + high)[again]
            which = np.concatenate([which[again]] * 2)
            low, high = np.concatenate([low[again], middle]), np.concatenate([middle, high[again]])
        weight, alpha, tau, alpha_error, tau_error = done
        return [alpha / weight, tau / weight, alpha_error / weight, tau_error / weight, angles]

    def _too_coarse(self, values: RealArray, errors: RealArray, total: RealArray, share: RealArray) -> BoolArray:
        """Tell which panels err by more than their share of the tolerance."""
        allowed = self.tolerance_db * np.log(10) / 10 * total[2]
        with np.errstate(invalid="ignore"):  # without transmission there is nothing to compare
            coarse_tau = errors[1] > np.maximum(share, 0.05) * allowed
        return np.asarray((errors[0] > np.maximum(share, 0.05) * self.tolerance * total[0]) | coarse_tau)

    def _panels(self, which: IndexArray, low: RealArray, high: RealArray) -> tuple[RealArray, RealArray]:
        """Return integrals of weight, absorption and transmission over panels, and errors of the last two."""
        half = 0.5 * (high - low)
        s = (0.5 * (high + low))[:, None] + half[:, None] * NODES
        alpha, tau = self._response(np.broadcast_to(which[:, None], s.shape), s)
        weight = self.weighting(np.rad2deg(np.arcsin(np.sqrt(s))))
        fine = half * np.array([(weight * v) @ KRONROD for v in (np.ones_like(s), alpha, tau)])
        coarse = half * np.array([(weight * v) @ GAUSS for v in (alpha, tau)])
        return fine, np.abs(fine[1:] - coarse)

    def _response(self, which: IndexArray, s: RealArray) -> tuple[RealArray, RealArray]:
        gas, frequency = self.stack.ambient.gas, self.frequency[which]
        wave = Wave(frequency, 2 * np.pi * frequency / gas.sound_speed * np.sqrt(s), gas)
        front = wave_impedance(wave, gas.density, gas.sound_speed)
        system = build_system(self.stack, wave, HalfSpace(front))
        solution = solve_or_explain(system)
        assert solution.reflected is not None
        reflection, tau = solution.reflected, np.full(s.shape, np.nan)
        if solution.transmitted is not None and isinstance(system.tail, HalfSpace):
            power = np.real(1 / np.asarray(system.tail.impedance)) / np.real(1 / front)
            tau = np.abs(solution.transmitted) ** 2 * power
        if self.radiation is None:
            return 1 - np.abs(reflection) ** 2, tau
        cosine, radiation = np.sqrt(1 - s), self.radiation(which, wave.kx)
        return finite_absorption(reflection, radiation, cosine), finite_transmission(tau, radiation, cosine)
