"""Reports as HTML files for screen and paper: verdict first, without scripts or anything from outside."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Any

from multilayer.report.listing import Listing, flat_items
from multilayer.report.svg import inline_svg

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PACKAGES = ("multilayer", "numpy", "scipy")


@dataclass(frozen=True)
class Picture:
    """A figure as an SVG element, and what stands below it."""

    svg: str
    caption: str

    @property
    def markup(self) -> Any:
        """The element, not to be escaped: drawn by this package, and the names in it escaped."""
        from markupsafe import Markup

        return Markup(self.svg)


def picture(figure: Figure, name: str, caption: str) -> Picture:
    """Return a figure for a page on which no other has that name; the caption says what it shows."""
    return Picture(inline_svg(figure, name, caption), caption)


@dataclass(frozen=True)
class Section:
    """A part of the evidence; what is `folded` away can be opened on a screen and is left out on paper.

    Attributes
    ----------
    title : str
    pictures : tuple of Picture
    listings : tuple of (Listing, str)
        Tables with their captions.
    remarks : tuple of str
    folded : Section or None
    """

    title: str
    pictures: tuple[Picture, ...] = ()
    listings: tuple[tuple[Listing, str], ...] = ()
    remarks: tuple[str, ...] = ()
    folded: Section | None = None


@dataclass(frozen=True)
class Page:
    """What a report says.

    Attributes
    ----------
    name, kind : str
        Of what the report is, and of which command.
    label : str
        The verdict in a word or two.
    good : bool or None
        Whether the reader can rely on it, or must mind something; None where that is no question.
    sentence : str
    facts : tuple of (str, str)
        The numbers that matter most.
    note : str
    sections : tuple of Section
    inputs : mapping
        What the result was made from; versions are added.
    """

    name: str
    kind: str
    label: str
    good: bool | None
    sentence: str
    facts: tuple[tuple[str, str], ...]
    sections: tuple[Section, ...]
    inputs: Mapping[str, Any]
    note: str = ""


def page_html(page: Page) -> str:
    """Return a report as an HTML file."""
    said = {name: value for name, value in page.inputs.items() if name != "version"}  # of the file's format
    inputs = [*flat_items(said), *versions()]
    return render("page.html", {"page": page, "inputs": inputs})


def versions() -> list[tuple[str, str]]:
    """Return what computed a result, by name."""
    return [*((name, version(name)) for name in _PACKAGES), ("Python", platform.python_version())]


def render(template: str, content: Mapping[str, Any]) -> str:
    """Return a filled template of this package; everything that is not marked as markup is escaped."""
    from jinja2 import Environment, PackageLoader, StrictUndefined  # heavy: only when a report is written

    loader = PackageLoader("multilayer.report")
    options: Any = {"undefined": StrictUndefined, "trim_blocks": True, "lstrip_blocks": True}
    return Environment(loader=loader, autoescape=True, **options).get_template(template).render(content)
