"""The table of several methods side by side."""

from __future__ import annotations

import math

from rich.console import Console
from rich.table import Table
from rich.text import Text

from multilayer.fits.classical.comparison import CausalityCheck, MethodComparison, MethodPoint
from multilayer.report.console import console
from multilayer.report.numbers import pressure_unit, with_spread


def methods_table(comparison: MethodComparison) -> None:
    """Print one table per configuration, its checks and agreement, and what was left out."""
    out = console()
    for name in comparison.configurations:
        # as Text: names and remarks may hold what rich takes for markup
        out.print(Text(f"{comparison.campaign}: {name}", style="italic"))
        out.print(_points_table(comparison.of(name)))
        out.print(_verdict_table(comparison, name))
        if math.isfinite(limit := comparison.limits.get(name, math.inf)):
            out.print(f"transfer-function: a rod up to {limit:.0f} Hz, too thick for its wavelength beyond")
        out.print()
    _methods(out, comparison)


def _points_table(points: list[MethodPoint]) -> Table:
    known = [point.storage_modulus for point in points if math.isfinite(point.storage_modulus)]
    unit, factor = pressure_unit(max(known, default=1.0))
    table = Table(box=None, pad_edge=False)
    table.add_column("f / Hz", justify="right")
    table.add_column("method", no_wrap=True)
    for heading in (f"E1 / {unit}", f"E2 / {unit}", "loss factor"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("reliable")
    table.add_column("remark", overflow="fold")
    before = None
    for point in points:
        frequency = f"{point.frequency:g}" if point.frequency != before else ""
        table.add_row(frequency, point.method, *_numbers(point, factor), _yes(point.reliable), Text(point.remark))
        before = point.frequency
    return table


def _numbers(point: MethodPoint, factor: float) -> list[str]:
    values = (
        (point.storage_modulus / factor, point.storage_modulus_std / factor),
        (point.loss_modulus / factor, point.loss_modulus_std / factor),
        (point.loss_factor, point.loss_factor_std),
    )
    return [with_spread(value, spread) if math.isfinite(value) else "-" for value, spread in values]


def _yes(reliable: bool) -> str:
    return "yes" if reliable else "[red]no[/red]"


def _verdict_table(comparison: MethodComparison, configuration: str) -> Table:
    """Return Gross' check, the Kramers-Kronig verdict and the distance from the reference, by method."""
    checks = {c.method: c for c in comparison.checks() if c.configuration == configuration}
    agreements = {a.method: a for a in comparison.agreements() if a.configuration == configuration}
    table = Table(box=None, pad_edge=False)
    headings = ("Gross (12)", "Kramers-Kronig", f"E1 over {comparison.reference}", "E2", "within 2 s", "why")
    for heading in ("method", *headings):
        table.add_column(heading, no_wrap=heading != "why", overflow="fold" if heading == "why" else "ellipsis")
    for method in comparison.methods:
        check, other = checks.get(method), agreements.get(method)
        verdict = [f"{100 * check.gross_error:.0f} %", check.verdict] if check else ["-", "-"]
        apart = ["-"] * 3
        if other:
            apart = [f"{100 * other.storage_difference:+.1f} %", f"{100 * other.loss_difference:+.1f} %"]
            apart.append(f"{100 * other.within:.0f} %")
        table.add_row(method, *verdict, *apart, Text(_why(check)))
    return table


def _why(check: CausalityCheck | None) -> str:
    if check is None:
        return "too few reliable points"
    # the first reason of a good verdict only says that it is one; all of them are in methods.json
    return "; ".join(check.reasons if check.verdict == "inconsistent" else check.reasons[1:])


def _methods(out: Console, comparison: MethodComparison) -> None:
    for name in comparison.methods:
        out.print(Text(f"{name}: {comparison.titles[name]}"))
    for name, reason in comparison.left_out.items():
        out.print(Text(f"{name}: left out, {reason}"))
    for remark in comparison.remarks:
        out.print(Text(remark))
