"""Table and figure of moduli along three axes."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from rich.table import Table
from rich.text import Text

from multilayer.report.console import console
from multilayer.report.numbers import pressure_unit, with_spread
from multilayer.report.style import blank, colour, figure_style, plain, png
from multilayer_campaigns.anisotropy import AnisotropyResult
from multilayer_campaigns.axis_ratios import AXES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MARKERS = "os^"
_APART = 0.008  # relative, by which points of one frequency are drawn apart


def anisotropy_table(result: AnisotropyResult) -> None:
    """Print moduli and ratios by frequency and axis, and the verdict."""
    out = console()
    out.print(Text(", ".join(f"{a}: {name}" for a, name in zip(AXES, result.campaigns, strict=True)), style="italic"))
    rows = sorted(result.rows(), key=lambda row: (row["frequency_hz"], row["axis"]))
    unit, factor = pressure_unit(max(row["E1_pa"] for row in rows))
    table = Table(box=None, pad_edge=False)
    for heading in ("f / Hz", "axis", f"E1 / {unit}", f"E2 / {unit}", "E1 over mean (95 %)", "E2 over mean (95 %)"):
        table.add_column(heading, justify="left" if heading == "axis" else "right", no_wrap=True)
    for row in rows:
        moduli = [with_spread(row[f"{e}_pa"] / factor, row[f"{e}_std_pa"] / factor) for e in ("E1", "E2")]
        ratios = [
            f"{row[f'{e}_ratio']:.3f} ({row[f'{e}_ratio_low']:.3f} to {row[f'{e}_ratio_high']:.3f})"
            for e in ("E1", "E2")
        ]
        frequency = f"{row['frequency_hz']:g}" if row["axis"] == AXES[0] else ""
        table.add_row(frequency, row["axis"], *moduli, *ratios)
    out.print(table)
    if result.scale > 1:
        out.print(f"the values scatter more than stated: standard deviations enlarged by {result.scale:.2f}")
    for remark in result.remarks:
        out.print(Text(remark))
    out.print(Text(result.verdict, style="bold"))


def anisotropy_figure(result: AnisotropyResult) -> bytes:
    """Return the figure as a PNG file: E1 and E2 by axis, and their ratios to the mean of the axes."""
    with figure_style():
        return png(draw_anisotropy(result))


def draw_anisotropy(result: AnisotropyResult) -> Figure:
    """Draw the figure of `anisotropy_figure`; bands are the ratios of all frequencies together."""
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
