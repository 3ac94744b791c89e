"""What the data determine, as a fit of any kind tells it."""

from __future__ import annotations

from multilayer.inference.identifiability import Identifiability
from multilayer.number_text import percent, with_unit
from multilayer.report.listing import Listing, Tinted
from multilayer.report.report import Section

_COLOURS = {"determined": "green", "narrowed": "yellow", "not determined": "red"}


def determined_section(known: Identifiability, remark: str = "", *, nuisances: bool = True) -> Section:
    """Return what the data determine: parameters, and the combinations that are known better than their members.

    A terminal has SI units and words, a page intervals in units that are easy to read.

    Parameters
    ----------
    known : Identifiability
    remark : str
        What else a reader should know.
    nuisances : bool
        Whether a terminal shows those, too.
    """
    count = f"the data determine {known.n_determined:.1f} of {len(known.findings)} parameters"
    wanted = [finding for finding in known.findings if not finding.nuisance]
    on_console = Listing.of(
        known.findings if nuisances else wanted,
        {
            "parameter": lambda finding: finding.name,
            "unit": lambda finding: finding.unit,
            ">median": lambda finding: f"{finding.median:.3g}",
            ">std": lambda finding: f"{finding.posterior_std:.3g}",
            ">prior std": lambda finding: f"{finding.prior_std:.3g}",
            ">from the data": lambda finding: Tinted(f"{100 * finding.share:.0f} %", _COLOURS[finding.verdict]),
            "in words": lambda finding: finding.text,
        },
        caption=count,
        only="console",
    )
    on_page = Listing.of(
        wanted,
        {
            "parameter": lambda finding: finding.name.removeprefix("layers."),
            ">median": lambda finding: with_unit(finding.median, finding.unit),
            ">68 %": lambda finding: " to ".join(with_unit(end, finding.unit) for end in finding.posterior),
            ">90 %": lambda finding: " to ".join(with_unit(end, finding.unit) for end in finding.posterior_90),
            ">from the data": lambda finding: percent(finding.share),
            "verdict": lambda finding: finding.verdict,
        },
        caption=f"T{count[1:]}, nuisances included.",
        only="page",
    )
    remarks = (*(group.text for group in known.groups), *filter(None, [remark]))
    return Section("What the data determine", listings=(on_console, on_page), remarks=remarks)
