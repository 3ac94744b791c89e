"""All inverse methods that give moduli at bursts, side by side on one campaign."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import Any

from multilayer.errors import InputError
from multilayer.fits.classical.comparison import MethodComparison, MethodPoint
from multilayer.fits.classical.methods import RodFit, refuse_pores
from multilayer.fits.methods import METHODS, CampaignMethod, Compared, Progress
from multilayer.fits.result import FitResult
from multilayer.fits.settings import FitSettings
from multilayer.fits.sources import FitJob
from multilayer.measurements.description import Campaign
from multilayer.signals.calibration import Calibration
from multilayer.signals.recording import Recording

# as the paper has them; what else is registered follows by its name
_ORDER = ("least-squares", "nelder-mead", "transfer-function", "quasi-static")
_NOT_ASKED = "not asked for: it is slow"


def compare_methods(
    campaign: Campaign,
    recordings: Mapping[tuple[str, float], Recording],
    settings: FitSettings | None = None,
    calibration: Calibration | None = None,
    *,
    slow: bool = False,
    lateral: str = "bonded",
    progress: Progress | None = None,
) -> MethodComparison:
    """Find the moduli of a campaign's specimen by every method.

    Parameters
    ----------
    campaign : Campaign
    recordings : mapping
        Signals by (configuration name, frequency).
    settings : FitSettings, optional
        Bounds, acceptance, quasi-static values and the like; its `model` does not matter, and its `method` only where
        that is a slow one, which is then among the methods.
    calibration : Calibration, optional
        Removed from the top channel.
    slow : bool
        Whether to run slow methods, too, as the paper's own minimisation.
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
    job = FitJob(campaign, recordings, settings or FitSettings(), calibration)
    refuse_pores(job.settings)
    every, tell = list(_all(job, slow, {"lateral": lateral})), progress or (lambda text: None)
    results: dict[str, FitResult] = {}
    left_out: dict[str, str] = {}
    titles: dict[str, str] = {}
    for method, name, compared in every:
        titles[name] = compared.title
        if compared.job is None:
            left_out[name] = compared.reason
            continue
        try:
            results[name] = method.run(compared.job, partial(_tell_of, name, tell))
        except InputError as problem:
            left_out[name] = str(problem)
    names, configurations = list(titles), [configuration.name for configuration in campaign.configurations]
    points = [MethodPoint.of(name, burst) for name, result in results.items() for burst in result.bursts]
    points.sort(key=lambda p: (configurations.index(p.configuration), p.frequency, names.index(p.method)))
    limits = [result.limits for result in results.values() if isinstance(result, RodFit)]
    remarks = [note for result in results.values() for note in result.notes]
    return MethodComparison(job.name, points, limits[0] if limits else {}, left_out, remarks, titles)


def number_of_steps_of_all(campaign: Campaign, settings: FitSettings, *, slow: bool = False) -> int:
    """Return how often `compare_methods` reports progress."""
    every = _all(FitJob(campaign, {}, settings, None), slow, {})
    return sum(method.number_of_steps(compared.job) for method, _, compared in every if compared.job is not None)


def _tell_of(name: str, tell: Progress, text: str) -> None:
    tell(f"{name}: {text}")


def _all(job: FitJob, slow: bool, options: Mapping[str, Any]) -> Iterator[tuple[CampaignMethod, str, Compared]]:
    """Give every registered method with what it compares; a broken plugin is left out with a `PluginWarning`."""
    kinds = {name: kind for name, kind in METHODS.working() if issubclass(kind, CampaignMethod)}
    for key in sorted(kinds, key=lambda name: (_ORDER.index(name) if name in _ORDER else len(_ORDER), name)):
        method = kinds[key].with_options(options)
        left_out = method.slow and not slow and job.settings.method != key
        for name, compared in method.compared(job).items():
            yield method, name, Compared(compared.title, None, _NOT_ASKED) if left_out else compared
