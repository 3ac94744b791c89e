"""What the data determine, as a fit of any kind tells it."""

from __future__ import annotations

from multilayer.inference.identifiability import Identifiability
from multilayer.report.listing import Listing, Tinted
from multilayer.report.numbers import percent, with_unit
from multilayer.report.report import Section

_COLOURS = {"determined": "green", "narrowed": "yellow", "not determined": "red"}


def determined_section(found: Identifiability, remark: str = "", *, nuisances: bool = True) -> Section:
    """Return what the data determine: parameters, and the combinations that are known better than their members.

    A terminal has SI units and words, a page intervals in units that are easy to read.

    Parameters
    ----------
    found : Identifiability
    remark : str
        What else a reader should know.
    nuisances : bool
        Whether a terminal shows those, too.
    """
    count = f"the data determine {found.n_determined:.1f} of {len(found.findings)} parameters"
    wanted = [finding for finding in found.findings if not finding.nuisance]
    on_console = Listing.of(
        found.findings if nuisances else wanted,
        {
            "parameter": lambda one: one.name,
            "unit": lambda one: one.unit,
            ">median": lambda one: f"{one.median:.3g}",
            ">std": lambda one: f"{one.posterior_std:.3g}",
            ">prior std": lambda one: f"{one.prior_std:.3g}",
            ">from the data": lambda one: Tinted(f"{100 * one.share:.0f} %", _COLOURS[one.verdict]),
            "in words": lambda one: one.text,
        },
        caption=count,
        only="console",
    )
    on_page = Listing.of(
        wanted,
        {
            "parameter": lambda one: one.name.removeprefix("layers."),
            ">median": lambda one: with_unit(one.median, one.unit),
            ">68 %": lambda one: " to ".join(with_unit(end, one.unit) for end in one.posterior),
            ">90 %": lambda one: " to ".join(with_unit(end, one.unit) for end in one.posterior_90),
            ">from the data": lambda one: percent(one.share),
            "verdict": lambda one: one.verdict,
        },
        caption=f"T{count[1:]}, nuisances included.",
        only="page",
    )
    remarks = (*(group.text for group in found.groups), *filter(None, [remark]))
    return Section("What the data determine", listings=(on_console, on_page), remarks=remarks)
