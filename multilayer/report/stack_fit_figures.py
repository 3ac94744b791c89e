"""Figures of a fit of stacks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.fits.stacks.result import FittedCurve, parts_of
from multilayer.report.style import WIDTH, blank, colour, finished, plain
from multilayer.response.bands import band_centres

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_MARKERS = 150
KINDS = {
    "surface_impedance": "surface impedance", "reflection": "reflection coefficient",
    "absorption": "absorption coefficient", "transmission_loss": "transmission loss",
    "transmissibility": "transmissibility", "modulus": "Young's modulus", "stiffness": "stiffness",
}  # fmt: skip


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
    _frequency_axis(axes[-1], *curve.frequency[[0, -1]])
    return finished(figure, axes[0], f"{plain(curve.name)}: {KINDS[curve.kind]}", upright=upright)


def _frequency_axis(axis: Axes, low: float, high: float) -> None:
    if high < 4 * low:
        return
    axis.set_xscale("log")
    ticks = [tick for tick in band_centres(low, high, "octaves") if low <= tick <= high]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)


def _parts(curve: FittedCurve) -> list[tuple[str, RealArray, RealArray]]:
    """Return what is drawn: label, measured, predicted."""
    unit = f" / {curve.unit.replace('*', ' ')}" if curve.unit else ""
    if not np.iscomplexobj(curve.measured):
        labels = [f"{KINDS[curve.kind]}{unit}"]
    elif curve.kind == "transmissibility":
        labels = ["amplitude", "phase / degrees"]
    else:
        names = ("E1", "E2") if curve.kind == "modulus" else ("real part", "imaginary part")
        labels = [f"{name}{unit}" for name in names]
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
