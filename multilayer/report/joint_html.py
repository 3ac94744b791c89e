"""The report of a joint fit: one modulus law for all bursts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from multilayer.fits.joint.result import JointFit
from multilayer.inference.identifiability import Identifiability
from multilayer.report.fit_html import moduli_span
from multilayer.report.html import Page, Picture, Section, page_html, picture
from multilayer.report.joint_fit import LAW_HEADINGS, draw_law, draw_residuals, law_cells
from multilayer.report.listing import Listing
from multilayer.report.numbers import percent, pressure_unit, significant, with_spread, with_unit
from multilayer.report.style import figure_style

_MOST_ROWS = 18
_LEAST_P = 1e-12  # nobody knows the tail beyond
_MOST_SENTENCES = 8


def joint_html(result: JointFit, inputs: Mapping[str, Any]) -> str:
    """Return the report of a joint fit as an HTML file; `inputs` tell the fit apart from others."""
    rows = result.rows()
    span = moduli_span(*([row[key] for row in rows] for key in ("E1_pa", "loss_factor", "frequency_hz")))
    holds = not result.remark
    label, start = _verdict(result)
    summary = result.summary
    page = Page(
        name=result.campaign,
        kind="one modulus law for all bursts",
        label=label,
        good=holds,
        sentence=f"One {result.law.law} law {start} (p {_chance(result.p_value)}): {span}.",
        facts=_facts(result, rows),
        sections=(
            Section("The law", _pictures(result), _tables(result), remarks=_remarks(result)),
            *([] if summary is None else [determined_section(summary.identifiability, summary.remark)]),
            _moduli(rows),
        ),
        inputs={**result.settings, "campaign": result.campaign, **inputs},
        note="Intervals suppose that law, rig and stated uncertainties are right; bands of moduli, that rig and stated "
        "uncertainties are: they hold what the laws compared, and departures from them, leave open.",
    )
    return page_html(page)


def _verdict(result: JointFit) -> tuple[str, str]:
    """Return the label, and what one law does."""
    if not result.remark:
        return "One law holds", "explains all bursts"
    if result.explained:
        return "What is stated is off", "explains all bursts only if what is stated of the laboratory is wrong"
    return "One law does not do", "does not explain all bursts within what is stated"


def _chance(p: float) -> str:
    return f"= {significant(p, 2)}" if p >= _LEAST_P else "< 10⁻¹²"


def _facts(result: JointFit, rows: list[dict[str, Any]]) -> tuple[tuple[str, str], ...]:
    facts = [
        ("chi-square per datum", f"{result.best.cost / result.n_data:.3g}"),
        ("probability of such a misfit", _chance(result.p_value).removeprefix("= ")),
        ("probability of what is taken for stated wrongly", _chance(result.stated_p_value).removeprefix("= ")),
        ("frequencies that meet eq. (10)", f"{sum(bool(row['accepted']) for row in rows)} of {len(rows)}"),
        ("distinct solutions", str(len(result.minima))),
    ]
    return tuple(facts)


def _pictures(result: JointFit) -> tuple[Picture, ...]:
    with figure_style(compact=True):
        law, left = draw_law(result, upright=True), draw_residuals(result, upright=True)
        return (
            picture(law, "law", "The law, with the bands that hold each point at 68 and 90 %."),
            picture(left, "residuals", "Measured minus modelled, at the data's frequencies."),
        )


def _tables(result: JointFit) -> tuple[tuple[Listing, str], ...]:
    own = set(result.problem.space.names)
    units = dict(zip(result.problem.space.names, result.problem.space.units, strict=True))
    rows = tuple(
        (name, with_unit(value, units[name]), with_unit(std, units[name], 2))
        for name, (value, std) in result.parameters.items()
        if name in own
    )
    of_law = (Listing(("parameter", "value", "std"), rows, (1, 2)), f"Parameters of {result.law.law}")
    compared = result.laws.rows()
    if len(compared) == 1:
        return (of_law,)
    listing = Listing(LAW_HEADINGS, tuple(law_cells(compared)), tuple(range(1, len(LAW_HEADINGS))))
    return (of_law, (listing, "Laws compared: chi-square and p by themselves, evidence with what departs from them"))


def _remarks(result: JointFit) -> tuple[str, ...]:
    return tuple(remark for remark in (result.remark, result.remark_on_laws) if remark)


def determined_section(found: Identifiability, remark: str) -> Section:
    """Return what the data determine, as a fit of any kind tells it."""
    rows = tuple(
        (
            one.name.removeprefix("layers."),
            with_unit(one.median, one.unit),
            " to ".join(with_unit(end, one.unit) for end in one.posterior),
            " to ".join(with_unit(end, one.unit) for end in one.posterior_90),
            percent(one.share),
            one.verdict,
        )
        for one in found.findings
        if not one.nuisance
    )
    headings = ("parameter", "median", "68 %", "90 %", "from the data", "verdict")
    remarks = [*(group.text for group in found.groups), *([remark] if remark else [])]
    caption = f"The data determine {found.n_determined:.1f} of {len(found.findings)} parameters, nuisances included."
    return Section(
        "What the data determine",
        listings=((Listing(headings, rows, (1, 2, 3, 4)), caption),),
        remarks=tuple(remarks[:_MOST_SENTENCES]),
    )


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
            "yes" if row["accepted"] else "no",
        )
        for row in rows
    )
    headings = ("f / Hz", f"E1 / {unit}", f"E2 / {unit}", "E2/E1", "worst Δtof / µs", "worst Δlevel / dB", "accepted")
    table = (Listing(headings, cells, tuple(range(6))), "")
    if len(rows) <= _MOST_ROWS:
        return Section("Moduli at the bursts", listings=(table,))
    ends = Listing(headings, (cells[0], cells[len(cells) // 2], cells[-1]), tuple(range(6)))
    return Section(
        "Moduli at the bursts",
        listings=((ends, "First, middle and last"),),
        folded=Section("Every frequency", listings=(table,)),
    )
