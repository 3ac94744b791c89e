"""The reports of a simulation and of a comparison with measured spectra."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np

from multilayer.report.html import Page, Picture, Section, page_html, picture
from multilayer.report.listing import Listing
from multilayer.report.numbers import percent
from multilayer.report.simulation_figures import DRAWN, draw_quantity
from multilayer.report.simulation_table import cell, rows_of
from multilayer.report.style import figure_style
from multilayer.simulation.compare import Comparison, Misfit
from multilayer.simulation.quantities import QUANTITIES, Quantity
from multilayer.simulation.result import CaseResult, SimulationResult

_MOST_CASES = 6  # columns of a table; of more cases, their means
_MOST_LISTED = 30
_MOST_PICTURES = 4
_FIRST = ("insertion_loss", "transmission_loss", "absorption")  # what a simulation is made for, if it has it


def simulation_html(result: SimulationResult) -> str:
    """Return the report of a simulation as an HTML file."""
    main = next(QUANTITIES[name] for name in _FIRST if name in result.cases[0].quantities)
    pictures = _pictures(result, [name for name in DRAWN if any(name in case.quantities for case in result.cases)])
    tables = _tables(result, main)
    page = Page(
        name=result.name,
        kind="simulation",
        label="Simulation",
        good=None,
        sentence=_sentence(result, main),
        facts=_facts(result, main),
        sections=(Section("Over frequency", pictures), tables),
        inputs=result.settings,
        note=_note(result),
    )
    return page_html(page)


def comparison_html(comparison: Comparison) -> str:
    """Return the report of a comparison as an HTML file."""
    predicted, best = comparison.predicted, min(comparison.misfits, key=lambda one: one.rms)
    pictures = _pictures(predicted, comparison.quantities, comparison)
    misfits = comparison.misfits
    table = Section("How far apart", listings=((_misfits(misfits[:_MOST_LISTED]), ""),), remarks=_left_out(comparison))
    page = Page(
        name=f"{comparison.measured.name} over {predicted.name}",
        kind="comparison",
        label="Comparison",
        good=None,
        sentence=_told(best, len(misfits)),
        facts=(
            ("frequencies", f"{len(predicted.frequency)}"),
            ("from", f"{predicted.frequency[0]:g} Hz"),
            ("to", f"{predicted.frequency[-1]:g} Hz"),
            ("cases", f"{len(predicted.cases)}"),
        ),
        sections=(Section("Measured over predicted", pictures), table),
        inputs={"measured": comparison.measured.name, **predicted.settings},
        note=_note(predicted),
    )
    return page_html(page)


def _mean(case: CaseResult, quantity: Quantity) -> float:
    return float(quantity.mean(case.quantities[quantity.name]))


def _shown(value: float, quantity: Quantity) -> str:
    return f"{value:.1f} dB" if quantity.unit == "dB" else f"{value:.2f}"


def _sentence(result: SimulationResult, quantity: Quantity) -> str:
    band = f"from {result.frequency[0]:g} to {result.frequency[-1]:g} Hz"
    cases = [case for case in result.cases if quantity.name in case.quantities]
    means = [_mean(case, quantity) for case in cases]
    low, high = (cases[int(i)] for i in (np.argmin(means), np.argmax(means)))
    if len(cases) > 1:
        ends = " to ".join(f"{_shown(_mean(case, quantity), quantity)} ({case.label})" for case in (low, high))
        return f"Over {len(cases)} cases the {quantity.title}, averaged {band}, is {ends}."
    values = cases[0].quantities[quantity.name]
    where = result.frequency[int(np.nanargmax(np.where(np.isfinite(values), values, -np.inf)))]
    mean, most = _shown(means[0], quantity), _shown(float(np.max(values)), quantity)
    if len(result.frequency) == 1:
        return f"The {quantity.title} at {result.frequency[0]:g} Hz is {mean}."
    return f"The {quantity.title} is {mean} on average {band}, and {most} at most, at {where:.4g} Hz."


def _facts(result: SimulationResult, quantity: Quantity) -> tuple[tuple[str, str], ...]:
    cases, what = len(result.cases), result.bands or "frequencies"
    facts = [(what, str(len(result.frequency))), ("cases", str(cases))]
    rated = result.cases[0].ratings if cases == 1 else {}
    means = [_mean(case, quantity) for case in result.cases if quantity.name in case.quantities]
    facts += list(rated.items()) or [(f"largest mean {quantity.title}", _shown(max(means), quantity))]
    return tuple(facts)


def _note(result: SimulationResult) -> str:
    if not any(case.percentiles for case in result.cases):
        return ""
    return "Bands in figures, and brackets in tables, hold 5 to 95 % of the samples drawn within the tolerances."


def _pictures(
    result: SimulationResult, names: Iterable[str], comparison: Comparison | None = None
) -> tuple[Picture, ...]:
    with figure_style(compact=True):
        return tuple(
            picture(
                draw_quantity(result, name, _measured(comparison, name), upright=True),
                name,
                f"{QUANTITIES[name].title[0].upper()}{QUANTITIES[name].title[1:]}.",
            )
            for name in list(names)[:_MOST_PICTURES]
        )


def _measured(comparison: Comparison | None, name: str) -> Any:
    return None if comparison is None else comparison.measured.quantities[name]


def _tables(result: SimulationResult, quantity: Quantity) -> Section:
    cases = [case for case in result.cases if quantity.name in case.quantities]
    rows = rows_of(result)
    unit = f" / {quantity.unit}" if quantity.unit else ""
    over = result.bands or ("third octaves" if len(rows) != len(result.frequency) else "")
    averaged = f", averages over {over}" if over else ""
    caption = f"{quantity.title}{unit}{averaged}"
    ratings = Listing(
        ("case", *cases[0].ratings), tuple((case.label or "-", *case.ratings.values()) for case in cases[:_MOST_LISTED])
    )
    single = ((ratings, "Single numbers"),) if cases[0].ratings else ()
    if len(cases) <= _MOST_CASES:
        headings = ("f / Hz", *(", ".join(case.shown.values()) or "value" for case in cases))
        cells = tuple((f"{f:.4g}", *(cell(case, quantity, at) for case in cases)) for f, at in rows)
        return Section("Values", listings=((Listing(headings, cells, tuple(range(len(headings)))), caption), *single))
    means = tuple((case.label, _shown(_mean(case, quantity), quantity)) for case in cases[:_MOST_LISTED])
    more = (f"{len(cases) - _MOST_LISTED} more cases, see simulation.csv.",) if len(cases) > _MOST_LISTED else ()
    table = Listing(("case", f"mean {quantity.title}"), means, (1,))
    return Section("Values", listings=((table, "Means over frequency"), *single), remarks=more)


def _told(best: Misfit, n: int) -> str:
    quantity = QUANTITIES[best.quantity]
    case = f" of the case {best.case}" if best.case else ""
    which = "closest" if n > 1 else "measured"
    sizes = [f"{value:.3g} {quantity.unit}".strip() for value in (best.rms, best.largest)]
    return (
        f"The {which} {quantity.title}{case} differs from the prediction by {sizes[0]} (rms), "
        f"by {sizes[1]} at most, at {best.worst_frequency:.4g} Hz."
    )


def _misfits(misfits: Iterable[Misfit]) -> Listing:
    rows = []
    for one in misfits:
        unit = QUANTITIES[one.quantity].unit
        sizes = [f"{value:.3g} {unit}".strip() for value in (one.rms, one.largest)]
        inside = "" if one.inside is None else percent(one.inside)
        rows.append((QUANTITIES[one.quantity].title, one.case, *sizes, f"{one.worst_frequency:.4g} Hz", inside))
    headings = ("quantity", "case", "rms", "largest", "at", "within 5 to 95 %")
    return Listing(headings, tuple(rows), (2, 3, 4, 5)).filled()


def _left_out(comparison: Comparison) -> tuple[str, ...]:
    left = len(comparison.misfits) - _MOST_LISTED
    return (
        *((f"{left} more cases, see comparison.json.",) if left > 0 else ()),
        *((f"Not predicted, left out: {', '.join(comparison.left_out)}.",) if comparison.left_out else ()),
    )
