"""The report of several methods side by side (the figure: the paper's Figs. 6-9 and 13)."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from multilayer.arrays import RealArray
from multilayer.fits.classical.comparison import CausalityCheck, MethodComparison, MethodPoint
from multilayer.number_text import pressure_unit, with_spread
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.report import Report, Section
from multilayer.report.style import blank, colour, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = "os^Dv*PXhd<>"
_LEAST_DIGITS = 1e-4  # of an axis' largest value: below it nothing is drawn on a logarithmic axis
_QUANTITIES = ("storage_modulus", "loss_modulus", "loss_factor")
_SHOWN = 60.0  # %, the largest difference that is drawn


def methods_report(comparison: MethodComparison) -> Report:
    """Return the report of a comparison: by configuration points, checks and agreement, and what was left out."""
    told = [f"{name}: {comparison.titles[name]}" for name in comparison.methods]
    told += [f"{name}: left out, {reason}" for name, reason in comparison.left_out.items()]
    listings = {name: (_listing(comparison, name), _verdicts(comparison, name)) for name in comparison.configurations}
    return Report(
        name=comparison.campaign,
        kind="methods side by side",
        sections=(
            *(Section(name, listings=pair) for name, pair in listings.items()),
            Section("Methods", remarks=(*told, *comparison.remarks)),
        ),
        tables={"methods.csv": comparison.to_csv()},
        record=comparison.to_dict(),
        record_file="methods.json",
        figures={"methods.png": partial(draw_methods, comparison)},
    )


def _listing(comparison: MethodComparison, configuration: str) -> Listing:
    points = comparison.of(configuration)
    known = [point.storage_modulus for point in points if math.isfinite(point.storage_modulus)]
    unit, factor = pressure_unit(max(known, default=1.0))
    first = {point.frequency: point for point in reversed(points)}  # a frequency stands in its first row

    def shown(value: float, spread: float) -> str:
        return with_spread(value, spread) if math.isfinite(value) else "-"

    columns: dict[str, Callable[[MethodPoint], str]] = {
        ">f / Hz": lambda p: f"{p.frequency:g}" if first[p.frequency] is p else "",
        "method": lambda p: p.method,
        f">E1 / {unit}": lambda p: shown(p.storage_modulus / factor, p.storage_modulus_std / factor),
        f">E2 / {unit}": lambda p: shown(p.loss_modulus / factor, p.loss_modulus_std / factor),
        ">loss factor": lambda p: shown(p.loss_factor, p.loss_factor_std),
        "reliable": lambda p: yes_or_no(p.reliable),
        "remark": lambda p: p.remark,
    }
    return Listing.of(points, columns, caption=f"{comparison.campaign}: {configuration}")


def _verdicts(comparison: MethodComparison, configuration: str) -> Listing:
    """Return Gross' check, the Kramers-Kronig verdict and the distance from the reference, by method."""
    checks = {check.method: check for check in comparison.checks() if check.configuration == configuration}
    apart = {a.method: a for a in comparison.agreements() if a.configuration == configuration}
    limit = comparison.limits.get(configuration, math.inf)
    rod = f"transfer-function: a rod up to {limit:.0f} Hz, too thick for its wavelength beyond"
    columns: dict[str, Callable[[str], str]] = {
        "method": str,
        "Gross (12)": lambda m: f"{100 * checks[m].gross_error:.0f} %" if m in checks else "-",
        "Kramers-Kronig": lambda m: checks[m].verdict if m in checks else "-",
        f"E1 over {comparison.reference}": lambda m: (
            f"{100 * apart[m].storage_difference:+.1f} %" if m in apart else "-"
        ),
        "E2": lambda m: f"{100 * apart[m].loss_difference:+.1f} %" if m in apart else "-",
        "within 2 s": lambda m: (
            f"{100 * apart[m].within:.0f} %" if m in apart and math.isfinite(apart[m].within) else "-"
        ),
        "why": lambda m: _why(checks.get(m)),
    }
    return Listing.of(comparison.methods, columns, notes=(rod,) if math.isfinite(limit) else ())


def _why(check: CausalityCheck | None) -> str:
    if check is None:
        return "too few reliable points"
    # the first reason of a good verdict only says that it is one; all of them are in methods.json
    return "; ".join(check.reasons if check.verdict == "inconsistent" else check.reasons[1:])


def draw_methods(comparison: MethodComparison) -> Figure:
    """Draw a row per configuration.

    E1, E2 and the loss factor with error bars (hollow: not reliable), E2 beside what eq. (12) makes of E1, and the
    differences of every method from the reference.
    """
    rows = len(comparison.configurations)
    figure, grid = blank(rows, 5, (17, 3.3 * rows + 0.6))
    for axes, name in zip(grid, comparison.configurations, strict=True):
        for method in comparison.methods:
            for axis, quantity in zip(axes, _QUANTITIES, strict=False):
                _points(axis, comparison.of(name, method), quantity, *_style(comparison, method))
        _finish(axes, name, comparison.limits.get(name, np.inf))
        _draw_check(axes[3], comparison, name)
        _draw_agreement(axes[4], comparison, name)
    grid[0, 0].legend(fontsize=7)
    figure.suptitle(f"{plain(comparison.campaign)}: methods side by side; hollow: not reliable")
    return figure


