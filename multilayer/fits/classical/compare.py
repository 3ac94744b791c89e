"""The methods that Bonfiglio & Pompoli 2015 compare, side by side on one campaign."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import Any

import numpy as np

from multilayer.errors import InputError
from multilayer.experiments.two_plate.burst import BurstData
from multilayer.experiments.two_plate.transmissibility import measure
from multilayer.fits.burst.fit import burst_problems, fit_campaign, number_of_steps
from multilayer.fits.classical.comparison import METHODS, MethodComparison, MethodPoint
from multilayer.fits.classical.quasi_static import (
    BurstStiffness,
    Compression,
    burst_stiffness,
    two_shapes,
    young_modulus,
)
from multilayer.fits.classical.transfer_function import Lateral, RodPoint, frequency_limit, transfer_function
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign, Configuration, Uncertainty
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

Progress = Callable[[str], None]


def compare_methods(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
    *,
    nelder_mead: bool = False,
    lateral: Lateral = "bonded",
    progress: Progress | None = None,
) -> MethodComparison:
    """Find the moduli of a campaign's specimen by every method.

    Parameters
    ----------
    campaign : Campaign
    recordings : mapping
        Signals by (configuration name, frequency).
    settings : FitSettings, optional
        Bounds, acceptance, quasi-static values and the like; its `method` and `model` do not matter, but
        ``method: nelder-mead`` has that one among the methods.
    calibration : Calibration, optional
        Removed from the top channel.
    nelder_mead : bool
        Whether to run the paper's own minimisation, too: many times slower than the rest.
    lateral : {'bonded', 'slender', 'held'}
        See `transfer_function.transfer_function`.
    progress : callable, optional
        Called with a short text after every step; see `number_of_steps_of_all`.

    Returns
    -------
    MethodComparison

    Raises
    ------
    InputError
        For settings with pores or the mass of an accelerometer, which the classical methods do not have.
    """
    settings = settings or FitSettings()
    run = _Run(campaign, recordings, settings, calibration, progress or (lambda text: None))
    with_nelder_mead = nelder_mead or settings.method == "nelder-mead"
    points: list[MethodPoint] = []
    left_out: dict[str, str] = {}
    for name, fit in run.fits(with_nelder_mead).items():
        try:
            points += run.fitted(name, *fit)
        except InputError as problem:
            left_out[name] = str(problem)
    if campaign.uncertainty == Uncertainty():
        left_out["eq-10"] = "the campaign states no uncertainties, so that plane-wave has the region of eq. (10) itself"
    if not with_nelder_mead:
        left_out["nelder-mead"] = "not asked for: it is slow"
    rod: list[RodPoint] = []
    try:
        rod = transfer_function(campaign, run.bursts, lateral, settings.bounds, run.tell)
    except InputError as problem:
        left_out["transfer-function"] = f"{problem}; lateral: slender does without a shape factor"
    slow, remarks = run.quasi_static()
    points += [_rod_point(point) for point in rod] + slow
    limits = {c.name: frequency_limit([p for p in rod if p.configuration == c.name]) for c in campaign.configurations}
    if not slow:
        left_out["quasi-static"] = "no quasi_static values in a fit file, and no burst below a tenth of the resonance"
    ordered = _in_order(points, [c.name for c in campaign.configurations])
    return MethodComparison(campaign.folder.resolve().name, ordered, limits if rod else {}, left_out, remarks)


def number_of_steps_of_all(campaign: Campaign, settings: FitSettings, *, nelder_mead: bool = False) -> int:
    """Return how often `compare_methods` reports progress."""
    run = _Run(campaign, {}, settings, None, lambda text: None)
    fits = run.fits(nelder_mead or settings.method == "nelder-mead").values()
    bursts = sum(len(configuration.bursts) for configuration in campaign.configurations)
    return bursts + sum(number_of_steps(*fit) for fit in fits)


def _in_order(points: Sequence[MethodPoint], configurations: list[str]) -> list[MethodPoint]:
    names = list(METHODS)

    def place(point: MethodPoint) -> tuple[int, float, int]:
        return configurations.index(point.configuration), point.frequency, names.index(point.method)

    return sorted(points, key=place)


@dataclass(frozen=True)
class _Run:
    """One campaign, and what every method needs of it."""

    campaign: Campaign
    recordings: Mapping[tuple[str, float], Recording]
    settings: FitSettings
    calibration: Calibration | None
    tell: Progress

    def fits(self, nelder_mead: bool) -> dict[str, tuple[Campaign, FitSettings]]:
        """Return the campaign and the settings of every burst-by-burst fit."""
        plane = self.with_settings(method="least-squares", model="plane_wave")
        fits = {"plane-wave": (self.campaign, plane)}
        if self.campaign.uncertainty != Uncertainty():
            # without stated uncertainties a fit takes the region that eq. (10) accepts
            fits["eq-10"] = (self.campaign.model_copy(update={"uncertainty": Uncertainty()}), plane)
        # the finite model has no air above
        finite = self.with_settings(method="least-squares", model="finite", termination=None)
        fits["finite"] = (self.campaign, finite)
        if nelder_mead:
            fits["nelder-mead"] = (self.campaign, self.with_settings(method="nelder-mead", model="plane_wave"))
        return fits

    def __post_init__(self) -> None:
        given = [name for name in ("pores", "sensor_mass") if getattr(self.settings, name)]
        if given:
            text = f"{' and '.join(given)}: the classical methods have none of it, so that nothing could be compared"
            raise InputError(f"{text}; leave it out, or use multilayer fit")

    def with_settings(self, **changes: Any) -> FitSettings:
        return FitSettings.model_validate({**self.settings.model_dump(), **changes})

    def fitted(self, method: str, campaign: Campaign, settings: FitSettings) -> list[MethodPoint]:
        """Return the points of a burst-by-burst fit."""

        def tell(text: str) -> None:
            self.tell(f"{method}: {text}")

        result = fit_campaign(campaign, self.recordings, settings, self.calibration, tell)
        return [
            MethodPoint(
                b.configuration, b.frequency, method, b.storage_modulus, b.storage_modulus_std, b.loss_modulus,
                b.loss_modulus_std, b.loss_factor_std, b.accepted, b.remark,
            )
            for b in result.bursts
        ]  # fmt: skip

    @cached_property
    def bursts(self) -> list[BurstData]:
        """Measured signals, averaged and calibrated."""
        problems = burst_problems(self.campaign, self.recordings, self.settings, self.calibration)
        return [problem.data for problem in problems]

    def quasi_static(self) -> tuple[list[MethodPoint], list[str]]:
        """Return what is known of slow compression: from the fit file, and from bursts far below the resonance."""
        points = []
        if (given := self.settings.quasi_static) is not None:
            nan, said = float("nan"), "given in the fit file"
            points = [
                MethodPoint(
                    c.name, given.frequency, "quasi-static", given.storage_modulus, nan, given.loss_modulus, nan,
                    remark=said,
                )
                for c in self.campaign.configurations
            ]  # fmt: skip
        slow = self.slow_bursts()
        nu = self.campaign.specimen.poisson_ratio
        if nu >= 0:
            points += [_slow_point(c, s, nu) for c, stiffnesses in slow for s in stiffnesses]
        return points, self.two_shapes(slow)

    def slow_bursts(self) -> list[tuple[Configuration, list[BurstStiffness]]]:
        found = []
        for c in self.campaign.configurations:
            area = np.pi * c.specimen_radius**2
            top = area * c.top_plate_thickness * self.campaign.top_plate.density
            own = area * c.specimen_thickness * self.campaign.specimen.density
            measured = [measure(b, self.campaign.uncertainty) for b in self.bursts if b.configuration == c.name]
            all_of_it = [burst_stiffness(m, top, own) for m in measured]
            found.append((c, [s for s in all_of_it if s.quasi_static and s.stiffness.real > 0]))
        return found

    def two_shapes(self, slow: Sequence[tuple[Configuration, list[BurstStiffness]]]) -> list[str]:
        """Return what pairs of configurations of different shape say of Poisson's ratio."""
        discs = {c.name: _disc(c, s[0], self.campaign.uncertainty) for c, s in slow if s}
        said = []
        for (one, first), (other, second) in combinations(discs.items(), 2):
            try:
                found = two_shapes(first, second)
            except InputError as problem:
                said.append(f"{one} and {other}, quasi-static: {problem}")
                continue
            text = (
                f"nu = {found.poisson_ratio:.3f} ± {found.poisson_ratio_std:.3f}, E1 = {found.young_modulus.real:.4g}"
            )
            said.append("; ".join([f"{one} and {other}, quasi-static: {text} Pa", *found.remarks]))
        return said


