"""Table and figures of a joint fit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from rich.table import Table
from rich.text import Text

from multilayer.inverse.joint_fit import JointFit
from multilayer.report.console import console
from multilayer.report.style import colour, figure_style, plain, png

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CURVE = 200


def joint_table(result: JointFit) -> None:
    """Print the law, what became of the nuisances, and the moduli."""
    out = console()
    out.print(Text(f"{result.campaign}: {result.law.law} for all bursts", style="italic"))
    parameters = Table(box=None, pad_edge=False)
    for heading in ("parameter", "value", "std"):
        parameters.add_column(heading, justify="left" if heading == "parameter" else "right")
    for name, (value, std) in result.parameters.items():
        parameters.add_row(Text(name), f"{value:.5g}", f"{std:.2g}")
    out.print(parameters)
    moduli = Table(box=None, pad_edge=False)
    for heading in (
        "f / Hz",
        "E1 / Pa",
        "std",
        "E2 / Pa",
        "std",
        "loss factor",
        "worst Δtof / µs",
        "worst Δlevel / dB",
    ):
        moduli.add_column(heading, justify="right")
    for row in result.rows():
        moduli.add_row(
            f"{row['frequency_hz']:g}", f"{row['E1_pa']:.5g}", f"{row['E1_std_pa']:.2g}", f"{row['E2_pa']:.5g}",
            f"{row['E2_std_pa']:.2g}", f"{row['loss_factor']:.4g}", f"{1e6 * row['delta_tof_s']:+.1f}",
            f"{row['delta_level_db']:+.3f}",
        )  # fmt: skip
    out.print(moduli)
    out.print(f"chi-square {result.best.cost:.5g} for {result.n_data} data, p = {result.p_value:.3g}")
    if len(result.minima) > 1:
        out.print(f"{len(result.minima)} distinct solutions, see joint.json; the next has {result.minima[1].cost:.5g}")
    if result.remark:
        out.print(Text(result.remark))


def joint_figures(result: JointFit) -> dict[str, bytes]:
    """Return the figures of a joint fit as PNG files by name."""
    with figure_style():
        figures = {"moduli.png": draw_law(result), "residuals.png": draw_residuals(result)}
        return {name: png(figure) for name, figure in figures.items()}


def _figure(rows: int, columns: int, size: tuple[float, float], **options: Any) -> tuple[Figure, Any]:
    from matplotlib.figure import Figure as NewFigure  # without pyplot: no window system, no global state

    figure = NewFigure(figsize=size)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


def draw_law(result: JointFit) -> Figure:
    """Draw E1, E2 and loss factor with bands of one and two standard deviations."""
    ends = [f for data in result.problem.data for f in (data.frequency.min(), data.frequency.max())]
    f = np.geomspace(min(ends), max(ends), _CURVE)
    moduli, covariance = result.moduli(f)
    slope = np.stack([-moduli.imag / moduli.real**2, 1 / moduli.real], axis=-1)
    curves = {
        "E1 / Pa": (moduli.real, np.sqrt(covariance[:, 0, 0])),
        "E2 / Pa": (moduli.imag, np.sqrt(covariance[:, 1, 1])),
        "loss factor E2/E1": (moduli.imag / moduli.real, np.sqrt(np.einsum("fa,fab,fb->f", slope, covariance, slope))),
    }
    figure, axes = _figure(1, 3, (11, 3.6))
    for axis, (label, (value, std)) in zip(axes[0], curves.items(), strict=True):
        for sigmas in (2, 1):
            axis.fill_between(f, value - sigmas * std, value + sigmas * std, color=colour(0), alpha=0.2, linewidth=0)
        axis.plot(f, value, color=colour(0))
        axis.set(xlabel="frequency / Hz", ylabel=label, xscale="log")
    axes[0, 2].set_ylim(bottom=0)
    figure.suptitle(f"{plain(result.campaign)}: {result.law.law}, bands of one and two standard deviations")
    return figure


def draw_residuals(result: JointFit) -> Figure:
    """Draw what is left of amplitude and phase, measured minus modelled, by configuration."""
    figure, axes = _figure(2, 1, (8, 5.5), sharex=True)
    for i, (name, (f, delay, level)) in enumerate(result.discrepancies().items()):
        options: dict[str, Any] = {"color": colour(i), "marker": ".", "linestyle": "", "markersize": 4}
        axes[0, 0].plot(f, level, label=plain(name), **options)
        axes[1, 0].plot(f, 360 * f * delay, **options)
    for axis, label in zip(axes[:, 0], ("level / dB", "phase / degrees"), strict=True):
        axis.axhline(0, color="0.4", linewidth=0.8)
        axis.set_ylabel(label)
    axes[1, 0].set_xlabel("frequency / Hz")
    axes[0, 0].legend(fontsize=7, ncols=3)
    title = f"measured minus modelled, chi-square {result.best.cost:.4g} for {result.n_data} data"
    figure.suptitle(f"{plain(result.campaign)}: {title}")
    return figure
