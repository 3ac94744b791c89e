"""The methods that Bonfiglio & Pompoli 2015 compare theirs with: the rod under a mass, and slow compression."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any, get_args

import numpy as np

from multilayer.errors import InputError, suggest
from multilayer.experiments.two_plate.transmissibility import measure
from multilayer.fits.classical.quasi_static import (
    BurstStiffness,
    Compression,
    burst_stiffness,
    slope_by_shape,
    two_shapes,
    young_modulus,
)
from multilayer.fits.classical.transfer_function import Lateral, RodPoint, frequency_limit, transfer_function
from multilayer.fits.methods import CampaignMethod, Progress
from multilayer.fits.result import BurstFit, FitResult, number_or_none
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign, Configuration, Uncertainty

if TYPE_CHECKING:
    from multilayer.fits.sources import FitJob

_NAN = float("nan")


def refuse_pores(settings: FitSettings) -> None:
    """Refuse what the classical methods do not have: air in pores, and the mass of an accelerometer.

    Raises
    ------
    InputError
    """
    given = [name for name in ("pores", "sensor_mass") if getattr(settings, name)]
    if given:
        text = f"{' and '.join(given)}: the classical methods have none of it, so that nothing could be compared"
        raise InputError(f"{text}; leave it out, or use multilayer fit")


@dataclass(frozen=True, repr=False, kw_only=True)
class RodFit(FitResult):
    """Moduli of a rod.

    Attributes
    ----------
    limits : dict
        Frequency above which the sample is too thick for a rod, by configuration, Hz; infinite above all bursts.
    """

    limits: dict[str, float] = field(default_factory=dict)

    @property
    def remarks(self) -> list[str]:
        """What a reader should know of the whole, in sentences."""
        finite = {name: limit for name, limit in self.limits.items() if np.isfinite(limit)}
        told = [f"{name}: a rod up to {f:.0f} Hz, too thick for its wavelength beyond" for name, f in finite.items()]
        return [*told, *super().remarks]

    def contents(self) -> dict[str, Any]:
        """Return what `to_dict` has of this kind of fit."""
        limits = {name: number_or_none(limit) for name, limit in self.limits.items()}
        return {**super().contents(), "transfer_function_limit_hz": limits}


@dataclass(frozen=True)
class TransferFunction(CampaignMethod):
    """The transmissibility of every burst, inverted for a rod under a rigid mass; see `transfer_function`.

    Attributes
    ----------
    lateral : {'bonded', 'slender', 'held'}
        Which modulus the rod's is taken for.
    """

    name = "transfer-function"
    title = "a rod under a mass, eq. (11) inverted"
    summary = "E1 and E2 of a rod under a rigid mass with the measured transmissibility of every burst"
    gives = RodFit

    lateral: Lateral = "bonded"

    def __post_init__(self) -> None:
        if self.lateral not in get_args(Lateral):
            raise InputError(f"--lateral: there is no '{self.lateral}'; {suggest(self.lateral, get_args(Lateral))}")

    def run(self, job: FitJob, tell: Progress) -> RodFit:
        """Return the moduli of the rods."""
        refuse_pores(job.settings)
        try:
            points = transfer_function(job.campaign, job.bursts, self.lateral, job.settings.bounds, tell)
        except InputError as problem:
            raise InputError(f"{problem}; lateral: slender does without a shape factor") from None
        limits = {
            configuration.name: frequency_limit([p for p in points if p.configuration == configuration.name])
            for configuration in job.campaign.configurations
        }
        return RodFit(
            name=job.name, method=self.name, settings=job.plain_settings(), bursts=[*map(_of_rod, points)],
            limits=limits,
        )  # fmt: skip


def _of_rod(point: RodPoint) -> BurstFit:
    e, shown = point.modulus, point.transmissibility.value
    return BurstFit(
        point.configuration, point.frequency, e.real, point.storage_modulus_std, e.imag, point.loss_modulus_std,
        e.imag / e.real, point.loss_factor_std, accepted=not point.reason, reason=point.reason, notes=point.notes,
        measured_transmissibility=shown, modelled_transmissibility=shown if point.found else complex(_NAN),
    )  # fmt: skip


class QuasiStatic(CampaignMethod):
    """Slow compression: what a fit file states of it, and bursts far below the resonance."""

    name = "quasi-static"
    title = "slow compression"
    summary = "E1 and E2 from the stiffness in slow compression, as stated in the fit file or of very low bursts"

    def number_of_steps(self, job: FitJob) -> int:
        """Return how often `run` reports progress."""
        return 0

    def run(self, job: FitJob, tell: Progress) -> FitResult:
        """Return the moduli that are known from slow compression, and what pairs of shapes say of Poisson's ratio."""
        refuse_pores(job.settings)
        bursts = []
        if (given := job.settings.quasi_static) is not None:
            values = given.storage_modulus, _NAN, given.loss_modulus, _NAN
            loss = given.loss_modulus / given.storage_modulus, _NAN
            bursts = [
                BurstFit(configuration.name, given.frequency, *values, *loss, notes=["given in the fit file"])
                for configuration in job.campaign.configurations
            ]
        slow = _slow_bursts(job)
        if job.campaign.specimen.poisson_ratio >= 0:
            bursts += [_of_slow(job.campaign, c, stiffness) for c, stiffnesses in slow for stiffness in stiffnesses]
        notes = _of_two_shapes(slow, job.campaign.uncertainty)
        if not bursts and not notes:
            raise InputError("no quasi_static values in a fit file, and no burst below a tenth of the resonance")
        return FitResult(job.name, self.name, job.plain_settings(), bursts, notes=notes)


