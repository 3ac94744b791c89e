"""The report of a fit of stacks."""

from __future__ import annotations

from functools import partial

import numpy as np

from multilayer.fits.stacks.result import FittedCurve, StackFitResult
from multilayer.report.files import file_names
from multilayer.report.identifiability import determined_section
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.numbers import percent, significant, with_interval, with_unit
from multilayer.report.report import Picture, Report, Section
from multilayer.report.stack_fit_figures import KINDS, draw_curve

POOR = 2.0  # chi-square per datum: the model misses more than noise
_STRONG = 0.9  # correlation that is told
_MOST_MINIMA, _MOST_CURVES = 10, 4


def stack_fit_report(result: StackFitResult) -> Report:
    """Return the report of a fit of stacks."""
    good = result.converged and result.misfit_per_datum <= POOR
    pictures = tuple(
        Picture(partial(draw_curve, curve, upright=True), f"{curve.name}: {KINDS[curve.kind]}.")
        for curve in result.curves
    )
    left = pictures[_MOST_CURVES:]
    stacks, curves = result.stack_files(), file_names([curve.name for curve in result.curves])
    return Report(
        name=result.name,
        kind="fit of stacks",
        label="Fitted" if good else "Model misses the data" if result.converged else "No minimum reached",
        tone="good" if good else "mind",
        sentence=_sentence(result),
        facts=(
            ("unknowns determined", f"{sum(q.determined for q in result.quantities)} of {len(result.quantities)}"),
            ("chi-square per datum", f"{result.misfit_per_datum:.3g}"),
            ("minima found", str(len(result.minima))),
            ("probability of the first", percent(result.minima[0].probability)),
        ),
        sections=(
            Section("What was found", listings=_quantities(result), remarks=_remarks(result)),
            Section(
                "Measured beside fitted",
                pictures[:_MOST_CURVES],
                (_curves(result.curves),),
                folded=Section("The other measurements", left) if left else None,
            ),
            determined_section(result.summary.identifiability, result.summary.remark),
            *([Section("Other minima", listings=(_minima(result),))] if len(result.minima) > 1 else []),
        ),
        inputs=result.settings,
        tables={"parameters.csv": result.parameters_csv(), "curves.csv": result.curves_csv()},
        record=result.to_dict(),
        record_file="fit.json",
        texts={
            f"fitted-{name}.yaml": text for name, text in zip(file_names(list(stacks)), stacks.values(), strict=True)
        },
        page="report.html",
        figures={f"{name}.png": partial(draw_curve, curve) for name, curve in zip(curves, result.curves, strict=True)},
        accepted=result.converged,
    )


def _short(name: str) -> str:
    return name.removeprefix("layers.")


def _remarks(result: StackFitResult) -> tuple[str, ...]:
    """Return what a reader of the values must know."""
    said = []
    if not result.converged:
        said.append("the search stopped before it reached a minimum; begin from other values, or narrow the priors")
    if result.misfit_per_datum > POOR:
        said.append(
            f"chi-square is {result.misfit_per_datum:.3g} per datum: the model misses the data by more than noise; "
            f"intervals are {result.scale:.3g} times wider for it, and need not hold what a better model would give"
        )
    undetermined = [_short(quantity.name) for quantity in result.quantities if not quantity.determined]
    if undetermined:
        said.append(f"hardly determined by these data, what is known of them is their prior: {', '.join(undetermined)}")
    rows, columns = np.nonzero(np.triu(np.abs(result.correlation) > _STRONG, k=1))
    for i, j in zip(rows.tolist(), columns.tolist(), strict=True):
        names = [_short(result.quantities[k].name) for k in (i, j)]
        said.append(f"{names[0]} and {names[1]} go together (correlation {result.correlation[i, j]:.2f})")
    return tuple(said)


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


def _quantities(result: StackFitResult) -> tuple[Listing, Listing]:
    """Return what was found: in SI units for a terminal, in units that are easy to read for a page."""
    in_si, readable = [], []
    for one in result.quantities:
        name, ends = _short(one.name), (f"{low:.4g} to {high:.4g}" for low, high in one.intervals)
        in_si.append((name, f"{one.value:.4g}", f"{one.std:.2g}", *ends, one.unit or "-", f"{one.left:.0%}"))
        value, std = with_interval(one.value, *one.intervals[-1], one.unit), with_unit(one.std, one.unit, 2)
        readable.append((name, value, std, percent(one.left), yes_or_no(one.determined)))
    caption = f"{result.name}: unknowns, with the intervals that hold them at 68 and 90 %"
    headings = ("unknown", "value", "± std", "68 %", "90 %", "unit", "left of the prior")
    on_page = ("unknown", "value (90 % interval)", "std", "left of the prior", "determined")
    return (
        Listing(headings, tuple(in_si), (1, 2, 3, 4, 6), caption, only="console"),
        Listing(on_page, tuple(readable), (1, 2, 3), only="page"),
    )


def _curves(curves: list[FittedCurve]) -> Listing:
    rows = tuple(
        (
            curve.name,
            KINDS[curve.kind],
            f"{len(curve.frequency)}",
            " to ".join(f"{f:g}" for f in curve.frequency[[0, -1]]),
            f"{curve.rms:.3g} {curve.unit}".strip(),
            f"{curve.misfit / curve.residual.size:.3g}",
        )
        for curve in curves
    )
    headings = ("measurement", "quantity", "frequencies", "f / Hz", "rms difference", "chi-square per datum")
    return Listing(headings, rows, (2, 3, 4, 5))


def _minima(result: StackFitResult) -> Listing:
    headings = ("chi-square", "probability", *(_short(quantity.name) for quantity in result.quantities))
    rows = tuple(
        (
            f"{minimum.misfit:.4g}",
            significant(minimum.probability, 2),
            *(with_unit(v, q.unit) for v, q in zip(minimum.values, result.quantities, strict=True)),
        )
        for minimum in result.minima[:_MOST_MINIMA]
    )
    more = len(result.minima) - _MOST_MINIMA
    notes = (f"{more} more, see fit.json",) if more > 0 else ()
    return Listing(headings, rows, tuple(range(len(headings))), notes=notes)
