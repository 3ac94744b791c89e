"""The report of a joint fit: one modulus law for all bursts."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from multilayer.fits.joint.laws import LawRow
from multilayer.fits.joint.posterior import modulus_band, motion_curves
from multilayer.fits.joint.result import JointFit
from multilayer.inference.posterior import Posterior
from multilayer.number_text import pressure_unit, significant, with_unit
from multilayer.report.fit import moduli_listing, moduli_span
from multilayer.report.identifiability import determined_section
from multilayer.report.listing import Listing
from multilayer.report.report import Draw, Picture, Report, Section
from multilayer.report.style import WIDTH, blank, colour, finished, plain

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_MOST_ROWS = 18
_LEAST_P = 1e-12  # nobody knows the tail beyond
_CURVE = 200
_INNER, _OUTER = 0.68, 0.9


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
        tables=result.tables,
        record={**result.to_dict(), "inputs": inputs},
        record_file=result.record_name,
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
    rows = result.laws.rows()
    columns: dict[str, Callable[[LawRow], str]] = {
        "law": lambda row: row.law,
        ">unknowns": lambda row: str(row.n_parameters),
        ">chi-square": lambda row: f"{row.chi_square:.4g}",
        ">p": lambda row: f"{row.p_value:.2g}",
        ">ln evidence": lambda row: f"{row.log_evidence:.1f}",
        ">probability": lambda row: f"{row.probability:.2g}",
        ">departs / %": lambda row: f"{100 * row.deviation:.2g}",
    }
    caption = "Laws compared: chi-square and p by themselves, evidence with what departs from them"
    return [Listing.of(rows, columns, caption=caption)] if len(rows) > 1 else []


def _moduli(rows: list[dict[str, Any]]) -> Section:
    title, whole = "Moduli at the bursts", moduli_listing(rows, worst="worst ")
    if len(rows) <= _MOST_ROWS:
        return Section(title, listings=(whole,))
    ends = moduli_listing([rows[0], rows[len(rows) // 2], rows[-1]], worst="worst ", caption="First, middle and last")
    return Section(title, listings=(ends,), folded=Section("Every frequency", listings=(whole,)))


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
    curves = motion_curves(result, posterior, _OUTER)
    figure, axes = blank(len(curves), 2, (9, 2.0 * len(curves) + 0.8), sharex=True)
    for row, (name, curve) in zip(axes, curves.items(), strict=True):
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
        axes[1, 0].plot(f, -360 * f * delay, **options)  # what arrives later has less phase
    for axis, label in zip(axes[:, 0], ("level / dB", "phase / degrees"), strict=True):
        axis.axhline(0, color="0.4", linewidth=0.8)
        axis.set_ylabel(label)
    axes[1, 0].set_xlabel("frequency / Hz")
    title = f"measured minus modelled, chi-square {result.best.cost:.4g} for {result.n_data} data"
    return finished(figure, axes[0, 0], f"{plain(result.campaign)}: {title}", upright=upright, ncols=3)
