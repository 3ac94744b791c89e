"""What the data determine, as a fit of any kind tells it."""

from __future__ import annotations

from multilayer.inference.identifiability import Finding, Identifiability
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
        Whether a terminal shows those, too, and both combinations of nothing but them.
    """
    count = f"the data determine {found.n_determined:.1f} of {len(found.findings)} parameters"
    wanted = [finding for finding in found.findings if not finding.nuisance]
    others = {finding.name for finding in found.findings if finding.nuisance}
    on_console = Listing(
        ("parameter", "unit", "median", "std", "prior std", "from the data", "in words"),
        tuple(map(_in_si, found.findings if nuisances else wanted)),
        (2, 3, 4, 5),
        count,
        only="console",
    )
    on_page = Listing(
        ("parameter", "median", "68 %", "90 %", "from the data", "verdict"),
        tuple(map(_readable, wanted)),
        (1, 2, 3, 4),
        f"T{count[1:]}, nuisances included.",
        only="page",
    )
    groups = [group.text for group in found.groups if nuisances or not others.issuperset(group.names)]
    remarks = (*groups, *filter(None, [remark]))
    return Section("What the data determine", listings=(on_console, on_page), remarks=remarks)


def _in_si(one: Finding) -> tuple[str, ...]:
    numbers = (f"{value:.3g}" for value in (one.median, one.posterior_std, one.prior_std))
    return one.name, one.unit, *numbers, Tinted(f"{100 * one.share:.0f} %", _COLOURS[one.verdict]), one.text


def _readable(one: Finding) -> tuple[str, ...]:
    intervals = (" to ".join(with_unit(end, one.unit) for end in ends) for ends in (one.posterior, one.posterior_90))
    name = one.name.removeprefix("layers.")
    return name, with_unit(one.median, one.unit), *intervals, percent(one.share), one.verdict
