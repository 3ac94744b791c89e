"""The quasi-static method: Young's modulus and Poisson's ratio from the compression stiffness of bonded discs.

C. Langlois, R. Panneton & N. Atalla, J. Acoust. Soc. Am. 110 (2001) 3032-3040. A disc glued between rigid plates is
stiffer than a free one by the shape factor g(nu, S), S = radius/(2 thickness): one stiffness gives E where nu is known,
two of different shapes give both.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from scipy.optimize import brentq

from multilayer.arrays import RealArray
from multilayer.errors import InputError
from multilayer.experiments.two_plate.transmissibility import Transmissibility
from multilayer.rig.shape_factor import static_shape_factor

_HIGHEST_NU = 0.495
_UNTOLD = 0.1  # standard deviation of nu, a fifth of its range, above which two shapes do not tell it
_SLOW = 0.1  # of the resonance: inertia is then 1 % of the force
_STEP, _SAME = 1e-2, 1e-3
_COARSE, _AROUND = 0.25, 0.02  # resolution for a first look and for slopes; how far the root may then be
_EXACT = 1e-9
_MIDDLE_NU = 0.3  # where the factor's slope by shape is taken: it hardly matters in an error of the geometry


@dataclass(frozen=True)
class Compression:
    """The measured stiffness of one bonded disc.

    Attributes
    ----------
    stiffness : complex
        Force over shortening, N/m; its imaginary part is the loss.
    radius, thickness : float
        m.
    stiffness_std, radius_std, thickness_std : float
        One standard deviation each, relative; errors of two discs are taken as independent.
    """

    stiffness: complex
    radius: float
    thickness: float
    stiffness_std: float = 0.0
    radius_std: float = 0.0
    thickness_std: float = 0.0

    def __post_init__(self) -> None:
        said = [
            f"{name}: {value:g} is not allowed; it must be above 0"
            for name, value in (("stiffness", complex(self.stiffness).real), *self._sizes)
            if not 0 < value < np.inf
        ]
        for name in ("stiffness_std", "radius_std", "thickness_std"):
            if not 0 <= getattr(self, name) < 1:
                said.append(f"{name}: {getattr(self, name):g} is not allowed; it is relative, from 0 to below 1")
        if said:
            raise InputError(said)

    @property
    def _sizes(self) -> tuple[tuple[str, float], tuple[str, float]]:
        return ("radius", self.radius), ("thickness", self.thickness)

    @property
    def shape(self) -> float:
        """S = radius/(2 thickness)."""
        return self.radius / (2 * self.thickness)

    @property
    def apparent_modulus(self) -> complex:
        """Force per area over strain, g E, Pa."""
        return complex(self.stiffness) * self.thickness / (np.pi * self.radius**2)


def young_modulus(stiffness: complex, radius: float, thickness: float, poisson_ratio: float) -> complex:
    """Return Young's modulus, Pa, of a disc glued between rigid plates from its stiffness in slow compression.

    Parameters
    ----------
    stiffness : complex
        Force over shortening, N/m.
    radius, thickness : float
        m.
    poisson_ratio : float
        0 <= nu < 0.5.

    Raises
    ------
    InputError
        For values out of range.
    """
    disc = Compression(stiffness, radius, thickness)
    return disc.apparent_modulus / static_shape_factor(poisson_ratio, disc.shape)


@dataclass(frozen=True)
class TwoShapes:
    """Young's modulus and Poisson's ratio from two discs of one material.

    Attributes
    ----------
    young_modulus : complex
        E1 + i E2, Pa.
    storage_modulus_std : float
        Pa; with Poisson's ratio as uncertain as it is.
    poisson_ratio, poisson_ratio_std : float
    told : bool
        Whether the shapes differ enough to tell Poisson's ratio.
    remarks : list of str
    """

    young_modulus: complex
    storage_modulus_std: float
    poisson_ratio: float
    poisson_ratio_std: float
    told: bool
    remarks: list[str] = field(default_factory=list)


def two_shapes(first: Compression, second: Compression) -> TwoShapes:
    """Return E and nu from the stiffness of two discs of different shape.

    The ratio of the apparent moduli is that of the shape factors, which grows with nu: solved by bracketing between 0
    and 0.495. The modulus is the mean of both discs' logarithms. Takes some seconds of finite elements.

    Parameters
    ----------
    first, second : Compression

    Raises
    ------
    InputError
        When the shapes are the same, or the ratio of the stiffnesses is that of no Poisson's ratio.

    Notes
    -----
    The standard deviation of nu comes from solving again with the ratio one standard deviation higher and lower, the
    larger change counting: near nu = 0 the ratio hardly depends on nu, and a slope would not do.
    """
    discs = sorted((first, second), key=lambda disc: disc.shape)
    if discs[1].shape < discs[0].shape * (1 + _SAME):
        raise InputError(
            f"both discs have the shape S = {discs[0].shape:.3g}: their stiffnesses cannot tell Poisson's ratio; take "
            "discs of different radius over thickness"
        )
    spreads = np.array([_apparent_stds(disc) for disc in discs])
    spread = float(np.linalg.norm(spreads))
    nu, edge = _poisson_ratio(discs, spread)
    nu_std = _poisson_ratio_std(discs, spread)
    e = complex(np.exp(np.mean([np.log(disc.apparent_modulus / _factor(nu, disc.shape)) for disc in discs])))
    told = nu_std <= _UNTOLD
    remarks = [edge] if edge else []
    if not told:
        remarks.append(
            f"the shapes S = {discs[0].shape:.3g} and {discs[1].shape:.3g} are too alike to tell Poisson's ratio "
            f"({nu:.2f} with a standard deviation of {nu_std:.2f}): take discs that differ more, or measure better"
        )
    return TwoShapes(e, _modulus_std(discs, spreads, nu, nu_std) * e.real, nu, nu_std, told, remarks)


@lru_cache(maxsize=1024)
def _factor(poisson_ratio: float, shape: float, resolution: float = 1.0) -> float:
    return static_shape_factor(poisson_ratio, shape, resolution=resolution)


def _log_ratio(discs: Sequence[Compression], poisson_ratio: float, resolution: float = 1.0) -> float:
    flat, tall = (_factor(poisson_ratio, disc.shape, resolution) for disc in reversed(discs))
    return float(np.log(flat / tall))


def _measured_log_ratio(discs: Sequence[Compression]) -> float:
    return float(np.log(discs[1].apparent_modulus.real / discs[0].apparent_modulus.real))


def _nearest(discs: Sequence[Compression], wanted: float) -> float:
    """Return nu within its range for a logarithm of the ratio, by a coarse mesh: good to some 1e-3."""
    if wanted <= 0:
        return 0.0
    if wanted >= _log_ratio(discs, _HIGHEST_NU, _COARSE):
        return _HIGHEST_NU
    return float(brentq(lambda nu: _log_ratio(discs, nu, _COARSE) - wanted, 0.0, _HIGHEST_NU, xtol=1e-4))


def _poisson_ratio(discs: Sequence[Compression], spread: float) -> tuple[float, str]:
    """Return nu, and a remark where it is the edge of what is possible."""
    wanted = _measured_log_ratio(discs)
    near = _nearest(discs, wanted)
    low, high = max(near - _AROUND, 0.0), min(near + _AROUND, _HIGHEST_NU)
    bottom, top = (_log_ratio(discs, nu) - wanted for nu in (low, high))
    if bottom <= _EXACT and top >= -_EXACT:
        if bottom >= -_EXACT or top <= _EXACT:
            return (low if bottom >= -_EXACT else high), ""
        return float(brentq(lambda nu: _log_ratio(discs, nu) - wanted, low, high, xtol=1e-7)), ""
    ratio, span = np.exp(wanted), f"1 to {np.exp(_log_ratio(discs, _HIGHEST_NU)):.4g}"
    if max(bottom, -top) > 3 * spread:
        raise InputError(
            f"the apparent moduli of the discs (S = {discs[1].shape:.3g} over S = {discs[0].shape:.3g}) are as "
            f"{ratio:.4g} to 1, but Poisson's ratios from 0 to 0.5 allow {span} only: check which disc is which, the "
            "gluing, and whether both are of one material"
        )
    return near, f"the stiffnesses ask for a Poisson's ratio beyond {near:g} (ratio {ratio:.4g}, possible {span})"


def _poisson_ratio_std(discs: Sequence[Compression], spread: float) -> float:
    if not spread:
        return 0.0
    wanted = _measured_log_ratio(discs)
    low, here, high = (_nearest(discs, wanted + shift) for shift in (-spread, 0.0, spread))
    return max(high - here, here - low)


def _apparent_stds(disc: Compression) -> RealArray:
    """Return relative standard deviations of (apparent modulus)/g from stiffness, radius and thickness."""
    by_shape = slope_by_shape(_MIDDLE_NU, disc.shape)
    powers = np.array([1.0, -2.0 - by_shape, 1.0 + by_shape])
    return powers * [disc.stiffness_std, disc.radius_std, disc.thickness_std]


def slope_by_shape(poisson_ratio: float, shape: float) -> float:
    """Return d ln g/d ln S of the shape factor g(nu, S): what an error of the geometry does to it.

    Parameters
    ----------
    poisson_ratio : float
        0 <= nu < 0.5.
    shape : float
        S = radius/(2 thickness).

    Raises
    ------
    InputError
        For values out of range.
    """
    shapes = shape * np.exp([-_STEP, _STEP])
    return _log_rise(*(_factor(poisson_ratio, one, _COARSE) for one in shapes)) / (2 * _STEP)


def _log_rise(low: float, high: float) -> float:
    return float(np.log(high / low))


def _modulus_std(discs: Sequence[Compression], spreads: RealArray, nu: float, nu_std: float) -> float:
    """Return the relative standard deviation of E1: each error acts on it, and on nu, which acts on it again."""
    spread = float(np.linalg.norm(spreads))
    if not spread:
        return 0.0
    low = min(nu, _HIGHEST_NU - _STEP)
    high = min(max(nu + nu_std, low + _STEP), _HIGHEST_NU)
    rises = [_log_rise(*(_factor(v, disc.shape, _COARSE) for v in (low, high))) for disc in discs]
    nu_shifts = np.array([[-1.0], [1.0]]) * spreads * nu_std / spread
    return float(np.linalg.norm(spreads / 2 - np.mean(rises) / (high - low) * nu_shifts))


@dataclass(frozen=True)
class BurstStiffness:
    """The stiffness that a burst far below the resonance shows.

    Attributes
    ----------
    frequency : float
        Hz.
    stiffness : complex
        N/m.
    relative_std : float
        Of its real part.
    loss_std : float
        Standard deviation of its imaginary part, over the real part.
    resonance : float
        Hz; where mass and stiffness have theirs.
    """

    frequency: float
    stiffness: complex
    relative_std: float
    loss_std: float
    resonance: float

    @property
    def quasi_static(self) -> bool:
        """Whether the burst lies below a tenth of the resonance."""
        return self.frequency <= _SLOW * self.resonance


def burst_stiffness(measured: Transmissibility, top_mass: float, specimen_mass: float) -> BurstStiffness:
    """Return the stiffness of a specimen under a mass on a shaken base, for slow motion.

    ``K = w^2 (M + m/2) T/(T - 1)``: eq. (11) of Bonfiglio & Pompoli 2015 to the second order in the frequency. Below
    a tenth of the resonance what is left out is less than 0.2 % of K. The price: T - 1 is 0.01 there, so a gain known
    to 0.3 % gives K to 30 %. A campaign's bursts serve as a quasi-static test only with channels calibrated far better
    than that, or many of them; the transfer function method needs no such limit.

    Parameters
    ----------
    measured : Transmissibility
    top_mass, specimen_mass : float
        kg.
    """
    t, omega = measured.value, 2 * np.pi * measured.frequency
    mass = top_mass + specimen_mass / 2
    stiffness = omega**2 * mass * t / (t - 1)
    shifts = stiffness * -measured.log_shifts / (t - 1)
    real = stiffness.real
    resonance = float(np.sqrt(abs(stiffness) / mass) / (2 * np.pi))
    spread = float(np.linalg.norm(shifts.real) / abs(real)), float(np.linalg.norm(shifts.imag) / abs(real))
    return BurstStiffness(measured.frequency, complex(stiffness), *spread, resonance)
