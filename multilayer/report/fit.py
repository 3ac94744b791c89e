"""The report of a fit of a campaign, burst by burst."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from multilayer.fits.methods import BURST_BY_BURST, NELDER_MEAD
from multilayer.fits.result import MODULUS_COLUMNS, FitResult
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign, Uncertainty
from multilayer.number_text import percent, pressure_unit, with_spread
from multilayer.report.files import file_names
from multilayer.report.fit_figures import (
    draw_convergence,
    draw_envelopes,
    draw_gross_check,
    draw_moduli,
    draw_transmissibility,
)
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.report import Draw, Pairs, Picture, Report, Section
from multilayer.rig.shape_factor import static_shape_factor

_PAPER = "P. Bonfiglio & F. Pompoli, Polymer Testing 48 (2015) 89-96"
_LEAST_LOW = 0.02  # share by which E1 is low, below which it is not told
_POOR_CHECK = 0.3  # mean relative error of eq. (12): foams that one law describes stay below
_MOST_ROWS = 24  # bursts that are printed; of more, one row per configuration


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
    figures = _figures(result, campaign, settings)
    means = _means(result, campaign)

    def picture(name: str, caption: str) -> tuple[Picture, ...]:
        return (Picture(partial(figures[name], upright=True), caption),) if name in figures else ()

    return Report(
        name=result.campaign,
        kind="complex modulus, burst by burst",
        label="All accepted" if result.all_accepted else "Not all accepted",
        tone="good" if result.all_accepted else "mind",
        sentence=" ".join(filter(None, (_sentence(result), held := _held_at_its_rim(result, campaign)))),
        facts=_facts(result),
        note=f"Values are {means}, ± one standard deviation. Equation numbers: {_PAPER}.",
        sections=(
            Section(
                "The modulus",
                (
                    *picture("moduli.png", "E1, E2 and loss factor with standard deviations; hollow: not accepted."),
                    *picture(
                        "transmissibility.png", "Top plate over base: measured, and eq. (11) with the modulus found."
                    ),
                ),
            ),
            _bursts(result, held),
            _checks(
                result,
                picture(
                    "gross_check.png",
                    "Points: E2 as found. Lines: E2 as eq. (12) has it from the slope of E1, a check of causality.",
                ),
            ),
        ),
        inputs={**result.settings, "campaign": result.campaign, **inputs},
        tables=result.tables,
        record={**result.to_dict(), "inputs": inputs},
        record_file=result.record_name,
        page="report.html",
        figures=figures,
        accepted=result.all_accepted,
    )


def _figures(result: FitResult, campaign: Campaign, settings: FitSettings) -> dict[str, Draw]:
    """Return what draws the figures by name, those for which the result has data."""
    known = replace(result, bursts=[burst for burst in result.bursts if np.isfinite(burst.storage_modulus)])
    names = known.configurations
    if not names:
        return {}
    signals: dict[str, Draw] = {}
    envelopes: dict[str, Draw] = {}
    if any(len(burst.time) for burst in known.bursts):
        signals["transmissibility.png"] = partial(draw_transmissibility, known, campaign, settings)
        files = (f"envelopes-{name}.png" for name in file_names(names))
        envelopes = {file: partial(draw_envelopes, known, name) for file, name in zip(files, names, strict=True)}
    steps = any(len(burst.history) for burst in known.bursts)
    return {
        "moduli.png": partial(draw_moduli, known, settings),
        **signals,
        "gross_check.png": partial(draw_gross_check, known),
        **({"convergence.png": partial(draw_convergence, known)} if steps else {}),
        **envelopes,
    }


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
    spreads = {}
    for name, key in (("E1", "storage_modulus"), ("E2", "loss_modulus")):
        shares = [getattr(burst, f"{key}_std") / getattr(burst, key) for burst in bursts if getattr(burst, key) > 0]
        if known := list(filter(np.isfinite, shares)):
            spreads[name] = f"{100 * np.median(known):.2g} %"
    checks = [check.mean_relative_error for name in result.configurations if (check := result.gross_check(name))]
    return (
        ("bursts accepted", f"{sum(burst.accepted for burst in bursts)} of {len(bursts)}"),
        *((f"median std of {name}", spread) for name, spread in spreads.items()),
        *([("Gross check, E2 off by", percent(float(np.mean(checks))))] if checks else []),
        ("method", result.method),
    )


def _means(result: FitResult, campaign: Campaign) -> str:
    """Return over what the values are means: as `fits.burst.fit` has the accepted region."""
    if result.method not in BURST_BY_BURST:
        return "best estimates"
    if result.method == NELDER_MEAD or campaign.uncertainty == Uncertainty():
        return "means over all solutions that meet eq. (10)"
    return "means over what noise and the stated uncertainties leave open"


def _held_at_its_rim(result: FitResult, campaign: Campaign) -> str:
    """Return what plane waves leave out of a sample that widens: its free rim; empty where they leave out nothing.

    A disc of S = radius/(2 thickness) is g(nu, S) times as stiff as a free rod, a layer of plane waves, held at its
    rim, (1 - nu)/((1 + nu)(1 - 2 nu)) times: E1 comes out low by the ratio of both, in slow compression.
    """
    nu = campaign.specimen.poisson_ratio
    is_layer = result.method in BURST_BY_BURST and result.settings.get("model") == "plane_wave"
    if nu <= 0 or not is_layer:
        return ""
    held = (1 - nu) / ((1 + nu) * (1 - 2 * nu))
    chosen = [one for one in campaign.configurations if one.name in result.configurations]
    shapes = [one.specimen_radius / (2 * one.specimen_thickness) for one in chosen]
    low = [1 - static_shape_factor(nu, shape) / held for shape in shapes]
    if not low or max(low) < _LEAST_LOW:
        return ""
    ends = dict.fromkeys(f"{100 * share:.0f}" for share in (min(low), max(low)))
    return (
        f"The model holds the sample at its rim, which is free to widen (Poisson's ratio {nu:g}): E1 is low by about "
        f"{' to '.join(ends)} % for this shape (slow compression); --model finite has the free rim."
    )


def _bursts(result: FitResult, held: str = "") -> Section:
    remarks = tuple(filter(None, (held, *result.remarks, *_poor_checks(result))))
    listings = tuple(_listing(result, name) for name in result.configurations)
    if len(result.bursts) <= _MOST_ROWS:
        return Section("Burst by burst", listings=listings, remarks=remarks)
    folded = Section("Every burst", listings=listings)
    listing = _by_configuration(result)
    return Section("Burst by burst", listings=(listing,), remarks=remarks, folded=folded)


def _poor_checks(result: FitResult) -> list[str]:
    """Return a remark for every configuration whose moduli hardly belong to one causal material."""
    told = []
    for name in result.configurations:
        check = result.gross_check(name)
        if check is not None and check.mean_relative_error > _POOR_CHECK:
            share = percent(check.mean_relative_error)
            told.append(
                f"{name}: E2 is off by {share} from what the slope of E1 asks for, eq. (12): something acts that the "
                "model lacks, or E1 changes too fast for this rule; `multilayer diagnose` tells which"
            )
    return told


def _listing(result: FitResult, configuration: str) -> Listing:
    bursts, check = result.of(configuration), result.gross_check(configuration)
    rows = [{**dict(zip(MODULUS_COLUMNS, burst.row(), strict=True)), "remark": burst.remark} for burst in bursts]
    error = 100 * check.mean_relative_error if check else 0.0
    notes = (f"Gross check (eq. 12): mean relative error {error:.0f} %",) if check else ()
    return moduli_listing(rows, caption=f"{result.campaign}: {configuration}", notes=notes)


def moduli_listing(rows: Sequence[Mapping[str, Any]], worst: str = "", **options: Any) -> Listing:
    """Return moduli as rows of ``moduli.csv`` have them, with remarks where a row has any.

    Parameters
    ----------
    rows : sequence of mapping
    worst : str
        Before the headings of differences, where they are the largest of several.
    **options
        Of the listing.
    """
    unit, factor = _unit(row["E1_pa"] for row in rows)
    columns: dict[str, Callable[[Mapping[str, Any]], str]] = {
        ">f / Hz": lambda row: f"{row['frequency_hz']:g}",
        f">E1 / {unit}": lambda row: with_spread(row["E1_pa"] / factor, row["E1_std_pa"] / factor),
        f">E2 / {unit}": lambda row: with_spread(row["E2_pa"] / factor, row["E2_std_pa"] / factor),
        ">loss factor": lambda row: with_spread(row["loss_factor"], row["loss_factor_std"]),
        f">{worst}Δtof / µs": lambda row: _number(1e6 * row["delta_tof_s"], 2),
        f">{worst}Δlevel / dB": lambda row: _number(row["delta_level_db"], 3),
        "accepted": lambda row: yes_or_no(row["accepted"]),
    }
    if any("remark" in row for row in rows):
        columns["remark"] = lambda row: str(row["remark"])
    return Listing.of(rows, columns, **options)


def _number(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else "–"


def _unit(moduli: Iterable[float]) -> tuple[str, float]:
    return pressure_unit(max(filter(np.isfinite, moduli), default=1.0))


def _by_configuration(result: FitResult) -> Listing:
    unit, factor = _unit(burst.storage_modulus for burst in result.bursts)

    def ends(name: str, digits: str, attribute: str, size: float = 1.0) -> str:
        values = [getattr(burst, attribute) / size for burst in result.of(name)]
        solved = [value for value in values if np.isfinite(value)]
        return " to ".join(f"{value:{digits}}" for value in (solved[0], solved[-1])) if solved else "–"

    def check(name: str) -> str:
        gross = result.gross_check(name)
        return percent(gross.mean_relative_error) if gross else "–"

    columns: dict[str, Callable[[str], str]] = {
        "configuration": str,
        ">accepted": lambda name: f"{sum(b.accepted for b in result.of(name))} of {len(result.of(name))}",
        ">f / Hz": lambda name: ends(name, "g", "frequency"),
        f">E1 / {unit}": lambda name: ends(name, ".4g", "storage_modulus", factor),
        f">E2 / {unit}": lambda name: ends(name, ".3g", "loss_modulus", factor),
        ">loss factor": lambda name: ends(name, ".3f", "loss_factor"),
        ">Gross check": check,
    }
    return Listing.of(result.configurations, columns)


def _checks(result: FitResult, pictures: tuple[Picture, ...]) -> Section:
    others = tuple(
        f"{b.configuration}, {b.frequency:g} Hz: E1 = {_shown(s.storage_modulus)}, E2 = {_shown(s.loss_modulus)} meets "
        f"eq. (10) as well (misfit {s.misfit:.3f} against {b.optimum.misfit:.3f})"
        for b in result.bursts
        for s in b.alternatives
    )
    alone = None if others else Section("", remarks=("No burst has a second solution.",))
    return Section("Checks and alternatives", pictures, remarks=others, beside=alone)


def _shown(pressure: float) -> str:
    unit, factor = pressure_unit(pressure)
    return f"{pressure / factor:.3g} {unit}"
