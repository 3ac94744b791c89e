"""The report of several methods side by side."""

from __future__ import annotations

import math
from functools import partial

from multilayer.fits.classical.comparison import METHODS, CausalityCheck, MethodComparison, MethodPoint
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.methods_figure import draw_methods
from multilayer.report.numbers import pressure_unit, with_spread
from multilayer.report.report import Report, Section


def methods_report(comparison: MethodComparison) -> Report:
    """Return the report of a comparison: by configuration points, checks and agreement, and what was left out."""
    told = [f"{name}: {METHODS[name]}" for name in comparison.methods]
    told += [f"{name}: left out, {reason}" for name, reason in comparison.left_out.items()]
    listings = {name: (_points(comparison, name), _verdicts(comparison, name)) for name in comparison.configurations}
    return Report(
        name=comparison.campaign,
        kind="methods side by side",
        sections=(
            *(Section(name, listings=pair) for name, pair in listings.items()),
            Section("Methods", remarks=(*told, *comparison.remarks)),
        ),
        tables={"methods.csv": comparison.to_csv()},
        record=comparison.to_dict(),
        record_file="methods.json",
        figures={"methods.png": partial(draw_methods, comparison)},
    )


def _points(comparison: MethodComparison, configuration: str) -> Listing:
    points = comparison.of(configuration)
    known = [point.storage_modulus for point in points if math.isfinite(point.storage_modulus)]
    unit, factor = pressure_unit(max(known, default=1.0))
    rows = []
    before = math.nan
    for point in points:
        frequency = f"{point.frequency:g}" if point.frequency != before else ""
        rows.append((frequency, point.method, *_moduli(point, factor), yes_or_no(point.reliable), point.remark))
        before = point.frequency
    headings = ("f / Hz", "method", f"E1 / {unit}", f"E2 / {unit}", "loss factor", "reliable", "remark")
    return Listing(headings, tuple(rows), (0, 2, 3, 4), f"{comparison.campaign}: {configuration}")


def _moduli(point: MethodPoint, factor: float) -> tuple[str, ...]:
    values = (
        (point.storage_modulus / factor, point.storage_modulus_std / factor),
        (point.loss_modulus / factor, point.loss_modulus_std / factor),
        (point.loss_factor, point.loss_factor_std),
    )
    return tuple(with_spread(value, spread) if math.isfinite(value) else "-" for value, spread in values)


def _verdicts(comparison: MethodComparison, configuration: str) -> Listing:
    """Return Gross' check, the Kramers-Kronig verdict and the distance from the reference, by method."""
    checks = {check.method: check for check in comparison.checks() if check.configuration == configuration}
    agreements = {a.method: a for a in comparison.agreements() if a.configuration == configuration}
    rows = []
    for method in comparison.methods:
        check, other = checks.get(method), agreements.get(method)
        verdict = (f"{100 * check.gross_error:.0f} %", check.verdict) if check else ("-", "-")
        apart = ("-",) * 3
        if other:
            apart = (
                f"{100 * other.storage_difference:+.1f} %",
                f"{100 * other.loss_difference:+.1f} %",
                f"{100 * other.within:.0f} %",
            )
        rows.append((method, *verdict, *apart, _why(check)))
    headings = ("Gross (12)", "Kramers-Kronig", f"E1 over {comparison.reference}", "E2", "within 2 s", "why")
    limit = comparison.limits.get(configuration, math.inf)
    rod = f"transfer-function: a rod up to {limit:.0f} Hz, too thick for its wavelength beyond"
    return Listing(("method", *headings), tuple(rows), notes=(rod,) if math.isfinite(limit) else ())


def _why(check: CausalityCheck | None) -> str:
    if check is None:
        return "too few reliable points"
    # the first reason of a good verdict only says that it is one; all of them are in methods.json
    return "; ".join(check.reasons if check.verdict == "inconsistent" else check.reasons[1:])
