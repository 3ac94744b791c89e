"""The report of what the static weight on a sample does to its modulus."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.number_text import pressure_unit, with_spread
from multilayer.report.listing import Listing
from multilayer.report.report import Report
from multilayer.report.style import blank, colour, plain
from multilayer_campaigns.modulus_points import Specimen
from multilayer_campaigns.multi_campaign_report import closing_notes, table_report
from multilayer_campaigns.preload_result import PreloadResult, Slope, specimen_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_PER = 100.0  # Pa: slopes are shown for so much stress
_MOST_SPECIMENS, _MOST_FREQUENCIES = 4, 6
_NEAR = 0.02  # share of the axis by which points of one stress are drawn apart


def preload_report(result: PreloadResult) -> Report:
    """Return the report of a comparison: the values at zero stress, the slopes and the verdict."""
    rows = result.rows()
    unit, factor = pressure_unit(max(row["E1_0_pa"] for row in rows))
    columns: dict[str, Callable[[dict[str, Any]], str]] = {
        "specimen": lambda row: row["specimen"],
        ">f / Hz": lambda row: f"{row['frequency_hz']:g}",
        ">stress / Pa": lambda row: (
            f"{row['stress_low_pa']:.0f} to {row['stress_high_pa']:.0f}" if row["values"] > 1 else "-"
        ),
        f">E1 at 0 Pa / {unit}": lambda row: with_spread(row["E1_0_pa"] / factor, row["E1_0_std_pa"] / factor),
        f">E2 at 0 Pa / {unit}": lambda row: with_spread(row["E2_0_pa"] / factor, row["E2_0_std_pa"] / factor),
        ">loss factor": lambda row: with_spread(row["loss_factor_0"], row["loss_factor_0_std"]),
    }
    slopes = [("E1", result.storage), ("loss factor", result.loss)]
    notes = [f"{name}: {slope.percent()} per {_PER:g} Pa ({_words(slope)})" for name, slope in slopes]
    listing = Listing.of(rows, columns, notes=(*notes, *closing_notes(result.solution.scale, result)))
    return table_report("preload", ", ".join(result.campaigns), result, listing, partial(draw_preload, result))


def _words(slope: Slope) -> str:
    found = {"seen": "seen", "hint": "a hint", "none": "none seen"}[slope.verdict]
    return found if slope.shared else f"{found}; not the same at all frequencies, see preload.csv"


def draw_preload(result: PreloadResult) -> Figure:
    """Draw E1 and loss factor over the static stress, by frequency: a column for each specimen of two stresses or more.

    The lines are those of the regression, with bands of one standard deviation.
    """
    stresses: dict[Specimen, set[float]] = {}
    for point in result.points:
        stresses.setdefault(point.specimen, set()).add(point.stress)
    shown = [one for one, values in sorted(stresses.items()) if len(values) > 1][:_MOST_SPECIMENS]
    figure, grid = blank(2, len(shown), (1.5 + 3.4 * len(shown), 6.2), sharex="all")
    for axes, specimen in zip(grid.T, shown, strict=True):
        _draw_specimen(axes, result, specimen)
        axes[0].set_title(specimen_name(specimen), fontsize=9)
    grid[0, 0].set_ylabel("E1 / Pa")
    grid[1, 0].set_ylabel("loss factor E2/E1")
    handles, labels = grid[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right center", fontsize=7)
    figure.suptitle(f"{plain(', '.join(result.campaigns))}\nbands: one standard deviation", fontsize=9)
    return figure


def _draw_specimen(axes: RealArray, result: PreloadResult, specimen: Specimen) -> None:
    frequencies = sorted({f for of, f in result.cells if of == specimen})
    chosen = np.unique(np.linspace(0, len(frequencies) - 1, _MOST_FREQUENCIES).round().astype(int))
    highest = max(p.stress for p in result.points)
    stress = np.linspace(0.0, 1.05 * highest, 30)
    for n, index in enumerate(chosen):
        f = frequencies[index]
        values, spread = result.regression.line(result.solution, (specimen, f), stress)
        own = [p for p in result.points if (p.specimen, p.frequency) == (specimen, f)]
        at = np.array([p.stress for p in own]) + (n - len(chosen) / 2) * _NEAR * highest / len(chosen)
        e1 = np.array([p.storage_modulus for p in own])
        measured = (e1, np.array([p.loss_factor for p in own]))
        deviation = (e1 * np.array([p.spread[0] for p in own]), np.array([p.spread[1] for p in own]))
        lines = (np.exp(values[:, 0]), values[:, 1])
        bands = (np.exp(values[:, 0]) * spread[:, 0], spread[:, 1])
        for axis, line, band, value, bar in zip(axes, lines, bands, measured, deviation, strict=True):
            _draw_line(axis, stress, line, band, colour(n))
            axis.errorbar(at, value, bar, fmt="o", color=colour(n), capsize=2, label=f"{f:g} Hz")
    axes[1].set_xlabel("static stress / Pa")


def _draw_line(axis: Axes, stress: RealArray, line: RealArray, band: RealArray, tint: str) -> None:
    axis.plot(stress, line, color=tint)
    axis.fill_between(stress, line - band, line + band, color=tint, alpha=0.2, linewidth=0)
