"""The report of a fit of a campaign, burst by burst."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from multilayer.fits.burst.result import BurstFit, FitResult
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.report.files import file_names
from multilayer.report.fit_figures import (
    draw_convergence,
    draw_envelopes,
    draw_gross_check,
    draw_moduli,
    draw_transmissibility,
)
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.numbers import percent, pressure_unit, with_spread
from multilayer.report.report import Pairs, Picture, Report, Section

_MOST_ROWS = 24  # bursts that are printed; of more, one row per configuration
_HEADINGS = ("f / Hz", "E1 / {0}", "E2 / {0}", "loss factor", "Δtof / µs", "Δlevel / dB", "accepted", "remark")


def burst_report(result: FitResult, campaign: Campaign, settings: FitSettings, inputs: Mapping[str, Any]) -> Report:
    """Return the report of a fit.

    Parameters
    ----------
    result : FitResult
    campaign : Campaign
        The campaign the result belongs to: its geometry enters eq. (11).
    settings : FitSettings
        Of the fit.
    inputs : mapping
        What tells the fit apart from others, as its fingerprint.
    """
    names = result.configurations
    figures = {
        "moduli.png": partial(draw_moduli, result, settings),
        "transmissibility.png": partial(draw_transmissibility, result, campaign, settings),
        "gross_check.png": partial(draw_gross_check, result),
    }
    if any(len(burst.history) for burst in result.bursts):
        figures["convergence.png"] = partial(draw_convergence, result)
    for name, file_name in zip(names, file_names(names), strict=True):
        if all(len(burst.time) for burst in result.of(name)):
            figures[f"envelopes-{file_name}.png"] = partial(draw_envelopes, result, name)
    return Report(
        name=result.campaign,
        kind="complex modulus, burst by burst",
        label="All accepted" if result.all_accepted else "Not all accepted",
        tone="good" if result.all_accepted else "mind",
        sentence=_sentence(result),
        facts=_facts(result),
        note="Values are means over all solutions that meet eq. (10), ± one standard deviation.",
        sections=(
            Section(
                "The modulus",
                (
                    Picture(
                        partial(draw_moduli, result, settings, upright=True),
                        "E1, E2 and loss factor with standard deviations; hollow: not accepted.",
                    ),
                    Picture(
                        partial(draw_transmissibility, result, campaign, settings, upright=True),
                        "Top plate over base: measured, and eq. (11) with the modulus found.",
                    ),
                ),
            ),
            _bursts(result),
            _checks(result),
        ),
        inputs={**result.settings, "campaign": result.campaign, **inputs},
        tables={"moduli.csv": result.to_csv()},
        record={**result.to_dict(), "inputs": inputs},
        record_file="fit.json",
        page="report.html",
        figures=figures,
        accepted=result.all_accepted,
    )


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


def _sentence(result: FitResult) -> str:
    n = len(result.bursts)
    bursts = [burst for burst in result.bursts if burst.accepted]
    if not bursts:
        return f"None of the {n} bursts has an accepted solution: model and measurement disagree."
    whole = "All" if len(bursts) == n else f"{len(bursts)} of"
    span = moduli_span(*([getattr(b, k) for b in bursts] for k in ("storage_modulus", "loss_factor", "frequency")))
    return f"{whole} {n} bursts have an accepted solution: {span}."


def _facts(result: FitResult) -> Pairs:
    bursts = result.bursts
    spread = [
        float(np.median([getattr(b, f"{k}_std") / getattr(b, k) for b in bursts if getattr(b, k) > 0] or [np.nan]))
        for k in ("storage_modulus", "loss_modulus")
    ]
    checks = [check.mean_relative_error for name in result.configurations if (check := result.gross_check(name))]
    return (
        ("bursts accepted", f"{sum(burst.accepted for burst in bursts)} of {len(bursts)}"),
        *((f"median std of {name}", f"{100 * s:.2g} %") for name, s in zip(("E1", "E2"), spread, strict=True)),
        *([("Gross check, E2 off by", percent(float(np.mean(checks))))] if checks else []),
        ("method", result.method),
    )


def _bursts(result: FitResult) -> Section:
    listings = tuple(_listing(result, name) for name in result.configurations)
    if len(result.bursts) <= _MOST_ROWS:
        return Section("Burst by burst", listings=listings)
    folded = Section("Every burst", listings=listings)
    return Section("Burst by burst", listings=(_by_configuration(result),), folded=folded)


def _listing(result: FitResult, configuration: str) -> Listing:
    bursts, check = result.of(configuration), result.gross_check(configuration)
    unit, factor = _unit(bursts)
    rows = tuple((*_numbers(burst, factor), yes_or_no(burst.accepted), burst.remark) for burst in bursts)
    error = 100 * check.mean_relative_error if check else 0.0
    notes = (f"Gross check (eq. 12): mean relative error {error:.0f} %",) if check else ()
    caption = f"{result.campaign}: {configuration}"
    return Listing(tuple(heading.format(unit) for heading in _HEADINGS), rows, tuple(range(6)), caption, notes)


def _unit(bursts: Sequence[BurstFit]) -> tuple[str, float]:
    known = [burst.storage_modulus for burst in bursts if np.isfinite(burst.storage_modulus)]
    return pressure_unit(max(known, default=1.0))


def _numbers(burst: BurstFit, factor: float) -> tuple[str, ...]:
    return (
        f"{burst.frequency:g}",
        with_spread(burst.storage_modulus / factor, burst.storage_modulus_std / factor),
        with_spread(burst.loss_modulus / factor, burst.loss_modulus_std / factor),
        with_spread(burst.loss_factor, burst.loss_factor_std),
        f"{1e6 * burst.delta_tof:.2f}" if np.isfinite(burst.delta_tof) else "",
        f"{burst.delta_level_db:.3f}" if np.isfinite(burst.delta_level_db) else "",
    )


def _by_configuration(result: FitResult) -> Listing:
    unit, factor = _unit(result.bursts)
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
    headings = ("configuration", "accepted", "f / Hz", f"E1 / {unit}", f"E2 / {unit}", "loss factor", "Gross check")
    return Listing(headings, tuple(rows), tuple(range(1, 7)))


def _checks(result: FitResult) -> Section:
    others = tuple(
        f"{b.configuration}, {b.frequency:g} Hz: E1 = {_shown(s.storage_modulus)}, E2 = {_shown(s.loss_modulus)} meets "
        f"eq. (10) as well (misfit {s.misfit:.3f} against {b.optimum.misfit:.3f})"
        for b in result.bursts
        for s in b.alternatives
    )
    caption = "Points: E2 as found. Lines: E2 as eq. (12) has it from the slope of E1, a check of causality."
    alone = None if others else Section("", remarks=("No burst has a second solution.",))
    picture = Picture(partial(draw_gross_check, result, upright=True), caption)
    return Section("Checks and alternatives", (picture,), remarks=others, beside=alone)


def _shown(pressure: float) -> str:
    unit, factor = pressure_unit(pressure)
    return f"{pressure / factor:.3g} {unit}"
