"""The report of a fit of stacks."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.fits.stacks.result import FittedCurve, FoundQuantity, StackFitResult, parts_of
from multilayer.number_text import over_unit, percent, significant, with_interval, with_unit
from multilayer.report.files import file_names
from multilayer.report.identifiability import determined_section
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.report import Picture, Report, Section
from multilayer.report.style import WIDTH, blank, colour, finished, octave_ticks, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_MINIMA, _MOST_CURVES, _MOST_MARKERS = 10, 4, 150
_KINDS = {
    "surface_impedance": "surface impedance", "reflection": "reflection coefficient",
    "absorption": "absorption coefficient", "reverberation_absorption": "absorption coefficient",
    "transmission_loss": "transmission loss", "transmissibility": "transmissibility", "modulus": "Young's modulus",
    "stiffness": "stiffness",
}  # fmt: skip


def stack_fit_report(result: StackFitResult) -> Report:
    """Return the report of a fit of stacks."""
    (label, tone), stated = _verdict(result), result.statements
    pictures = tuple(
        Picture(partial(draw_curve, curve, upright=True), f"{curve.name}: {_KINDS[curve.kind]}.")
        for curve in result.curves
    )
    left = pictures[_MOST_CURVES:]
    stacks, curves = result.stack_files(), file_names([curve.name for curve in result.curves])
    return Report(
        name=result.name,
        kind="fit of stacks",
        label=label,
        tone=tone,
        sentence=_sentence(result),
        facts=(
            ("unknowns determined", f"{sum(q.determined for q in result.quantities)} of {len(result.quantities)}"),
            ("chi-square per datum", f"{result.misfit_per_datum:.3g}"),
            *(
                [("probability of what is taken for stated wrongly", significant(stated.p_value, 2))]
                if stated.remark
                else []
            ),
            ("minima found", str(len(result.minima))),
            ("probability of the first", percent(result.minima[0].probability)),
        ),
        sections=(
            Section("What was found", listings=_quantities(result), remarks=tuple(result.remarks)),
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
        tables=result.tables,
        record=result.to_dict(),
        record_file=result.record_name,
        texts={
            f"fitted-{name}.yaml": text for name, text in zip(file_names(list(stacks)), stacks.values(), strict=True)
        },
        page="report.html",
        figures={f"{name}.png": partial(draw_curve, curve) for name, curve in zip(curves, result.curves, strict=True)},
        accepted=result.converged,
    )


def _short(name: str) -> str:
    return name.removeprefix("layers.")


def _verdict(result: StackFitResult) -> tuple[str, str]:
    if not result.converged:
        return "No minimum reached", "mind"
    if result.misses:
        return "Model misses the data", "mind"
    return ("What is stated is off", "mind") if result.statements.remark else ("Fitted", "good")


def _sentence(result: StackFitResult) -> str:
    n, known = len(result.quantities), sum(quantity.determined for quantity in result.quantities)
    told = "the model explains the data within their noise"
    if result.statements.remark:
        told = "the model explains the data within their noise only if what priors state is wrong"
    if result.misses:
        told = "the model misses the data by more than their noise"
    if not result.converged:
        told = "the search stopped before it reached a minimum"
    measured = "one measurement" if len(result.curves) == 1 else f"{len(result.curves)} measurements"
    which = "the one unknown is" if n == known == 1 else f"{known} of {n} unknowns are"
    return f"From {measured}, {which} determined: {told} (chi-square {result.misfit_per_datum:.3g} per datum)."


def _quantities(result: StackFitResult) -> tuple[Listing, Listing]:
    """Return what was found: in SI units for a terminal, in units that are easy to read for a page."""

    def interval(quantity: FoundQuantity, k: int) -> str:
        return " to ".join(f"{end:.4g}" for end in quantity.intervals[k])

    in_si: dict[str, Callable[[FoundQuantity], str]] = {
        "unknown": lambda quantity: _short(quantity.name),
        ">value": lambda quantity: f"{quantity.value:.4g}",
        ">± std": lambda quantity: f"{quantity.std:.2g}",
        ">68 %": lambda quantity: interval(quantity, 0),
        ">90 %": lambda quantity: interval(quantity, 1),
        "unit": lambda quantity: quantity.unit or "-",
        ">left of the prior": lambda quantity: f"{quantity.left:.0%}",
    }
    readable: dict[str, Callable[[FoundQuantity], str]] = {
        "unknown": lambda quantity: _short(quantity.name),
        ">value (90 % interval)": lambda quantity: with_interval(
            quantity.value, *quantity.intervals[-1], quantity.unit
        ),
        ">std": lambda quantity: with_unit(quantity.std, quantity.unit, 2),
        ">left of the prior": lambda quantity: percent(quantity.left),
        "determined": lambda quantity: yes_or_no(quantity.determined),
    }
    caption = f"{result.name}: unknowns, with the intervals that hold them at 68 and 90 %"
    return (
        Listing.of(result.quantities, in_si, caption=caption, only="console"),
        Listing.of(result.quantities, readable, only="page"),
    )


def _curves(curves: list[FittedCurve]) -> Listing:
    columns: dict[str, Callable[[FittedCurve], str]] = {
        "measurement": lambda curve: curve.name,
        "quantity": lambda curve: _KINDS[curve.kind],
        ">frequencies": lambda curve: f"{len(curve.frequency)}",
        ">f / Hz": lambda curve: " to ".join(f"{f:g}" for f in curve.frequency[[0, -1]]),
        ">rms difference": lambda curve: f"{curve.rms:.3g} {curve.unit}".strip(),
        ">chi-square per datum": lambda curve: f"{curve.misfit / curve.residual.size:.3g}",
    }
    return Listing.of(curves, columns)


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


def draw_curve(curve: FittedCurve, *, upright: bool = False) -> Figure:
    """Draw a measurement and its fit, part by part, and the residuals in standard deviations; small if `upright`."""
    parts = _parts(curve)
    ratios = [1.0] * len(parts) + [0.6]
    size = (WIDTH, 1.4 * len(parts) + 1.4) if upright else (7.5, 1.9 * len(parts) + 2.0)
    figure, grid = blank(len(parts) + 1, 1, size, sharex=True, height_ratios=ratios)
    axes = grid[:, 0]
    for axis, (label, measured, predicted), low, high in zip(
        axes, parts, curve.band.low, curve.band.high, strict=False
    ):
        _draw_band(axis, curve.frequency, low, high)
        _draw_part(axis, curve.frequency, label, measured, predicted, small=upright)
    _draw_residuals(axes[-1], curve, named=not upright)
    octave_ticks(axes[-1], *curve.frequency[[0, -1]])
    return finished(figure, axes[0], f"{plain(curve.name)}: {_KINDS[curve.kind]}", upright=upright)


def _parts(curve: FittedCurve) -> list[tuple[str, RealArray, RealArray]]:
    """Return what is drawn: label, measured, predicted."""
    unit = curve.unit.replace("*", " ")
    if not np.iscomplexobj(curve.measured):
        labels = [over_unit(_KINDS[curve.kind], unit)]
    elif curve.kind == "transmissibility":
        labels = ["amplitude", "phase / degrees"]
    else:
        names = ("E1", "E2") if curve.kind == "modulus" else ("real part", "imaginary part")
        labels = [over_unit(name, unit) for name in names]
    measured, predicted = (parts_of(curve.kind, values) for values in (curve.measured, curve.predicted))
    return list(zip(labels, measured, predicted, strict=True))


def _draw_band(axis: Axes, f: RealArray, low: RealArray, high: RealArray) -> None:
    if len(f) > 1:
        axis.fill_between(f, low, high, color=colour(0), alpha=0.25, linewidth=0, label="fitted, 90 % band")
    else:
        axis.vlines(f, low, high, color=colour(0), alpha=0.5, label="fitted, 90 % band")


def _draw_part(axis: Axes, f: RealArray, label: str, measured: RealArray, predicted: RealArray, *, small: bool) -> None:
    size = (3.0 if len(f) <= _MOST_MARKERS else 1.5) / (2.0 if small and len(f) > 20 else 1.0)
    axis.plot(f, measured, "o", color="black", label="measured", markersize=size)
    axis.plot(f, predicted, "-" if len(f) > 1 else "x", color=colour(0), label="fitted")
    axis.set_ylabel(label)
    if label == "amplitude" and np.min(measured) > 0:
        axis.set_yscale("log")


def _draw_residuals(axis: Axes, curve: FittedCurve, *, named: bool) -> None:
    n = len(curve.frequency)
    parts = curve.residual.reshape(-1, n)
    for i, values in enumerate(parts):
        label = (("real", "imaginary")[i] if len(parts) > 1 else None) if n > 1 else None
        options: dict[str, Any] = {"color": colour(i + 1), "linewidth": 0.7, "markersize": 3, "label": label}
        axis.plot(curve.frequency, values, ".-" if n > 1 else "o", **options)
    axis.axhspan(-2, 2, color="0.5", alpha=0.15, linewidth=0)
    axis.axhline(0, color="0.5", linewidth=0.7)
    axis.set(xlabel="frequency / Hz", ylabel="residual / std")
    if named and len(parts) > 1 and n > 1:
        axis.legend(fontsize=7, ncols=2)
