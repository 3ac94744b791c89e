"""Tables of a simulation and of a comparison."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray
from rich.table import Table
from rich.text import Text

from multilayer.report.console import console
from multilayer.response.bands import band_centres, bands_of
from multilayer.simulation.compare import Comparison
from multilayer.simulation.quantities import QUANTITIES, Quantity
from multilayer.simulation.result import CaseResult, SimulationResult

_PRINTED = ("absorption", "transmission_loss", "insertion_loss")
_MOST_COLUMNS = 6  # of cases beside each other; more of them stand below each other
_MOST_POINTS = 40  # frequencies printed as they are; more are averaged over third octaves
Rows: TypeAlias = list[tuple[float, NDArray[np.intp]]]


def simulation_table(result: SimulationResult) -> None:
    """Print one table per quantity, and the single numbers of every case."""
    out = console()
    rows = rows_of(result)
    bands = result.bands or ("third octaves" if len(rows) != len(result.frequency) else None)
    averaged = f", averages over {bands}" if bands else ""
    through = any("transmission_loss" in case.quantities for case in result.cases)
    for name in _PRINTED[through:]:  # what does not come back from a stack that lets sound through is not absorbed
        cases = [case for case in result.cases if name in case.quantities]
        if cases:
            quantity = QUANTITIES[name]
            unit = f" / {quantity.unit}" if quantity.unit else ""
            out.print(Text(f"{result.name}: {quantity.title}{unit}{averaged}", style="italic"))
            draw = _side_by_side if len(cases) <= _MOST_COLUMNS else _one_below_the_other
            out.print(draw(cases, quantity, rows))
    for case in result.cases:
        if case.ratings:
            said = ", ".join(f"{name} {value}" for name, value in case.ratings.items())
            out.print(Text(f"{case.label}: {said}" if case.label else said))


def rows_of(result: SimulationResult) -> Rows:
    """Return what a row stands for: its frequency, and the indices of the values averaged in it."""
    if result.bands or len(result.frequency) <= _MOST_POINTS:
        return [(f, np.array([i])) for i, f in enumerate(result.frequency)]
    return bands_of(result.frequency)


def cell(case: CaseResult, quantity: Quantity, indices: NDArray[np.intp]) -> str:
    """Return a value of a case, averaged over the frequencies at some indices; of one, with its percentiles."""
    values = case.quantities[quantity.name][indices]
    digits = 1 if quantity.unit == "dB" else 2
    value = f"{quantity.mean(values):.{digits}f}"
    (column,) = quantity.columns
    if len(indices) > 1 or column not in case.percentiles:
        return value
    low, _, high = (f"{band[indices[0]]:.{digits}f}" for band in case.percentiles[column])
    return f"{value} [{low}, {high}]"


def _side_by_side(cases: list[CaseResult], quantity: Quantity, rows: Rows) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column(Text("\n".join([*cases[0].shown, "f / Hz"])), justify="right")
    for case in cases:
        table.add_column(Text("\n".join([*case.shown.values(), " "])), justify="right")
    for frequency, indices in rows:
        table.add_row(f"{frequency:.4g}", *(cell(case, quantity, indices) for case in cases))
    return table


def _one_below_the_other(cases: list[CaseResult], quantity: Quantity, rows: Rows) -> Table:
    table = Table(box=None, pad_edge=False)
    table.add_column("case")
    octaves = [row for row in rows if np.any(np.abs(row[0] / band_centres(63, 8000, "octaves") - 1) < 0.01)]
    chosen = octaves or rows[:_MOST_COLUMNS]
    for frequency, _ in chosen:
        table.add_column(f"{frequency:.4g} Hz", justify="right")
    for case in cases:
        table.add_row(Text(case.label), *(cell(case, quantity, indices) for _, indices in chosen))
    return table


def comparison_table(comparison: Comparison) -> None:
    """Print how far each case lies from what was measured."""
    out = console()
    low, high = comparison.predicted.frequency[[0, -1]]
    n = len(comparison.predicted.frequency)
    what = f"{n} {comparison.predicted.bands or 'frequencies'}, {low:g} to {high:g} Hz"
    heading = f"{comparison.measured.name} over {comparison.predicted.name}: {what}"
    out.print(Text(heading, style="italic"))
    table = Table(box=None, pad_edge=False)
    for name in ("quantity", "case", "rms", "largest", "at / Hz", "within 5 to 95 %"):
        table.add_column(name, justify="left" if name in ("quantity", "case") else "right")
    for misfit in comparison.misfits:
        unit = QUANTITIES[misfit.quantity].unit
        size = [f"{value:.3g} {unit}".strip() for value in (misfit.rms, misfit.largest)]
        inside = "" if misfit.inside is None else f"{misfit.inside:.0%}"
        table.add_row(misfit.quantity, Text(misfit.case or "-"), *size, f"{misfit.worst_frequency:.4g}", inside)
    out.print(table)
    if comparison.left_out:
        out.print(Text(f"not predicted, left out: {', '.join(comparison.left_out)}"))
