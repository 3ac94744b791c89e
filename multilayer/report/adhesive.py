"""Table and figure of the check of an adhesive."""

from __future__ import annotations

import numpy as np
from rich.table import Table
from rich.text import Text

from multilayer.report.console import console
from multilayer.report.style import blank, colour, figure_style, plain, png
from multilayer.signals.adhesive import AdhesiveCheck


def adhesive_table(check: AdhesiveCheck) -> None:
    """Print one row per burst, and the verdict."""
    out = console()
    out.print(Text(f"{check.name}: two plates glued together, no sample", style="italic"))
    table = Table(box=None, pad_edge=False)
    for heading in ("f / Hz", "|T|", "std", "phase / degrees", "std", "p", "T = 1"):
        table.add_column(heading, justify="left" if heading == "T = 1" else "right")
    for row in check.rows():
        table.add_row(
            f"{row['frequency_hz']:g}", f"{row['amplitude']:.5f}", f"{row['amplitude_std']:.1g}",
            f"{row['phase_deg']:.3f}", f"{row['phase_std_deg']:.1g}", f"{row['p_value']:.2g}",
            "yes" if row["is_unity"] else "no",
        )  # fmt: skip
    out.print(table)
    out.print(Text(check.sentence))


def adhesive_figure(check: AdhesiveCheck) -> bytes:
    """Return amplitude and phase over frequency, with two standard deviations, as a PNG file."""
    with figure_style():
        figure, axes = blank(2, 1, (7, 4.5), sharex=True)
        t = check.transmissibility
        values = (np.abs(t) - 1) * 100, np.rad2deg(np.angle(t))
        spreads = 200 * np.abs(t) * check.std, 2 * np.rad2deg(check.std)
        labels = ("(|T| - 1) / %", "phase / degrees")
        for axis, value, spread, label in zip(axes[:, 0], values, spreads, labels, strict=True):
            axis.axhline(0, color="0.4", linewidth=0.8)
            axis.errorbar(check.frequency, value, spread, fmt="o", color=colour(0), markersize=4, capsize=2)
            axis.set_ylabel(label)
        axes[1, 0].set_xlabel("frequency / Hz")
        figure.suptitle(f"{plain(check.name)}: two plates glued together, bars of two standard deviations")
        return png(figure)
