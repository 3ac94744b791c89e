"""The report of the check of an adhesive."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.report import Report, Section
from multilayer.report.style import blank, colour, plain
from multilayer.signals.adhesive import AdhesiveCheck

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def adhesive_report(check: AdhesiveCheck) -> Report:
    """Return the report of a check: a row per burst, and the verdict."""
    rows = tuple(
        (
            f"{row['frequency_hz']:g}", f"{row['amplitude']:.5f}", f"{row['amplitude_std']:.1g}",
            f"{row['phase_deg']:.3f}", f"{row['phase_std_deg']:.1g}", f"{row['p_value']:.2g}",
            yes_or_no(row["is_unity"]),
        )
        for row in check.rows()
    )  # fmt: skip
    headings = ("f / Hz", "|T|", "std", "phase / degrees", "std", "p", "T = 1")
    caption = f"{check.name}: two plates glued together, no sample"
    listing = Listing(headings, rows, tuple(range(6)), caption, (check.sentence,))
    return Report(
        name=check.name,
        kind="adhesive",
        sections=(Section("Burst by burst", listings=(listing,)),),
        tables={"adhesive.csv": check.to_csv()},
        record=check.to_dict(),
        record_file="adhesive.json",
        figures={"adhesive.png": partial(draw_adhesive, check)},
    )


def draw_adhesive(check: AdhesiveCheck) -> Figure:
    """Draw amplitude and phase over frequency, with two standard deviations."""
    figure, axes = blank(2, 1, (7, 4.5), sharex=True)
    t = check.transmissibility
    values = (np.abs(t) - 1) * 100, np.rad2deg(np.angle(t))
    spreads = 200 * np.abs(t) * check.std, 2 * np.rad2deg(check.std)
    for axis, value, spread, label in zip(
        axes[:, 0], values, spreads, ("(|T| - 1) / %", "phase / degrees"), strict=True
    ):
        axis.axhline(0, color="0.4", linewidth=0.8)
        axis.errorbar(check.frequency, value, spread, fmt="o", color=colour(0), markersize=4, capsize=2)
        axis.set_ylabel(label)
    axes[1, 0].set_xlabel("frequency / Hz")
    figure.suptitle(f"{plain(check.name)}: two plates glued together, bars of two standard deviations")
    return figure
