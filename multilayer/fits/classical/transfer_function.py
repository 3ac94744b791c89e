"""The transfer function method: each burst's transmissibility inverted for the modulus of a rod under a rigid mass.

T. Pritz, J. Sound Vib. 81 (1982) 359-376; eq. (11) and the "dynamic method" of Figs. 6-8 of Bonfiglio & Pompoli 2015.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from multilayer.arrays import ComplexArray
from multilayer.errors import InputError, suggest
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.transmissibility import Transmissibility, measure
from multilayer.fits.classical.quasi_static import slope_by_shape
from multilayer.fits.classical.rod_branches import QUARTER, Rod, Solutions, follow_branch, motion, solve
from multilayer.fits.classical.rod_limit import longest_rod, rim_inertia, rod_error
from multilayer.fits.settings import Bounds
from multilayer.log import logged
from multilayer.measurements.description import Campaign, Configuration, Uncertainty
from multilayer.media.elastic import p_wave_modulus
from multilayer.rig.shape_factor import static_shape_factor

Lateral = Literal["bonded", "slender", "held"]
_MARGIN = 0.1  # by which a loss factor may lie below its bound: noise makes small ones negative
_WEAK = 0.1


@dataclass(frozen=True)
class RodPoint:
    """What the transfer function method says of one burst.

    Attributes
    ----------
    configuration : str
    transmissibility : Transmissibility
        As measured.
    modulus : complex
        Young's modulus E1 + i E2, Pa; NaN where there is none.
    storage_modulus_std, loss_modulus_std, loss_factor_std : float
        Standard deviations; Pa, Pa, and of E2/E1.
    wavelengths, reach : float
        Thickness of the sample over the wavelength in it, and the largest with which the rod is to be believed.
    alternatives : tuple of complex
        The other moduli within bounds with the very same transmissibility, Pa.
    reason : str
        Why the modulus is not to be relied on; empty when it is.
    notes : list of str
        What a reader should know all the same.
    """

    configuration: str
    transmissibility: Transmissibility
    modulus: complex
    storage_modulus_std: float
    loss_modulus_std: float
    loss_factor_std: float
    wavelengths: float
    reach: float = QUARTER
    alternatives: tuple[complex, ...] = ()
    reason: str = ""
    notes: list[str] = field(default_factory=list)

    @property
    def frequency(self) -> float:
        """Of the burst, Hz."""
        return self.transmissibility.frequency

    @property
    def found(self) -> bool:
        """Whether there is a modulus at all."""
        return bool(np.isfinite(self.modulus))

    @property
    def remark(self) -> str:
        """Reason and notes in one line."""
        return "; ".join(part for part in (self.reason, *self.notes) if part)


def transfer_function(
    campaign: Campaign,
    bursts: Sequence[BurstData],
    lateral: Lateral = "bonded",
    bounds: Bounds | None = None,
    progress: Callable[[str], None] | None = None,
) -> list[RodPoint]:
    """Invert the transmissibility of every burst.

    Parameters
    ----------
    campaign : Campaign
    bursts : sequence of BurstData
        Averaged over repeats, calibrated.
    lateral : {'bonded', 'slender', 'held'}
        Which modulus the rod's is taken for. ``slender``: Young's modulus itself, a long rod. ``held``: lambda + 2 mu,
        a sample that cannot widen. ``bonded``: Young's modulus times the static shape factor g(nu, S) of a disc glued
        at both faces and free at its rim.
    bounds : Bounds, optional
        Where a modulus is sought.
    progress : callable, optional
        Called with a short text after every burst.

    Returns
    -------
    list of RodPoint
        In the order of `bursts`.

    Raises
    ------
    InputError
        For an unknown `lateral`, or a Poisson's ratio below 0 with ``bonded``.

    Notes
    -----
    **Branches.** Several moduli have one transmissibility: all within bounds are found (`rod_branches.solve`). Where
    the sample is thinner than a quarter of the wavelength there is one at most. A branch starts at the lowest
    frequency that has such a one and goes on upwards to the nearest solution in (ln E1, E2/E1), the modulus of the
    last burst carried on by the causal law of constant loss factor.

    **Upper limit.** A glued disc with a free rim does as a rod with the modulus g E while its deformation is that of
    slow compression. The limit (`rod_limit.longest_rod`) is a sample **a quarter of the wavelength thick**, where it
    resonates itself, or where the inertia of its rim makes 10 % of the modulus, if that is before: finite elements say
    where. With nu = 0.3 it is the quarter, at any shape. For the samples of the paper's Table 1 that is at 370 to
    780 Hz; the paper says "around 500 Hz" of its own. Points beyond it are computed and flagged.

    **Standard deviations.** Noise of both channels, the stated uncertainties, and `rod_error`.
    """
    if lateral not in get_args(Lateral):
        raise InputError(f"lateral: '{lateral}' is not allowed; {suggest(lateral, get_args(Lateral))}")
    bounds, tell = bounds or Bounds(), logged(progress)
    methods = {c.name: _Inversion.of(campaign, c, lateral, bounds) for c in campaign.configurations}
    found: dict[tuple[str, float], RodPoint] = {}
    for name, method in methods.items():
        own = sorted((b for b in bursts if b.configuration == name), key=lambda burst: burst.frequency)
        found |= {(name, point.frequency): point for point in method.points(own, tell)}
    return [found[burst.configuration, burst.frequency] for burst in bursts]


def frequency_limit(points: Sequence[RodPoint]) -> float:
    """Return where one configuration's sample becomes too thick for a rod, Hz; infinite if nowhere.

    Parameters
    ----------
    points : sequence of RodPoint
        Of one configuration.
    """
    known = sorted((p for p in points if p.found), key=lambda point: point.frequency)
    beyond = next((i for i, point in enumerate(known) if point.wavelengths > point.reach), None)
    if beyond is None:
        return float("inf")
    pair = known[max(beyond - 1, 0) : beyond + 1]
    if len(pair) == 1:  # not even the lowest burst is within: as if the wave's speed were that of this one
        return float(pair[0].frequency * pair[0].reach / pair[0].wavelengths)
    return float(np.interp(pair[0].reach, [p.wavelengths for p in pair], [p.frequency for p in pair]))


def lateral_factor(campaign: Campaign, configuration: Configuration, lateral: Lateral) -> float:
    """Return the modulus that the rod of a configuration shows, over Young's modulus."""
    nu = campaign.specimen.poisson_ratio
    if lateral == "held":
        return float(np.real(np.asarray(p_wave_modulus(1.0, nu))))
    if lateral == "slender":
        return 1.0
    return static_shape_factor(nu, configuration.specimen_radius / (2 * configuration.specimen_thickness))


