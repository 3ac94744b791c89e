"""Figures of a simulation: one per quantity, a line per case, a band where there are tolerances."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.arrays import RealArray
from multilayer.number_text import over_unit
from multilayer.report.style import COLOURS, WIDTH, blank, colour, legend_below, octave_ticks, plain
from multilayer.response.bands import band_centres, band_edges
from multilayer.simulation.quantities import QUANTITIES, Quantity
from multilayer.simulation.result import CaseResult, SimulationResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_MOST_IN_LEGEND = 12
_MOST_MARKERS = 150
_MOST_PANELS = 4
_LINE = 28  # characters of a label beside one of two axes of an upright figure


def draw_quantity(result: SimulationResult, name: str, measured: Any = None, *, upright: bool = False) -> Figure:
    """Draw a quantity of every case that has it over frequency; of a complex one both parts.

    Parameters
    ----------
    result : SimulationResult
    name : str
        Of `QUANTITIES`.
    measured : array, optional
        Drawn over the cases; at the same frequencies.
    upright : bool
        Small and untitled, the legend below, as a report has it.
    """
    quantity = QUANTITIES[name]
    columns = quantity.columns
    width, height = (WIDTH, 3.0) if upright else (7.5, 4.2)
    figure, grid = blank(len(columns), 1, (width, height if len(columns) == 1 else 4 / 3 * height), sharex=True)
    axes = grid[:, 0]
    cases = [case for case in result.cases if name in case.quantities]
    points = {} if measured is None else quantity.parts(np.asarray(measured))
    for axis, column in zip(axes, columns, strict=True):
        _draw_column(axis, result, cases, column, points)
        axis.set_ylabel(fill(_label(quantity, column), _LINE if upright else 2 * _LINE))
        axis.set_ylim(*_limits(quantity, cases, column, points))
    _frequency_axis(axes[-1], result)
    if upright:
        _legend(axes[0], cases, below=figure)
    else:
        _legend(axes[0], cases)
        over = ", measured over predicted" if points else ""
        figure.suptitle(f"{plain(result.name)}: {quantity.title}{over}")
    return figure


def draw_losses(result: SimulationResult, *, upright: bool = False) -> Figure:
    """Draw the shares of the power that the layers lose upon each other, a panel for each of the first cases.

    With the absorption, of which the rest is what gets through; not of a finite size, whose edges add to that.
    """
    cases = [case for case in result.cases if case.layer_losses][:_MOST_PANELS]
    width, height = (WIDTH, 1.8) if upright else (7.5, 2.2)
    figure, grid = blank(len(cases), 1, (width, 1.2 + height * len(cases)), sharex=True)
    for axis, case in zip(grid[:, 0], cases, strict=True):
        shares, total = case.layer_losses, np.zeros(len(result.frequency))
        for (name, share), tint in zip(shares.items(), _tints(len(shares)), strict=True):
            below, total = total, total + share
            _fill(axis, result, below, total, color=tint, label=plain(name))
        if result.settings.get("finite_size") is None:
            _line(axis, result, case.absorption, color="black", label="absorption")
        axis.set_ylabel("share of the power")
        axis.set_ylim(0.0, 1.0)
        if case.shown:
            axis.set_title(plain(case.label), fontsize=8)
    _frequency_axis(grid[-1, 0], result)
    legend_below(figure, grid[0, 0])
    if not upright:
        figure.suptitle(f"{plain(result.name)}: power lost in the layers")
    return figure


def draw_spread(result: SimulationResult, name: str, *, upright: bool = False) -> Figure:
    """Draw the standard deviations that come of the tolerances over frequency, a panel for each of the first cases.

    Parameters
    ----------
    result : SimulationResult
    name : str
        Of `QUANTITIES`.
    upright : bool
        As in `draw_quantity`.
    """
    quantity = QUANTITIES[name]
    cases = [case for case in result.cases if case.spread.get(name)][:_MOST_PANELS]
    width, height = (WIDTH, 1.8) if upright else (7.5, 2.2)
    figure, grid = blank(len(cases), 1, (width, 1.2 + height * len(cases)), sharex=True, sharey=True)
    for axis, case in zip(grid[:, 0], cases, strict=True):
        of_fields = case.spread[name]
        whole = np.sqrt(np.sum(np.square([*of_fields.values()]), axis=0))
        _line(axis, result, whole, color="black", label="all")
        for (path, deviation), tint in zip(of_fields.items(), _tints(len(of_fields)), strict=True):
            _line(axis, result, deviation, color=tint, label=plain(path))
        axis.set_ylabel(over_unit("standard deviation", quantity.unit))
        if case.shown:
            axis.set_title(plain(case.label), fontsize=8)
    grid[0, 0].set_ylim(bottom=0.0)  # shared by all
    _frequency_axis(grid[-1, 0], result)
    legend_below(figure, grid[0, 0])
    if not upright:
        figure.suptitle(f"{plain(result.name)}: scatter of the {quantity.title}")
    return figure


def _label(quantity: Quantity, column: str) -> str:
    part = {"_re": "real part of ", "_im": "imaginary part of "}.get(column[-3:], "") if quantity.is_complex else ""
    return over_unit(f"{part}{quantity.title}", quantity.unit).replace(" of surface impedance", " of Z")


def _draw_column(
    axis: Axes, result: SimulationResult, cases: Sequence[CaseResult], column: str, measured: Mapping[str, RealArray]
) -> None:
    for case, tint in zip(cases, _tints(len(cases)), strict=True):
        values = case.columns[column]
        if column in case.percentiles:
            low, _, high = case.percentiles[column]
            _fill(axis, result, low, high, color=tint, alpha=0.2)
        _line(axis, result, values, color=tint, label=_case_label(case))
    if column in measured:
        options: dict[str, Any] = {"color": "black", "linewidth": 0.8, "markersize": 3, "zorder": 5}
        form = "o-" if len(result.frequency) <= _MOST_MARKERS else "-"
        axis.plot(*_with_gaps(result, measured[column]), form, label="measured", **options)


def _tints(n: int) -> list[Any]:
    """Return a colour per case: told apart by anyone up to seven, along a scale beyond."""
    if n <= len(COLOURS):
        return [colour(i) for i in range(n)]
    from matplotlib import colormaps

    return [colormaps["viridis"](0.15 + 0.75 * i / (n - 1)) for i in range(n)]


def _line(axis: Axes, result: SimulationResult, values: RealArray, **options: Any) -> None:
    f, values = _with_gaps(result, values)
    if result.bands:
        axis.stairs(values, band_edges(f, result.bands), baseline=None, linewidth=1.3, **options)
    else:
        axis.plot(f, values, "o-" if len(values) == 1 else "-", **options)


def _fill(axis: Axes, result: SimulationResult, low: RealArray, high: RealArray, **options: Any) -> None:
    f, high = _with_gaps(result, high)
    if result.bands:
        _, low = _with_gaps(result, low)
        axis.stairs(high, band_edges(f, result.bands), baseline=low, fill=True, linewidth=0, **options)
    else:
        axis.fill_between(f, low, high, linewidth=0, **options)


def _with_gaps(result: SimulationResult, values: RealArray) -> tuple[RealArray, RealArray]:
    """Return frequencies and values to draw: of all bands from the first to the last, NaN where there is none."""
    if result.bands is None:
        return result.frequency, values
    every = band_centres(result.frequency[0], result.frequency[-1], result.bands)
    filled = np.full(len(every), np.nan)
    filled[np.searchsorted(every, result.frequency)] = values
    return every, filled


def _case_label(case: CaseResult) -> str:
    """Return the swept values; what they are stands above."""
    return plain(", ".join(case.shown.values())) if case.shown else "predicted"


def _legend(axis: Axes, cases: Sequence[CaseResult], *, below: Figure | None = None) -> None:
    from matplotlib.patches import Patch

    handles, labels = axis.get_legend_handles_labels()
    title, count = plain(", ".join(cases[0].shown)), len(handles)
    if count > _MOST_IN_LEGEND:
        title = f"{title} ({_MOST_IN_LEGEND} of {count} are named)"
        chosen = np.unique(np.linspace(0, len(handles) - 1, _MOST_IN_LEGEND).round().astype(int))
        handles, labels = [handles[i] for i in chosen], [labels[i] for i in chosen]
    if any(case.percentiles for case in cases):
        handles.append(Patch(color="0.5", alpha=0.3, linewidth=0))
        labels.append("5 to 95 % of samples")
    if len(handles) == 1:
        return
    columns = 2 if below is not None or len(handles) > 6 else 1
    options: dict[str, Any] = {"title": title or None, "fontsize": 7, "title_fontsize": 7, "ncols": columns}
    if below is None:
        axis.legend(handles, labels, **options)
    else:
        below.legend(handles, labels, loc="outside lower center", **options)


def _frequency_axis(axis: Axes, result: SimulationResult) -> None:
    low, high = result.frequency.min(), result.frequency.max()
    if result.bands:
        low, high = band_edges(result.frequency, result.bands)[[0, -1]]
    axis.set_xlabel(f"frequency / Hz, {result.bands}" if result.bands else "frequency / Hz")
    if high > low:
        axis.set_xlim(low, high)
    octave_ticks(axis, low, high)


def _limits(
    quantity: Quantity, cases: Sequence[CaseResult], column: str, measured: Mapping[str, RealArray]
) -> tuple[float | None, float | None]:
    """Return limits of the axis: 0 to 1 for an absorption, from 0 for a loss, no poles of an impedance."""
    drawn = [case.columns[column] for case in cases] + [measured[column] for _ in (1,) if column in measured]
    drawn += [band for case in cases for band in case.percentiles.get(column, ())]
    values = np.concatenate(drawn)
    values = values[np.isfinite(values)]
    if quantity.name == "absorption":
        return min(0.0, *values), max(1.0, *(1.02 * values))
    if quantity.name == "normalised_impedance" and values.size:
        low, high = np.percentile(values, (2, 98))
        margin = 0.15 * max(high - low, 1.0)
        return float(low - margin), float(high + margin)
    from_zero = values.size and values.min() > 0 and not quantity.is_level
    return (0.0 if from_zero else None), None
