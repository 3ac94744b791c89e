"""The report of a joint fit: one modulus law for all bursts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import Any

from multilayer.fits.joint.fit import JointFit
from multilayer.fits.joint.posterior import modulus_intervals
from multilayer.report.fit import moduli_span
from multilayer.report.identifiability import determined_section
from multilayer.report.joint_figures import draw_law, draw_motion, draw_residuals
from multilayer.report.listing import Listing, yes_or_no
from multilayer.report.numbers import pressure_unit, significant, with_spread, with_unit
from multilayer.report.report import Draw, Picture, Report, Section

_MOST_ROWS = 18
_LEAST_P = 1e-12  # nobody knows the tail beyond


def joint_report(result: JointFit, inputs: Mapping[str, Any]) -> Report:
    """Return the report of a joint fit; `inputs` tell the fit apart from others."""
    rows = result.rows()
    span = moduli_span(*([row[key] for row in rows] for key in ("E1_pa", "loss_factor", "frequency_hz")))
    label, start = _verdict(result)
    summary = result.summary
    figures: dict[str, Draw] = {
        "moduli.png": partial(draw_law, result),
        "residuals.png": partial(draw_residuals, result),
    }
    if summary is not None:
        figures["transmissibility.png"] = partial(draw_motion, result, summary.posterior)
    return Report(
        name=result.campaign,
        kind="one modulus law for all bursts",
        label=label,
        tone="mind" if result.remark else "good",
        sentence=f"One {result.law.law} law {start} (p {_chance(result.p_value)}): {span}.",
        facts=(
            ("chi-square per datum", f"{result.best.cost / result.n_data:.3g}"),
            ("probability of such a misfit", _chance(result.p_value).removeprefix("= ")),
            ("probability of what is taken for stated wrongly", _chance(result.stated_p_value).removeprefix("= ")),
            ("frequencies that meet eq. (10)", f"{sum(bool(row['accepted']) for row in rows)} of {len(rows)}"),
            ("distinct solutions", str(len(result.minima))),
        ),
        note="Intervals suppose that law, rig and stated uncertainties are right; bands of moduli, that rig and stated "
        "uncertainties are: they hold what the laws compared, and departures from them, leave open.",
        sections=(
            Section(
                "The law",
                (
                    Picture(
                        partial(draw_law, result, upright=True),
                        "The law, with the bands that hold each point at 68 and 90 %.",
                    ),
                    Picture(
                        partial(draw_residuals, result, upright=True),
                        "Measured minus modelled, at the data's frequencies.",
                    ),
                ),
                (*_parameters(result), *_laws(result)),
                remarks=tuple(filter(None, (result.remark, result.remark_on_laws))),
            ),
            _moduli(rows),
            *([determined_section(summary.identifiability, summary.remark, nuisances=False)] if summary else []),
        ),
        inputs={**result.settings, "campaign": result.campaign, **inputs},
        tables={"moduli.csv": result.to_csv()},
        record={**result.to_dict(), "modulus_intervals": modulus_intervals(result), "inputs": inputs},
        record_file="joint.json",
        page="report.html",
        figures=figures,
        accepted=result.all_accepted,
    )


def _verdict(result: JointFit) -> tuple[str, str]:
    """Return the label, and what one law does."""
    if not result.remark:
        return "One law holds", "explains all bursts"
    if result.explained:
        return "What is stated is off", "explains all bursts only if what is stated of the laboratory is wrong"
    return "One law does not do", "does not explain all bursts within what is stated"


def _chance(p: float) -> str:
    return f"= {significant(p, 2)}" if p >= _LEAST_P else "< 10⁻¹²"


def _parameters(result: JointFit) -> tuple[Listing, Listing]:
    """Return all parameters for a terminal; those of the law, in units that are easy to read, for a page."""
    units = dict(zip(result.problem.space.names, result.problem.space.units, strict=True))
    every = tuple((name, f"{value:.5g}", f"{std:.2g}") for name, (value, std) in result.parameters.items())
    of_law = tuple(
        (name, with_unit(value, units[name]), with_unit(std, units[name], 2))
        for name, (value, std) in result.parameters.items()
        if name in units
    )
    notes = [
        f"chi-square {result.best.cost:.5g} for {result.n_data} data, p = {result.p_value:.3g}; "
        f"what is stated by itself, p = {result.stated_p_value:.3g}"
    ]
    if len(result.minima) > 1:
        notes.append(
            f"{len(result.minima)} distinct solutions, see joint.json; the next has {result.minima[1].cost:.5g}"
        )
    headings, law = ("parameter", "value", "std"), result.law.law
    return (
        Listing(headings, every, (1, 2), f"{result.campaign}: {law} for all bursts", tuple(notes), "console"),
        Listing(headings, of_law, (1, 2), f"Parameters of {law}", only="page"),
    )


def _laws(result: JointFit) -> list[Listing]:
    """Return the laws compared, where there are several."""
    rows = tuple(
        (
            row.law, str(row.n_parameters), f"{row.chi_square:.4g}", f"{row.p_value:.2g}", f"{row.log_evidence:.1f}",
            f"{row.probability:.2g}", f"{100 * row.deviation:.2g}",
        )
        for row in result.laws.rows()
    )  # fmt: skip
    headings = ("law", "unknowns", "chi-square", "p", "ln evidence", "probability", "departs / %")
    caption = "Laws compared: chi-square and p by themselves, evidence with what departs from them"
    return [Listing(headings, rows, tuple(range(1, 7)), caption)] if len(rows) > 1 else []


def _moduli(rows: list[dict[str, Any]]) -> Section:
    unit, factor = pressure_unit(max(row["E1_pa"] for row in rows))
    cells = tuple(
        (
            f"{row['frequency_hz']:g}",
            with_spread(row["E1_pa"] / factor, row["E1_std_pa"] / factor),
            with_spread(row["E2_pa"] / factor, row["E2_std_pa"] / factor),
            with_spread(row["loss_factor"], row["loss_factor_std"]),
            f"{1e6 * row['delta_tof_s']:.2f}",
            f"{row['delta_level_db']:.3f}",
            yes_or_no(row["accepted"]),
        )
        for row in rows
    )
    numbers = ("f / Hz", f"E1 / {unit}", f"E2 / {unit}", "loss factor", "worst Δtof / µs", "worst Δlevel / dB")
    headings, numeric = (*numbers, "accepted"), tuple(range(6))
    whole = (Listing(headings, cells, numeric),)
    if len(rows) <= _MOST_ROWS:
        return Section("Moduli at the bursts", listings=whole)
    ends = Listing(headings, (cells[0], cells[len(cells) // 2], cells[-1]), numeric, "First, middle and last")
    return Section("Moduli at the bursts", listings=(ends,), folded=Section("Every frequency", listings=whole))