@dataclass(frozen=True)
class _Inversion:
    """The method for one configuration; its moduli are those the rod shows until the end."""

    name: str
    rod: Rod
    factor: float
    bounds: Bounds
    known: Uncertainty
    thickness_std: float
    by_shape: float
    inertia: float

    @classmethod
    def of(cls, campaign: Campaign, configuration: Configuration, lateral: Lateral, bounds: Bounds) -> _Inversion:
        mass = campaign.top_plate.density * configuration.top_plate_thickness
        rod = Rod(campaign.specimen.density, configuration.specimen_thickness, mass)
        factor, known = lateral_factor(campaign, configuration, lateral), campaign.uncertainty
        shape = configuration.specimen_radius / (2 * configuration.specimen_thickness)
        nu, thickness_std = campaign.specimen.poisson_ratio, known.thickness / rod.length
        by_shape = slope_by_shape(nu, shape) if lateral == "bonded" else 0.0
        inertia = rim_inertia(nu, shape) if lateral != "held" else 0.0
        return cls(configuration.name, rod, factor, bounds, known, thickness_std, by_shape, inertia)

    @property
    def reach(self) -> float:
        return longest_rod(self.inertia)

    def points(self, bursts: Sequence[BurstData], tell: Callable[[str], None]) -> list[RodPoint]:
        measured, solutions = [], []
        for burst in bursts:
            measured.append(measure(burst, self.known))
            solutions.append(self.solutions(measured[-1]))
            tell(f"{self.name} {burst.frequency:g} Hz: transfer function")
        chosen = follow_branch(self.rod, [m.frequency for m in measured], solutions)
        parts = zip(bursts, measured, solutions, chosen, strict=True)
        return [self.point(*part) for part in parts]

    def solutions(self, measured: Transmissibility) -> Solutions:
        low, high = self.bounds.storage_modulus
        least, most = self.bounds.loss_factor
        storage = self.factor * low, self.factor * high
        return solve(self.rod, measured.frequency, measured.value, storage, (least - _MARGIN, most))

    def point(self, burst: BurstData, measured: Transmissibility, found: Solutions, chosen: complex) -> RodPoint:
        true = chosen / self.factor
        others = tuple(complex(e) / self.factor for e in found.moduli if e != chosen)
        spread, wavelengths = (np.nan, np.nan, np.nan), np.nan
        if np.isfinite(chosen):
            wavelengths = self.rod.phase(measured.frequency, chosen).real / (2 * np.pi)
            spread = _spread(true, self.log_shifts(measured, chosen), rod_error(self.inertia, wavelengths))
        reason, notes = self.reason(burst, wavelengths, found), self.notes(true, spread[0], found)
        return RodPoint(self.name, measured, true, *spread, wavelengths, self.reach, others, reason, notes)

    def log_shifts(self, measured: Transmissibility, modulus: complex) -> ComplexArray:
        """Return what one standard deviation of each cause does to ln E: T, density, thickness, mass."""
        theta, r = self.rod.phase(measured.frequency, modulus), self.rod.mass_ratio
        _, slope = motion(np.array(theta), r)
        by_motion = 2 / (theta * measured.value * slope * np.exp(abs(theta.imag)))
        # at fixed T a heavier mass asks for a stiffer rod; r = M/(rho l), E = rho (w l/theta)^2/g(nu, R/2l)
        by_ratio = -2 * r * np.sin(theta) / (slope * np.exp(abs(theta.imag)))
        stated = [
            (1 - by_ratio) * self.known.density,
            (2 - by_ratio + self.by_shape) * self.thickness_std,
            by_ratio * self.known.top_plate_mass,
        ]
        return np.concatenate([by_motion * measured.log_shifts, np.array(stated, dtype=complex)])

    def reason(self, burst: BurstData, wavelengths: float, found: Solutions) -> str:
        if not np.isfinite(wavelengths):
            why = "continues the branch from below" if len(found.moduli) else "within bounds has this transmissibility"
            return f"no modulus {why}"
        said = []
        if wavelengths > self.reach:
            said.append(f"beyond the rod's limit: {wavelengths:.2f} wavelengths thick, above {self.reach:.2g}")
        if burst.cut_short:
            said.append("the ring-down goes on after the record's end: this is not the transmissibility")
        return "; ".join(said)

    def notes(self, modulus: complex, storage_std: float, found: Solutions) -> list[str]:
        said = []
        if storage_std > _WEAK * modulus.real:
            said.append(f"weak: E1 known to {100 * storage_std / modulus.real:.0f} % only")
        if modulus.imag < self.bounds.loss_factor[0] * modulus.real:
            said.append(f"the loss factor {modulus.imag / modulus.real:.2g} lies below its bound")
        if not found.complete:
            said.append("the count of solutions does not come out: there may be others")
        return said


def _spread(modulus: complex, log_shifts: ComplexArray, model_error: float) -> tuple[float, float, float]:
    """Return the standard deviations of E1, E2 and E2/E1; the rod's own error is taken as independent in E1 and E2."""
    shifts, loss = modulus * log_shifts, modulus.imag / modulus.real
    return (
        float(np.hypot(np.linalg.norm(shifts.real), model_error * modulus.real)),
        float(np.hypot(np.linalg.norm(shifts.imag), model_error * modulus.imag)),
        float(np.hypot((1 + loss**2) * np.linalg.norm(log_shifts.imag), 2**0.5 * model_error * loss)),
    )
