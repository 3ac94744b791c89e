"""Figures of a fit: moduli, envelopes, convergence, transmissibility, Gross check."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import ComplexArray, RealArray
from multilayer.fits.result import BurstFit, FitResult
from multilayer.fits.settings import FitSettings
from multilayer.measurements.description import Campaign
from multilayer.media.elastic import p_wave_modulus
from multilayer.media.rod import rod_transmissibility
from multilayer.number_text import pressure_unit
from multilayer.report.style import WIDTH, blank, colour, finished, plain, readable_decades

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def draw_moduli(result: FitResult, settings: FitSettings, *, upright: bool = False) -> Figure:
    """Draw E1, E2 and the loss factor against frequency with error bars; hollow where not accepted.

    Parameters
    ----------
    result : FitResult
    settings : FitSettings
    upright : bool
        One below the other, untitled, as a report has it.
    """
    figure, grid = blank(3, 1, (WIDTH, 5.0), sharex=True) if upright else blank(1, 3, (11, 3.6))
    axes = grid.ravel()
    unit, size = pressure_unit(max(burst.storage_modulus for burst in result.bursts))
    quantities = (("storage_modulus", f"E1 / {unit}"), ("loss_modulus", f"E2 / {unit}"), ("loss_factor", "E2/E1"))
    for axis, (name, label) in zip(axes, quantities, strict=True):
        factor = 1.0 if name == "loss_factor" else size
        for i, configuration in enumerate(result.configurations):
            _points(axis, result.of(configuration), name, factor, color=colour(i), label=plain(configuration))
        if (given := settings.quasi_static) is not None:
            static = given.loss_modulus / given.storage_modulus if factor == 1.0 else getattr(given, name) / factor
            axis.axhline(static, color="0.4", linestyle="--", label=f"quasi-static, {given.frequency:g} Hz")
        axis.set_ylabel(label)
        if name != "loss_factor":
            axis.set_yscale("log")
            readable_decades(axis)
    for axis in axes[-1:] if upright else axes:
        axis.set_xlabel("frequency / Hz")
    axes[2].set_ylim(bottom=0)
    title = f"{plain(result.campaign)}: dynamic modulus ({result.method}); hollow: not accepted"
    return finished(figure, axes[0], title, upright=upright)


def _points(axis: Axes, bursts: list[BurstFit], name: str, factor: float, *, color: str, label: str) -> None:
    f = np.array([burst.frequency for burst in bursts])
    value = np.array([getattr(burst, name) / factor for burst in bursts])
    spread = np.array([getattr(burst, f"{name}_std") / factor for burst in bursts])
    accepted = np.array([burst.accepted for burst in bursts])
    # a bar that would pass zero is cut: the axis may be logarithmic
    bars = np.stack([np.minimum(spread, 0.95 * np.abs(value)), spread])
    axis.errorbar(f, value, bars, fmt="-", color=color, capsize=2, label=label)
    axis.plot(f[accepted], value[accepted], "o", color=color)
    axis.plot(f[~accepted], value[~accepted], "o", color=color, markerfacecolor="white")


def draw_envelopes(result: FitResult, configuration: str) -> Figure:
    """Draw the measured and the modelled envelope of every burst of a configuration."""
    bursts = result.of(configuration)
    columns = min(5, len(bursts))
    rows = -(-len(bursts) // columns)
    figure, axes = _grid_of_envelopes(rows, columns)
    for axis, burst in zip(axes.flat, bursts, strict=False):
        axis.plot(1e3 * burst.time, burst.measured_envelope, color=colour(0), label="measured")
        axis.plot(1e3 * burst.time, burst.modelled_envelope, "--", color=colour(1), label="modelled")
        axis.set_title(f"{burst.frequency:g} Hz" + ("" if burst.accepted else " (not accepted)"), fontsize=8)
        axis.tick_params(labelsize=7)
        axis.set_xlim(0, _last_time(burst))
        axis.set_ylim(bottom=0)
    for axis in axes.flat[len(bursts) :]:
        axis.remove()
    axes.flat[0].legend(fontsize=7)
    figure.suptitle(f"{plain(configuration)}: envelope of the top plate")
    figure.supxlabel("time / ms", fontsize=8)
    figure.supylabel("acceleration / (m/s²)", fontsize=8)
    return figure


def _grid_of_envelopes(rows: int, columns: int) -> tuple[Figure, Any]:
    """Return axes in fixed places: matplotlib takes as long to lay them out as to draw them."""
    width, height = 2.3 * columns + 0.5, 1.8 * rows + 0.7
    figure, axes = blank(rows, columns, (width, height), laid_out=False)
    figure.subplots_adjust(
        left=0.65 / width, right=1 - 0.1 / width, bottom=0.5 / height, top=1 - 0.6 / height, wspace=0.25, hspace=0.35
    )
    return figure, axes


def _last_time(burst: BurstFit) -> float:
    """Return where the burst and its ring-down are over, ms."""
    loud = np.flatnonzero(burst.measured_envelope > 0.01 * burst.measured_envelope.max())
    return float(1e3 * burst.time[min(int(1.1 * loud[-1]) + 1, len(burst.time) - 1)])


def draw_convergence(result: FitResult) -> Figure:
    """Draw E1, E2 and the cost at each evaluation, one line per burst (the paper's Fig. 10)."""
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    figure, axes = blank(1, 3, (11, 3.4))
    f = [burst.frequency for burst in result.bursts]
    scale = Normalize(min(f), max(f))
    tints = colormaps["viridis"]
    for burst in result.bursts:
        steps = np.arange(1, len(burst.history) + 1)
        for axis, values in zip(axes[0], burst.history.T, strict=True):
            axis.plot(steps, np.maximum(values, 1e-12), ".-", color=tints(scale(burst.frequency)), linewidth=0.8)
    cost = "cost (9) / (m/s²)" if result.method == "nelder-mead" else "relative misfit"
    for axis, label in zip(axes[0], ("E1 / Pa", "E2 / Pa", cost), strict=True):
        axis.set(xlabel="evaluation", ylabel=label, yscale="log")
    losses = np.concatenate([b.history[:, 1] for b in result.bursts])
    axes[0, 1].set_ylim(bottom=max(1e-3 * losses.max(), losses.min() / 2, 1e-9))
    figure.colorbar(ScalarMappable(scale, tints), ax=axes[0, 2], label="burst / Hz")
    figure.suptitle(f"{plain(result.campaign)}: convergence ({result.method})")
    return figure


def draw_transmissibility(
    result: FitResult, campaign: Campaign, settings: FitSettings, *, upright: bool = False
) -> Figure:
    """Draw amplitude and phase of the transmissibility: measured, fitted, and eq. (11) (the paper's Figs. 11-12)."""
    figure, grid = blank(2, 1, (WIDTH, 3.6) if upright else (7.5, 5.5), sharex=True)
    axes = grid[:, 0]
    for i, configuration in enumerate(result.configurations):
        bursts = result.of(configuration)
        f = np.array([b.frequency for b in bursts])
        measured = np.array([b.measured_transmissibility for b in bursts])
        fitted = np.array([complex(b.optimum.storage_modulus, b.optimum.loss_modulus) for b in bursts])
        tint = colour(i)
        _curve(axes, f, measured, marker="o", linestyle="", color=tint, label=f"{plain(configuration)}, measured")
        if settings.pores is None:  # eq. (11) has no air in pores
            rod = _rod(campaign, configuration, f, fitted, settings)
            _curve(axes, f, rod, marker=".", color=tint, label="eq. (11), fitted")
        if settings.model == "finite":
            finite = np.array([b.modelled_transmissibility for b in bursts])
            _curve(axes, f, finite, linestyle=":", color=tint, label="finite elements, fitted")
        if (given := settings.quasi_static) is not None:
            static = np.full(len(f), complex(given.storage_modulus, given.loss_modulus))
            curve = _rod(campaign, configuration, f, static, settings)
            _curve(axes, f, curve, linestyle="--", color="0.4", label="eq. (11), quasi-static")
    axes[0].set(ylabel="amplitude", yscale="log")
    axes[1].set(ylabel="phase / degrees", xlabel="frequency / Hz")
    title = f"{plain(result.campaign)}: transmissibility, top plate over base"
    return finished(figure, axes[0], title, upright=upright, ncols=2)


def _curve(axes: Any, f: RealArray, ratio: ComplexArray, **options: Any) -> None:
    axes[0].plot(f, np.abs(ratio), **options)
    axes[1].plot(f, np.rad2deg(np.unwrap(np.angle(ratio))), **options)


def _rod(
    campaign: Campaign, configuration: str, f: RealArray, modulus: ComplexArray, settings: FitSettings
) -> ComplexArray:
    """Return eq. (11); the plane-wave model knows the modulus of laterally held compression only."""
    geometry = campaign.configuration(configuration)
    held = p_wave_modulus(modulus, campaign.specimen.poisson_ratio) if settings.model == "plane_wave" else modulus
    mass = campaign.top_plate.density * geometry.top_plate_thickness
    mass += settings.sensor_mass / (np.pi * geometry.specimen_radius**2)
    return rod_transmissibility(f, held, campaign.specimen.density, geometry.specimen_thickness, mass)


def draw_gross_check(result: FitResult, *, upright: bool = False) -> Figure:
    """Draw E2 as found and as eq. (12) has it from the slope of E1 (the paper's Fig. 13)."""
    figure, axes = blank(1, 1, (WIDTH, 2.9) if upright else (7, 4))
    axis = axes[0, 0]
    unit, size = pressure_unit(max(burst.loss_modulus for burst in result.bursts))
    for i, configuration in enumerate(result.configurations):
        check = result.gross_check(configuration)
        if check is None:
            continue
        error = "" if upright else f", mean relative error {100 * check.mean_relative_error:.0f} %"
        axis.plot(check.frequency, check.measured / size, "o", color=colour(i), label=f"{plain(configuration)}: found")
        positive = np.where(check.predicted > 0, check.predicted, np.nan)
        axis.plot(check.frequency, positive / size, "--", color=colour(i), label=f"eq. (12){error}")
    axis.set(xlabel="frequency / Hz", ylabel=f"E2 / {unit}")
    title = f"{plain(result.campaign)}: local Kramers-Kronig check (Gross)"
    if not axis.lines:
        axis.text(0.5, 0.5, "fewer than three accepted bursts: no slope", ha="center", transform=axis.transAxes)
    else:
        axis.set_yscale("log")
        readable_decades(axis)
    return finished(figure, axis, title, upright=upright, ncols=2)