def _style(comparison: MethodComparison, method: str) -> tuple[str, str]:
    """Return the colour and the marker of a method: the same whichever others are left out."""
    index = comparison.names.index(method)
    return colour(index), _MARKERS[index % len(_MARKERS)]


def _points(axis: Axes, points: list[MethodPoint], quantity: str, tint: str, marker: str) -> None:
    known = [point for point in points if np.isfinite(getattr(point, quantity))]
    if not known:
        return
    method = known[0].method
    f, value, spread = _columns(known, "frequency", quantity, f"{quantity}_std")
    good = np.array([point.reliable for point in known])
    spread = np.nan_to_num(spread)
    # a bar that would pass zero is cut: the axis may be logarithmic
    bars = np.stack([np.minimum(spread, 0.95 * np.abs(value)), spread])
    axis.errorbar(f[good], value[good], bars[:, good], fmt=f"{marker}-", color=tint, capsize=2, label=method)
    axis.errorbar(f[~good], value[~good], bars[:, ~good], fmt=marker, color=tint, alpha=0.45, markerfacecolor="white")


def _columns(points: list[MethodPoint], *names: str) -> list[RealArray]:
    return [np.array([getattr(point, name) for point in points], dtype=float) for name in names]


def _finish(axes: RealArray, name: str, limit: float) -> None:
    for axis, quantity in zip(axes, ("E1 / Pa", "E2 / Pa", "loss factor E2/E1"), strict=False):
        axis.set(xlabel="frequency / Hz", ylabel=quantity)
        if np.isfinite(limit):
            axis.axvline(limit, color="0.6", linestyle=":", linewidth=1, label="the rod's limit")
    for axis in axes[:2]:
        axis.set_yscale("log")
        _keep_in_sight(axis)
    axes[2].set_ylim(0, min(axes[2].get_ylim()[1], 2.0))
    axes[0].set_title(plain(name), fontsize=9)


def _keep_in_sight(axis: Axes) -> None:
    """Hide values so small, or so uncertain, that they would take all the room of a logarithmic axis."""
    low, high = axis.get_ylim()
    drawn = [v for line in axis.get_lines() for v in np.asarray(line.get_ydata(), dtype=float) if v > 0]
    if drawn:
        largest = max(drawn)
        axis.set_ylim(max(low, _LEAST_DIGITS * largest), min(high, 3 * largest))


def _draw_check(axis: Axes, comparison: MethodComparison, name: str) -> None:
    """Draw E2 as found and as eq. (12) has it, with the verdict of the full relation."""
    for check in comparison.checks():
        if check.configuration != name:
            continue
        tint, marker = _style(comparison, check.method)
        points = [p for p in comparison.of(name, check.method) if p.frequency in check.frequency]
        axis.plot(check.frequency, [p.loss_modulus for p in points], marker, color=tint)
        shown = f"{check.method}: {100 * check.gross_error:.0f} %, {check.verdict}"
        axis.plot(check.frequency, np.where(check.gross > 0, check.gross, np.nan), "--", color=tint, label=shown)
    axis.set(xlabel="frequency / Hz", ylabel="E2 / Pa")
    if not axis.lines:
        axis.text(0.5, 0.5, "too few reliable points", ha="center", transform=axis.transAxes)
        return
    axis.set_yscale("log")
    _keep_in_sight(axis)
    axis.set_title("dashed: eq. (12) of E1; its mean error, full Kramers-Kronig", fontsize=8)
    axis.legend(fontsize=6)


def _draw_agreement(axis: Axes, comparison: MethodComparison, name: str) -> None:
    """Draw the relative difference of each method's E1 (full) and E2 (dashed) from the reference."""
    reference = {p.frequency: p for p in comparison.of(name, comparison.reference) if p.reliable}
    for method in comparison.methods:
        points = [p for p in comparison.of(name, method) if p.reliable and p.frequency in reference]
        if method == comparison.reference or not points:
            continue
        tint, marker = _style(comparison, method)
        for quantity, style in (("storage_modulus", "-"), ("loss_modulus", "--")):
            f, value = _columns(points, "frequency", quantity)
            (there,) = _columns([reference[p.frequency] for p in points], quantity)
            label = method if style == "-" else None
            axis.plot(f, 100 * (value / there - 1), marker + style, color=tint, label=label)
    axis.axhline(0, color="0.4", linewidth=0.8)
    low, high = axis.get_ylim()
    axis.set_ylim(max(low, -_SHOWN), min(high, _SHOWN))
    axis.set(xlabel="frequency / Hz", ylabel=f"difference from {comparison.reference} / %")
    axis.set_title("agreement: full E1, dashed E2", fontsize=8)
