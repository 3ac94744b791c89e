"""Figures of a joint fit: the law, what is left, transmissibility."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.fits.joint.fit import JointFit
from multilayer.fits.joint.posterior import modulus_band, motion_curves
from multilayer.inference.posterior import Posterior
from multilayer.report.numbers import pressure_unit
from multilayer.report.style import WIDTH, blank, colour, finished, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_CURVE = 200
_INNER, _OUTER = 0.68, 0.9


def draw_law(result: JointFit, *, upright: bool = False) -> Figure:
    """Draw E1, E2 and loss factor with the bands that hold each point at 68 and 90 %."""
    ends = [f for data in result.problem.data for f in (data.frequency.min(), data.frequency.max())]
    f = np.geomspace(min(ends), max(ends), _CURVE)
    moduli, _ = result.moduli(f)
    bands = [modulus_band(result, f, level) for level in (_OUTER, _INNER)]
    unit, size = pressure_unit(float(moduli.real.max()))
    curves = {f"E1 / {unit}": moduli.real, f"E2 / {unit}": moduli.imag, "E2/E1": moduli.imag / moduli.real}
    figure, axes = _grid_of_law(upright)
    for k, (label, value) in enumerate(curves.items()):
        factor = size if k < 2 else 1.0
        for band in bands:
            options: dict[str, Any] = {"color": colour(0), "alpha": 0.2, "linewidth": 0}
            axes[0, k].fill_between(f, band.low[k] / factor, band.high[k] / factor, **options)
            if np.all(value > 0):  # a band may be narrower than the line above
                axes[1, k].fill_between(f, *(100 * (end[k] / value - 1) for end in (band.low, band.high)), **options)
        axes[0, k].plot(f, value / factor, color=colour(0))
        axes[1, k].axhline(0, color=colour(0), linewidth=0.8)
        axes[0, k].set(ylabel=label, xscale="log")
        axes[1, k].set_ylabel("band / %")
    for axis in axes[1, 2:] if upright else axes[1]:
        axis.set_xlabel("frequency / Hz")
    axes[0, 2].set_ylim(bottom=0)
    if not upright:
        figure.suptitle(f"{plain(result.campaign)}: {result.law.law}, bands that hold each point at 68 and 90 %")
    return figure


def _grid_of_law(upright: bool) -> tuple[Figure, Any]:
    """Return axes by row (values, widths of the bands) and column (quantity), wherever they stand."""
    if not upright:
        return blank(2, 3, (11, 5.2), sharex=True, height_ratios=[1.0, 0.5])
    figure, axes = blank(6, 1, (WIDTH, 5.8), sharex=True, height_ratios=[1.0, 0.5] * 3)
    return figure, axes.reshape(3, 2).T


def draw_motion(result: JointFit, posterior: Posterior) -> Figure:
    """Draw measured and modelled transmissibility of every configuration, with the model's 90 % band."""
    found = motion_curves(result, posterior, _OUTER)
    figure, axes = blank(len(found), 2, (9, 2.0 * len(found) + 0.8), sharex=True)
    for row, (name, curve) in zip(axes, found.items(), strict=True):
        for k, (axis, label) in enumerate(zip(row, ("amplitude", "phase / degrees"), strict=True)):
            axis.plot(curve.frequency, curve.measured[k], ".", color="black", markersize=2.5, label="measured")
            band = f"model, {100 * _OUTER:.0f} % band"
            axis.fill_between(
                curve.frequency, curve.band.low[k], curve.band.high[k], color=colour(0), alpha=0.35, linewidth=0,
                label=band,
            )  # fmt: skip
            axis.plot(curve.frequency, curve.modelled[k], color=colour(0), linewidth=0.9, label="model")
            axis.set_ylabel(label)
        row[0].set(yscale="log", title=plain(name))
    for axis in axes[-1]:
        axis.set_xlabel("frequency / Hz")
    title = f"{plain(result.campaign)}: transmissibility, gain and delay of the channels included"
    return finished(figure, axes[0, 0], title, upright=False, ncols=3)


def draw_residuals(result: JointFit, *, upright: bool = False) -> Figure:
    """Draw what is left of amplitude and phase, measured minus modelled, by configuration."""
    figure, axes = blank(2, 1, (WIDTH, 3.6) if upright else (8, 5.5), sharex=True)
    for i, (name, (f, delay, level)) in enumerate(result.discrepancies().items()):
        options: dict[str, Any] = {"color": colour(i), "marker": ".", "linestyle": "", "markersize": 4}
        axes[0, 0].plot(f, level, label=plain(name), **options)
        axes[1, 0].plot(f, 360 * f * delay, **options)
    for axis, label in zip(axes[:, 0], ("level / dB", "phase / degrees"), strict=True):
        axis.axhline(0, color="0.4", linewidth=0.8)
        axis.set_ylabel(label)
    axes[1, 0].set_xlabel("frequency / Hz")
    title = f"measured minus modelled, chi-square {result.best.cost:.4g} for {result.n_data} data"
    return finished(figure, axes[0, 0], f"{plain(result.campaign)}: {title}", upright=upright, ncols=3)
