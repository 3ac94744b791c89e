"""The figure of several methods side by side (the paper's Figs. 6-9 and 13)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from multilayer.arrays import RealArray
from multilayer.fits.classical.comparison import METHODS, MethodComparison, MethodPoint
from multilayer.report.style import blank, colour, plain

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MARKERS = dict(zip(METHODS, "os^Dv*", strict=True))
_TINTS = {name: colour(i) for i, name in enumerate(METHODS)}
_LEAST_DIGITS = 1e-4  # of an axis' largest value: below it nothing is drawn on a logarithmic axis
_QUANTITIES = ("storage_modulus", "loss_modulus", "loss_factor")
_SHOWN = 60.0  # %, the largest difference that is drawn


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
                _points(axis, comparison.of(name, method), quantity)
        _finish(axes, name, comparison.limits.get(name, np.inf))
        _draw_check(axes[3], comparison, name)
        _draw_agreement(axes[4], comparison, name)
    grid[0, 0].legend(fontsize=7)
    figure.suptitle(f"{plain(comparison.campaign)}: methods side by side; hollow: not reliable")
    return figure


def _points(axis: Axes, points: list[MethodPoint], quantity: str) -> None:
    known = [point for point in points if np.isfinite(getattr(point, quantity))]
    if not known:
        return
    method = known[0].method
    f, value, spread = _columns(known, "frequency", quantity, f"{quantity}_std")
    good = np.array([point.reliable for point in known])
    spread = np.nan_to_num(spread)
    # a bar that would pass zero is cut: the axis may be logarithmic
    bars = np.stack([np.minimum(spread, 0.95 * np.abs(value)), spread])
    tint, marker = _TINTS[method], _MARKERS[method]
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
        tint = _TINTS[check.method]
        found = [p for p in comparison.of(name, check.method) if p.frequency in check.frequency]
        axis.plot(check.frequency, [p.loss_modulus for p in found], _MARKERS[check.method], color=tint)
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
        for quantity, style in (("storage_modulus", "-"), ("loss_modulus", "--")):
            f, value = _columns(points, "frequency", quantity)
            (there,) = _columns([reference[p.frequency] for p in points], quantity)
            label = method if style == "-" else None
            axis.plot(f, 100 * (value / there - 1), _MARKERS[method] + style, color=_TINTS[method], label=label)
    axis.axhline(0, color="0.4", linewidth=0.8)
    low, high = axis.get_ylim()
    axis.set_ylim(max(low, -_SHOWN), min(high, _SHOWN))
    axis.set(xlabel="frequency / Hz", ylabel=f"difference from {comparison.reference} / %")
    axis.set_title("agreement: full E1, dashed E2", fontsize=8)
