"""Reports as HTML files for screen and paper: verdict first, without scripts or anything from outside."""

from __future__ import annotations

import platform
import re
from base64 import b64encode
from collections.abc import Iterable, Mapping
from dataclasses import replace
from hashlib import sha256
from importlib import resources
from importlib.metadata import version
from typing import Any

from multilayer.doors import for_page
from multilayer.report.listing import flat_items
from multilayer.report.report import Draw, Report, Section

_PACKAGES = ("multilayer", "numpy", "scipy")
_STYLE = re.compile(r"<style>([^<]*)</style>")
_MOST_ROWS, _MOST_REMARKS = 30, 12  # of what is not folded away


def page_html(report: Report, svgs: Mapping[Draw, str]) -> str:
    """Return a report as an HTML file, with its pictures as SVG elements by what draws them."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # heavy: only when a report is written
    from markupsafe import Markup

    given = {name: value for name, value in report.inputs.items() if name != "version"}  # of the file's format
    versions = [*((name, version(name)) for name in _PACKAGES), ("Python", platform.python_version())]
    style = Markup(f"\n{resources.files(__package__).joinpath('templates/style.css').read_text(encoding='utf-8')}")
    content = {
        "policy": _policy([style, *(sheet for svg in svgs.values() for sheet in _STYLE.findall(svg))]),
        "style": style,
        "report": report,
        "sections": [_shortened(section, report) for section in (*_to_mind(report), *report.sections)],
        "svgs": {draw: Markup(svg) for draw, svg in svgs.items()},  # drawn by this package, and names in it escaped
        "inputs": [*flat_items(given), *(pair for pair in versions if pair[0] not in given)],
    }
    options: Any = {"undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    environment = Environment(loader=PackageLoader("multilayer.report"), autoescape=True, **options)
    return for_page(environment.get_template("page.html").render(content))


def _policy(styles: Iterable[str]) -> str:
    """Return what a page may do, as browsers read it: nothing but show itself with the style sheets of its own."""
    digests = (b64encode(sha256(style.encode()).digest()).decode() for style in styles)
    allowed = " ".join(f"'sha256-{digest}'" for digest in dict.fromkeys(digests))
    return f"default-src 'none'; style-src {allowed}; base-uri 'none'; form-action 'none'"


def _to_mind(report: Report) -> tuple[Section, ...]:
    return (Section("What to mind", remarks=report.warnings),) if report.warnings else ()


def _shortened(section: Section, report: Report) -> Section:
    """Return a section as a page has it: without what only a terminal shows, and long lists cut."""
    listings = [listing for listing in section.listings if listing.only != "console" and listing.rows]
    left = sum(max(len(part.rows) - _MOST_ROWS, len(part.notes) - _MOST_ROWS, 0) for part in listings)
    left += max(len(section.remarks) - _MOST_REMARKS, 0)
    files = " and ".join([*report.tables, *filter(None, [report.record_file])])
    more = (f"{left} more, see {files}.",) if left else ()
    cut = (replace(part, rows=part.rows[:_MOST_ROWS], notes=part.notes[:_MOST_ROWS]).filled() for part in listings)
    beside = section.beside and _shortened(section.beside, report)
    if beside and not (beside.listings or beside.items or beside.remarks or beside.empty):
        beside = None
    remarks = (*section.remarks[:_MOST_REMARKS], *more)
    return replace(section, listings=tuple(cut), remarks=remarks, beside=beside)
