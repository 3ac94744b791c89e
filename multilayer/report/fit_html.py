"""The report of a fit of a campaign, burst by burst."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from multilayer.fits.result import BurstFit, FitResult
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.report.fit_figures import draw_gross_check, draw_moduli, draw_transmissibility
from multilayer.report.html import Page, Picture, Section, page_html, picture
from multilayer.report.listing import Listing
from multilayer.report.numbers import burst_numbers, percent, pressure_unit
from multilayer.report.style import figure_style

_MOST_ROWS = 24  # bursts that are printed; of more, one row per configuration
_MOST_REMARKS = 12
_HEADINGS = ("f / Hz", "E1 / {0}", "E2 / {0}", "E2/E1", "Δtof / µs", "Δlevel / dB", "accepted", "remark")


def fit_html(result: FitResult, campaign: Campaign, settings: FitSettings, inputs: Mapping[str, Any]) -> str:
    """Return the report of a fit as an HTML file.

    Parameters
    ----------
    result : FitResult
    campaign : Campaign
        The campaign the result belongs to.
    settings : FitSettings
        Of the fit.
    inputs : mapping
        What else tells the fit apart from others, as its fingerprint.
    """
    accepted = sum(burst.accepted for burst in result.bursts)
    page = Page(
        name=result.campaign,
        kind="complex modulus, burst by burst",
        label="All accepted" if result.all_accepted else "Not all accepted",
        good=result.all_accepted,
        sentence=_sentence(result, accepted),
        facts=_facts(result, accepted),
        sections=(
            Section("The modulus", pictures=_pictures(result, campaign, settings)),
            _bursts(result),
            _checks(result),
        ),
        inputs={**result.settings, "campaign": result.campaign, **inputs},
        note="Values are means over all solutions that meet eq. (10), ± one standard deviation.",
    )
    return page_html(page)


def moduli_span(e1: Sequence[float], loss: Sequence[float], frequency: Sequence[float]) -> str:
    """Return what moduli do from the lowest to the highest frequency, in words."""
    unit, factor = pressure_unit(max(e1))
    low, high = int(np.argmin(frequency)), int(np.argmax(frequency))
    if low == high:
        return f"E1 is {e1[low] / factor:.3g} {unit} and the loss factor {loss[low]:.2g} at {frequency[low]:g} Hz"
    return (
        f"from {frequency[low]:g} to {frequency[high]:g} Hz E1 goes from {e1[low] / factor:.3g} to "
        f"{e1[high] / factor:.3g} {unit}, the loss factor from {loss[low]:.2g} to {loss[high]:.2g}"
    )


def _sentence(result: FitResult, accepted: int) -> str:
    n = len(result.bursts)
    bursts = [burst for burst in result.bursts if burst.accepted]
    if not bursts:
        return f"None of the {n} bursts has an accepted solution: model and measurement disagree."
    whole = "All" if accepted == n else f"{accepted} of"
    span = moduli_span(*([getattr(b, k) for b in bursts] for k in ("storage_modulus", "loss_factor", "frequency")))
    return f"{whole} {n} bursts have an accepted solution: {span}."


def _facts(result: FitResult, accepted: int) -> tuple[tuple[str, str], ...]:
    bursts = result.bursts
    spread = [
        float(np.median([getattr(b, f"{k}_std") / getattr(b, k) for b in bursts if getattr(b, k) > 0] or [np.nan]))
        for k in ("storage_modulus", "loss_modulus")
    ]
    checks = [check.mean_relative_error for name in result.configurations if (check := result.gross_check(name))]
    facts = [("bursts accepted", f"{accepted} of {len(bursts)}")]
    facts += [(f"median std of {name}", f"{100 * s:.2g} %") for name, s in zip(("E1", "E2"), spread, strict=True)]
    if checks:
        facts.append(("Gross check, E2 off by", percent(float(np.mean(checks)))))
    return (*facts, ("method", result.method))


def _pictures(result: FitResult, campaign: Campaign, settings: FitSettings) -> tuple[Picture, ...]:
    with figure_style(compact=True):
        moduli = draw_moduli(result, settings, upright=True)
        motion = draw_transmissibility(result, campaign, settings, upright=True)
        return (
            picture(moduli, "moduli", "E1, E2 and loss factor with standard deviations; hollow: not accepted."),
            picture(motion, "transmissibility", "Top plate over base: measured, and eq. (11) with the modulus found."),
        )


def _bursts(result: FitResult) -> Section:
    tables = tuple((_listing(result.of(name)), name) for name in result.configurations)
    if len(result.bursts) <= _MOST_ROWS:
        return Section("Burst by burst", listings=tables)
    return Section(
        "Burst by burst", listings=((_by_configuration(result), ""),), folded=Section("Every burst", listings=tables)
    )


def _listing(bursts: Sequence[BurstFit]) -> Listing:
    unit, factor = pressure_unit(max(burst.storage_modulus for burst in bursts))
    rows = tuple((*burst_numbers(b, factor), "yes" if b.accepted else "no", b.remark) for b in bursts)
    return Listing(tuple(heading.format(unit) for heading in _HEADINGS), rows, tuple(range(6))).filled()


def _by_configuration(result: FitResult) -> Listing:
    unit, factor = pressure_unit(max(burst.storage_modulus for burst in result.bursts))
    rows = []
    for name in result.configurations:
        bursts, check = result.of(name), result.gross_check(name)
        ends = (bursts[0], bursts[-1])
        rows.append(
            (
                name,
                f"{sum(b.accepted for b in bursts)} of {len(bursts)}",
                " to ".join(f"{b.frequency:g}" for b in ends),
                " to ".join(f"{b.storage_modulus / factor:.4g}" for b in ends),
                " to ".join(f"{b.loss_modulus / factor:.3g}" for b in ends),
                " to ".join(f"{b.loss_factor:.3f}" for b in ends),
                percent(check.mean_relative_error) if check else "–",
            )
        )
    headings = ("configuration", "accepted", "f / Hz", f"E1 / {unit}", f"E2 / {unit}", "E2/E1", "Gross check")
    return Listing(headings, tuple(rows), tuple(range(1, 7)))


def _checks(result: FitResult) -> Section:
    with figure_style(compact=True):
        gross = draw_gross_check(result, upright=True)
        caption = "Points: E2 as found. Lines: E2 as eq. (12) has it from the slope of E1, a check of causality."
        shown = picture(gross, "gross_check", caption)
    others = [
        f"{b.configuration}, {b.frequency:g} Hz: E1 = {_shown(s.storage_modulus)}, E2 = {_shown(s.loss_modulus)} meets "
        f"eq. (10) as well (misfit {s.misfit:.3f} against {b.optimum.misfit:.3f})."
        for b in result.bursts
        for s in b.alternatives
    ]
    left = len(others) - _MOST_REMARKS
    told = [*others[:_MOST_REMARKS], f"{left} more, see fit.json."] if left > 0 else others
    return Section("Checks and alternatives", (shown,), remarks=tuple(told or ["No burst has a second solution."]))


def _shown(pressure: float) -> str:
    unit, factor = pressure_unit(pressure)
    return f"{pressure / factor:.3g} {unit}"