def _disc(configuration: Configuration, slow: BurstStiffness, known: Uncertainty) -> Compression:
    radius, thickness = configuration.specimen_radius, configuration.specimen_thickness
    # a stiffness known to no better than itself says nothing, but is no mistake of the user's
    std = min(slow.relative_std, 0.99)
    return Compression(slow.stiffness, radius, thickness, std, thickness_std=known.thickness / thickness)


def _slow_point(configuration: Configuration, slow: BurstStiffness, poisson_ratio: float) -> MethodPoint:
    radius, thickness = configuration.specimen_radius, configuration.specimen_thickness
    e = young_modulus(slow.stiffness, radius, thickness, poisson_ratio)
    stds = slow.relative_std * e.real, slow.loss_std * e.real
    loss_std = float(np.hypot(slow.loss_std, e.imag / e.real * slow.relative_std))
    remark = f"from a burst far below the resonance of {slow.resonance:.4g} Hz"
    return MethodPoint(
        configuration.name, slow.frequency, "quasi-static", e.real, stds[0], e.imag, stds[1], loss_std, remark=remark
    )


def _rod_point(point: RodPoint) -> MethodPoint:
    e = point.modulus
    return MethodPoint(
        point.configuration, point.frequency, "transfer-function", e.real, point.storage_modulus_std, e.imag,
        point.loss_modulus_std, point.loss_factor_std, not point.reason, point.remark,
    )  # fmt: skip
