"""The report of moduli along three axes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.number_text import pressure_unit, with_spread
from multilayer.report.listing import Listing
from multilayer.report.report import Report
from multilayer.report.style import blank, colour, plain
from multilayer_campaigns.anisotropy import AnisotropyResult
from multilayer_campaigns.axis_ratios import AXES
from multilayer_campaigns.multi_campaign_report import closing_notes, table_report

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARKERS = "os^"
_APART = 0.008  # relative, by which points of one frequency are drawn apart


def anisotropy_report(result: AnisotropyResult) -> Report:
    """Return the report of a comparison: moduli and ratios by frequency and axis, and the verdict."""
    rows = sorted(result.rows(), key=lambda row: (row["frequency_hz"], row["axis"]))
    unit, factor = pressure_unit(max(row["E1_pa"] for row in rows))

    def ratio(row: dict[str, Any], name: str) -> str:
        return f"{row[f'{name}_ratio']:.3f} ({row[f'{name}_ratio_low']:.3f} to {row[f'{name}_ratio_high']:.3f})"

    columns: dict[str, Callable[[dict[str, Any]], str]] = {
        ">f / Hz": lambda row: f"{row['frequency_hz']:g}" if row["axis"] == AXES[0] else "",
        "axis": lambda row: row["axis"],
        f">E1 / {unit}": lambda row: with_spread(row["E1_pa"] / factor, row["E1_std_pa"] / factor),
        f">E2 / {unit}": lambda row: with_spread(row["E2_pa"] / factor, row["E2_std_pa"] / factor),
        ">E1 over mean (95 %)": lambda row: ratio(row, "E1"),
        ">E2 over mean (95 %)": lambda row: ratio(row, "E2"),
    }
    named = ", ".join(f"{axis}: {name}" for axis, name in zip(AXES, result.campaigns, strict=True))
    listing = Listing.of(rows, columns, caption=named, notes=closing_notes(result.scale, result))
    return table_report("anisotropy", named, result, listing, partial(draw_anisotropy, result))


def draw_anisotropy(result: AnisotropyResult) -> Figure:
    """Draw E1 and E2 by axis, and their ratios to the mean of the axes; bands are those of all frequencies together."""
    figure, grid = blank(2, 2, (10, 6.6), sharex="all")
    for a, (axis, campaign) in enumerate(zip(AXES, result.campaigns, strict=True)):
        tint, at = colour(a), result.frequency * (1 + _APART * (a - 1))
        moduli, spread = result.of_axis(a)
        for q, ratios in enumerate((result.storage, result.loss)):
            style = {"color": tint, "capsize": 2}
            label = f"{axis}: {plain(campaign)}"
            grid[q, 0].errorbar(at, moduli[q], spread[q], fmt=f"{_MARKERS[a]}-", label=label, **style)
            value, low, high = np.array([ratios.interval(i, a) for i in range(len(at))]).T
            grid[q, 1].errorbar(at, value, [value - low, high - value], fmt=_MARKERS[a], **style)
            _, least, most = ratios.intervals[axis]
            grid[q, 1].axhspan(least, most, color=tint, alpha=0.2, linewidth=0)
    for q, name in enumerate(("E1", "E2")):
        grid[q, 0].set_ylabel(f"{name} / Pa")
        grid[q, 1].set_ylabel(f"{name} over the mean of the axes")
        grid[q, 1].axhline(1.0, color="0.4", linewidth=0.8)
    for axis in grid[1]:
        axis.set_xlabel("frequency / Hz")
    grid[0, 0].legend(fontsize=8)
    grid[0, 1].set_title("95 %; bands: all frequencies together", fontsize=9)
    return figure
