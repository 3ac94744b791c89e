"""Figures as SVG to be put into an HTML page: their text and axes take the colour of the page's own text."""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

from multilayer.doors import for_page
from multilayer.report.style import any_script

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_BLACK = re.compile(r"#000000|#000\b")
_WHITE = re.compile(r"#ffffff|#fff\b")
_FONT = re.compile(r"font: (?:(?P<weight>\w+) )?(?P<size>[\d.]+px) [^;]*")  # as some versions of matplotlib write it
_FAMILY = re.compile(r"font-family:[^;]*;? ?")
_LONG = re.compile(r"\d+\.\d{3,}")
_REFERENCE = re.compile(r"url\(#([^)]+)\)")
_NO_METADATA = dict.fromkeys(("Creator", "Date", "Format", "Type"))


def inline_svg(figure: Figure, name: str, label: str) -> str:
    """Return a figure as an ``<svg>`` element without background, fonts, scripts or references to anything outside.

    Parameters
    ----------
    figure : Figure
    name : str
        Precedes every id, which must differ between the figures of a page.
    label : str
        What it shows, for those who have the page read aloud.
    """
    from matplotlib import rc_context
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    buffer = io.StringIO()
    canvas: Any = FigureCanvasSVG(figure)  # savefig would draw all of it twice, first to lay it out
    # text stays text: it can be found, read aloud and takes the page's font and colour
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": name}), any_script(), _without_background(figure):
        canvas.print_svg(buffer, metadata=_NO_METADATA)
    root = ElementTree.fromstring(for_page(buffer.getvalue()))
    _cleaned(root, name)
    _with_classes(root, name)
    root.set("aria-label", label)
    return ElementTree.tostring(root, encoding="unicode")


@contextmanager
def _without_background(figure: Figure) -> Iterator[None]:
    """Leave out what lies behind a figure and its axes; the figure is given back as it was."""
    resolution = figure.dpi  # that of SVG would stay
    parts: list[Any] = [figure, *figure.axes, *(inset for axis in figure.axes for inset in axis.child_axes)]
    patches = [part.patch for part in parts]
    shown = [patch.get_visible() for patch in patches]
    for patch in patches:
        patch.set_visible(False)
    try:
        yield
    finally:
        for patch, before in zip(patches, shown, strict=True):
            patch.set_visible(before)
        figure.dpi = resolution


def _cleaned(root: ElementTree.Element, name: str) -> None:
    for element in root.iter():
        element.tag = _local(element.tag)
        # line breaks between elements, not the text of labels
        element.text, element.tail = (t if t and t.strip() else None for t in (element.text, element.tail))
        for child in list(element):
            # a style sheet in here would hold for the whole page
            if _local(child.tag) in ("metadata", "style"):
                element.remove(child)
        attributes = dict(element.attrib)
        element.attrib.clear()
        for key, value in attributes.items():
            element.set(_local(key), _rewritten(_local(key), value, name))
    for key in ("width", "height", "version"):
        root.attrib.pop(key, None)
    root.set("role", "img")


def _with_classes(root: ElementTree.Element, name: str) -> None:
    """Put what attributes `style` say into one style sheet, which a page can allow by its hash."""
    classes: dict[str, str] = {}
    for element in root.iter():
        if style := element.attrib.pop("style", "").strip():
            element.set("class", classes.setdefault(style, f"{name}-s{len(classes)}"))
    sheet = ElementTree.Element("style")
    sheet.text = "".join(f".{key}{{{style}}}" for style, key in classes.items())
    root.insert(0, sheet)


def _local(name: str) -> str:
    return name.rpartition("}")[2]


def _rewritten(key: str, value: str, name: str) -> str:
    if key == "id":
        return f"{name}-{value}"
    if key == "href" and value.startswith("#"):
        return f"#{name}-{value[1:]}"
    if key in ("d", "x", "y", "transform"):
        return " ".join(_LONG.sub(lambda found: f"{float(found[0]):.2f}", value).split())
    value = _REFERENCE.sub(lambda found: f"url(#{name}-{found[1]})", value)
    if key in ("style", "fill", "stroke"):
        value = _BLACK.sub("currentColor", value)
        value = _WHITE.sub("var(--paper, #fff)", value)
        value = _FAMILY.sub("", value)
        value = _FONT.sub(lambda font: f"font-size: {font['size']}; font-weight: {font['weight'] or 'normal'}", value)
    return value
