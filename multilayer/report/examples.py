"""The list of examples."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from multilayer.examples import WHAT, examples
from multilayer.report.listing import Listing
from multilayer.report.report import Report, Section


def examples_report(names: Sequence[str] = ()) -> Report:
    """Return the examples, or some of them, with what they show.

    Raises
    ------
    InputError
        When the package was installed without them.
    """
    known = examples()
    chosen = [name for name in known if not names or name in names]
    columns: dict[str, Callable[[str], str]] = {"example": str, "shows": lambda name: WHAT[name]}
    note = "`multilayer examples NAME` copies one to the folder examples, `--out DIR` elsewhere."
    listing = Listing.of(chosen, columns, notes=(note,))
    record = [{"name": name, "shows": WHAT[name], "file": str(known[name])} for name in chosen]
    return Report(kind="examples", sections=(Section("", listings=(listing,)),), record=record)
