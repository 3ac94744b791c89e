"""The table of what the data determine."""

from __future__ import annotations

from rich.table import Table
from rich.text import Text

from multilayer.inference.collinearity import Group
from multilayer.inference.identifiability import Finding, Identifiability
from multilayer.report.console import console

_STYLES = {"determined": "green", "narrowed": "yellow", "not determined": "red"}


def identifiability_table(found: Identifiability, *, nuisances: bool = True) -> None:
    """Print one row per parameter, and the combinations that are known better than their members.

    Parameters
    ----------
    found : Identifiability
    nuisances : bool
        Whether those have rows, too, and combinations of nothing but them a line.
    """
    out = console()
    heading = f"the data determine {found.n_determined:.1f} of {len(found.findings)} parameters"
    out.print(Text(heading, style="italic"))
    table = Table(box=None, pad_edge=False)
    for name in ("parameter", "unit"):
        table.add_column(name)
    for name in ("median", "std", "prior std", "from the data"):
        table.add_column(name, justify="right", no_wrap=True)
    table.add_column("in words", overflow="fold")
    for finding in found.findings:
        if nuisances or not finding.nuisance:
            table.add_row(*_cells(finding))
    out.print(table)
    own = {finding.name for finding in found.findings if finding.nuisance}
    for group in found.groups:
        if nuisances or not own.issuperset(group.names):
            out.print(_bullet(group))


def _cells(finding: Finding) -> list[str | Text]:
    numbers = (finding.median, finding.posterior_std, finding.prior_std)
    share = Text(f"{100 * finding.share:.0f} %", style=_STYLES[finding.verdict])
    # as Text: names may hold what rich takes for markup
    return [Text(finding.name), finding.unit, *(f"{value:.3g}" for value in numbers), share, Text(finding.text)]


def _bullet(group: Group) -> Text:
    return Text(f"- {group.text}")