def _slow_bursts(job: FitJob) -> list[tuple[Configuration, list[BurstStiffness]]]:
    """Return the stiffnesses that bursts far below the resonance show, by configuration."""
    campaign, slow = job.campaign, []
    for configuration in campaign.configurations:
        top, sample = _masses(campaign, configuration)
        measured = [measure(b, campaign.uncertainty) for b in job.bursts if b.configuration == configuration.name]
        shown = [burst_stiffness(m, top, sample) for m in measured]
        slow.append((configuration, [s for s in shown if s.quasi_static and s.stiffness.real > 0]))
    return slow


def _masses(campaign: Campaign, configuration: Configuration) -> tuple[float, float]:
    """Return the masses of top plate and sample, kg."""
    area = np.pi * configuration.specimen_radius**2
    top = area * configuration.top_plate_thickness * campaign.top_plate.density
    return top, area * configuration.specimen_thickness * campaign.specimen.density


def _of_two_shapes(slow: Sequence[tuple[Configuration, list[BurstStiffness]]], known: Uncertainty) -> list[str]:
    """Return what pairs of configurations of different shape say of Poisson's ratio."""
    discs = {configuration.name: _disc(configuration, bursts[0], known) for configuration, bursts in slow if bursts}
    told = []
    for (first, disc), (second, other) in combinations(discs.items(), 2):
        pair = f"{first} and {second}, quasi-static"
        try:
            shapes = two_shapes(disc, other)
        except InputError as problem:
            told.append(f"{pair}: {problem}")
            continue
        text = f"nu = {shapes.poisson_ratio:.3f} ± {shapes.poisson_ratio_std:.3f}, E1 = {shapes.young_modulus.real:.4g}"
        told.append("; ".join([f"{pair}: {text} Pa", *shapes.remarks]))
    return told


def _disc(configuration: Configuration, slow: BurstStiffness, known: Uncertainty) -> Compression:
    radius, thickness = configuration.specimen_radius, configuration.specimen_thickness
    # a stiffness known to no better than itself says nothing, but is no mistake of the user's
    std = min(slow.relative_std, 0.99)
    return Compression(slow.stiffness, radius, thickness, std, thickness_std=known.thickness / thickness)


def _of_slow(campaign: Campaign, configuration: Configuration, slow: BurstStiffness) -> BurstFit:
    radius, thickness = configuration.specimen_radius, configuration.specimen_thickness
    e = young_modulus(slow.stiffness, radius, thickness, campaign.specimen.poisson_ratio)
    loss = e.imag / e.real
    stated = _stated_std(campaign, configuration)
    note = f"from a burst far below the resonance of {slow.resonance:.4g} Hz"
    return BurstFit(
        configuration.name, slow.frequency, e.real, float(np.hypot(slow.relative_std, stated)) * e.real,
        e.imag, float(np.hypot(slow.loss_std * e.real, stated * e.imag)), loss,
        float(np.hypot(slow.loss_std, loss * slow.relative_std)), notes=[note],
    )  # fmt: skip


def _stated_std(campaign: Campaign, configuration: Configuration) -> float:
    """Return the relative standard deviation of E from what is stated of masses and thickness.

    ``E = w^2 (M + m/2) T/(T - 1) h/(pi R^2 g(nu, R/2h))``, m growing with the thickness h; E2/E1 does not move.
    """
    top, sample = _masses(campaign, configuration)
    of_sample = sample / 2 / (top + sample / 2)
    known, thickness = campaign.uncertainty, configuration.specimen_thickness
    by_shape = slope_by_shape(campaign.specimen.poisson_ratio, configuration.specimen_radius / (2 * thickness))
    by_thickness = 1 + by_shape + of_sample
    parts = (
        (1 - of_sample) * known.top_plate_mass,
        of_sample * known.density,
        by_thickness * known.thickness / thickness,
    )
    return float(np.linalg.norm(parts))
