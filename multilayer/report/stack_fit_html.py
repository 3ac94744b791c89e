"""The report of a fit of stacks."""

from __future__ import annotations

from multilayer.fits.stacks.result import POOR, FoundQuantity, StackFitResult
from multilayer.report.html import Page, Picture, Section, page_html, picture
from multilayer.report.joint_html import determined_section
from multilayer.report.listing import Listing
from multilayer.report.numbers import percent, significant, with_interval, with_unit
from multilayer.report.stack_fit import KINDS, draw_curve
from multilayer.report.style import figure_style

_MOST_CURVES, _MOST_MINIMA = 4, 6


def stack_fit_html(result: StackFitResult) -> str:
    """Return the report of a fit of stacks as an HTML file."""
    good = result.converged and result.misfit_per_datum <= POOR
    pictures = _pictures(result)
    folded = Section("The other measurements", pictures[_MOST_CURVES:]) if len(pictures) > _MOST_CURVES else None
    page = Page(
        name=result.name,
        kind="fit of stacks",
        label="Fitted" if good else "Model misses the data" if result.converged else "No minimum reached",
        good=good,
        sentence=_sentence(result),
        facts=_facts(result),
        sections=(
            Section("What was found", listings=((_found(result.quantities), ""),), remarks=tuple(result.remarks)),
            Section("Measured beside fitted", pictures[:_MOST_CURVES], ((_curves(result), ""),), folded=folded),
            determined_section(result.summary.identifiability, result.summary.remark),
            *([_minima(result)] if len(result.minima) > 1 else []),
        ),
        inputs=result.settings,
    )
    return page_html(page)


def _sentence(result: StackFitResult) -> str:
    n, known = len(result.quantities), sum(quantity.determined for quantity in result.quantities)
    told = "the model explains the data within their noise"
    if result.misfit_per_datum > POOR:
        told = "the model misses the data by more than their noise"
    if not result.converged:
        told = "the search stopped before it reached a minimum"
    measured = "one measurement" if len(result.curves) == 1 else f"{len(result.curves)} measurements"
    which = "the one unknown is" if n == known == 1 else f"{known} of {n} unknowns are"
    return f"From {measured}, {which} determined: {told} (chi-square {result.misfit_per_datum:.3g} per datum)."


def _facts(result: StackFitResult) -> tuple[tuple[str, str], ...]:
    return (
        ("unknowns determined", f"{sum(q.determined for q in result.quantities)} of {len(result.quantities)}"),
        ("chi-square per datum", f"{result.misfit_per_datum:.3g}"),
        ("minima found", str(len(result.minima))),
        ("probability of the first", percent(result.minima[0].probability)),
    )


def _found(quantities: list[FoundQuantity]) -> Listing:
    rows = tuple(
        (
            one.name.removeprefix("layers."),
            with_interval(one.value, *one.intervals[-1], one.unit),
            with_unit(one.std, one.unit, 2),
            percent(one.left),
            "yes" if one.determined else "no",
        )
        for one in quantities
    )
    return Listing(("unknown", "value (90 % interval)", "std", "left of the prior", "determined"), rows, (1, 2, 3))


def _pictures(result: StackFitResult) -> tuple[Picture, ...]:
    with figure_style(compact=True):
        return tuple(
            picture(draw_curve(curve, upright=True), f"curve{i}", f"{curve.name}: {KINDS[curve.kind]}.")
            for i, curve in enumerate(result.curves)
        )


def _curves(result: StackFitResult) -> Listing:
    rows = tuple(
        (
            curve.name,
            KINDS[curve.kind],
            f"{len(curve.frequency)}",
            " to ".join(f"{f:g}" for f in curve.frequency[[0, -1]]),
            f"{curve.rms:.3g} {curve.unit}".strip(),
            f"{curve.misfit / curve.residual.size:.3g}",
        )
        for curve in result.curves
    )
    headings = ("measurement", "quantity", "frequencies", "f / Hz", "rms difference", "chi-square per datum")
    return Listing(headings, rows, (2, 3, 4, 5))


def _minima(result: StackFitResult) -> Section:
    headings = ("chi-square", "probability", *(one.name.removeprefix("layers.") for one in result.quantities))
    rows = tuple(
        (
            f"{minimum.misfit:.4g}",
            significant(minimum.probability, 2),
            *(with_unit(v, q.unit) for v, q in zip(minimum.values, result.quantities, strict=True)),
        )
        for minimum in result.minima[:_MOST_MINIMA]
    )
    return Section("Other minima", listings=((Listing(headings, rows, tuple(range(len(headings)))), ""),))
