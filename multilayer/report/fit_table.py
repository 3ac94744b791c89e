"""The table of a fit."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from multilayer.fits.result import BurstFit, FitResult
from multilayer.report.console import console
from multilayer.report.numbers import burst_numbers, pressure_unit


def fit_table(result: FitResult) -> None:
    """Print one table per configuration."""
    out = console()
    for name in result.configurations:
        bursts = result.of(name)
        unit, factor = pressure_unit(max(burst.storage_modulus for burst in bursts))
        # as Text: names and remarks may hold what rich takes for markup
        out.print(Text(f"{result.campaign}: {name}", style="italic"))
        table = Table(box=None, pad_edge=False)
        table.add_column("f / Hz", justify="right")
        for heading in (f"E1 / {unit}", f"E2 / {unit}", "loss factor", "Δtof / µs", "Δlevel / dB"):
            table.add_column(heading, justify="right", no_wrap=True)
        table.add_column("accepted")
        table.add_column("remark", overflow="fold")
        for burst in bursts:
            table.add_row(*_cells(burst, factor))
        out.print(table)
        if (check := result.gross_check(name)) is not None:
            out.print(f"Gross check (eq. 12): mean relative error {100 * check.mean_relative_error:.0f} %")
        for burst in bursts:
            for other in burst.alternatives:
                out.print(
                    f"{burst.frequency:g} Hz: E1 = {other.storage_modulus:.4g} Pa, E2 = {other.loss_modulus:.4g} Pa "
                    f"meets eq. (10) as well (misfit {other.misfit:.3f} against {burst.optimum.misfit:.3f})"
                )
        out.print()


def _cells(burst: BurstFit, factor: float) -> list[str | Text]:
    return [*burst_numbers(burst, factor), "yes" if burst.accepted else "[red]no[/red]", Text(burst.remark)]
